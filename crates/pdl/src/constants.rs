//! Messages about constants without a value. The caller computes constants, because this crate cannot evaluate.

use crate::check::Checked;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::source::Place;
use apex_model::symbol::Symbol;

/// Adds an error for each constant in `failures`: its name, the place of the expression that failed, and the reason.
pub fn report_constants(checked: &mut Checked, failures: Vec<(Symbol, Place, String)>) {
    let mut locator = Locator::new(&checked.library.sources);
    let told = failures.into_iter().map(|(name, place, reason)| {
        let message = format!("the constant `{name}` has no value");
        Diagnostic::error(codes::CONSTANT_FAILS, locator.span(place), message).reason(reason)
    });
    let told: Vec<Diagnostic> = told.collect();
    checked.diagnostics.extend(told);
    checked.diagnostics.sort_by_key(|each| (each.span.file, each.span.line, each.span.column, each.severity));
}

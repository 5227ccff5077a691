//! `(replenish NAME [AMOUNT])` of resources that cannot be replenished, and amounts of another dimension: the form would fail.

use super::kinds::{Kind, Kinds, is_zero};
use super::walk;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::{Library, ResourceKind};
use apex_model::value::Value;

/// The places of forms, and the findings.
type ReplenishFindings<'l> = (Locator<'l>, Vec<Diagnostic>);

/// Returns all findings in the library.
pub(super) fn findings(library: &Library) -> Vec<Diagnostic> {
    let mut report = (Locator::new(&library.sources), Vec::new());
    walk::library(library, &mut |expr| form(library, expr, &mut report));
    report.1
}

fn form(library: &Library, expr: &Expr, report: &mut ReplenishFindings<'_>) {
    let ExprKind::Call { function, arguments } = &expr.kind else { return };
    let [name @ Expr { kind: ExprKind::Constant(Value::Symbol(resource)), .. }, amount @ ..] = arguments.as_slice()
    else {
        return;
    };
    let Some(declared) = library.resources.get(resource).filter(|_| function.is("replenish")) else { return };
    let ResourceKind::Renewable(total) = &declared.kind else {
        let message = format!("`{resource}` cannot be replenished");
        let diagnostic = Diagnostic::error(codes::OPERAND, report.0.span(name.place), message)
            .label(report.0.span(declared.place), "it is not declared as renewable")
            .help(format!("declare it: `(resource {resource} :renewable AMOUNT)`"));
        return report.1.push(diagnostic);
    };
    let (Some((_, dimension)), Some(amount)) = (total.as_number(), amount.first()) else { return };
    match Kinds::of(library, amount) {
        Kind::Number(found) if found != dimension && !is_zero(amount) => {
            let (wanted, found) = (Kind::Number(dimension).words(), Kind::Number(found).words());
            let message = format!("`{resource}` is {wanted}, but this amount is {found}");
            let diagnostic = Diagnostic::error(codes::DIMENSION, report.0.span(amount.place), message)
                .label(report.0.span(declared.place), "declared here");
            report.1.push(diagnostic);
        }
        _ => {}
    }
}

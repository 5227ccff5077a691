//! Dimensions in the expressions of derived state variables: sums of inputs with different dimensions, and values of another dimension
//! than declared. Every sample of such a variable would be missing.

use super::kinds::{Kind, Kinds, ONE_DIMENSION, is_zero};
use super::walk;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::derivation::{Derivation, DerivationInput, Reading};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use std::collections::BTreeMap;

/// Kinds of the inputs by their names in the expression.
type Inputs<'l> = BTreeMap<&'l Symbol, Kind>;

/// The places of forms, and the findings.
type DerivationFindings<'l> = (Locator<'l>, Vec<Diagnostic>);

/// Returns all findings in the library.
pub(super) fn findings(library: &Library) -> Vec<Diagnostic> {
    let mut report = (Locator::new(&library.sources), Vec::new());
    for (attribute, derivation) in &library.derivations {
        let inputs = inputs(library, derivation);
        let mut found = false;
        walk::expr(&derivation.value, &mut |expr| found |= sum(library, &inputs, expr, &mut report));
        if !found {
            value(library, attribute, derivation, &inputs, &mut report);
        }
    }
    report.1
}

fn inputs<'l>(library: &'l Library, derivation: &'l Derivation) -> Inputs<'l> {
    derivation.inputs.iter().map(|input| (&input.name, kind_of(library, input))).collect()
}

fn kind_of(library: &Library, input: &DerivationInput) -> Kind {
    let declared = library.state_variables.get(&input.attribute).filter(|declared| declared.unit.is_some());
    let Some(dimension) = declared.map(|declared| declared.dimension) else { return Kind::Unknown };
    match input.reads {
        Reading::Value | Reading::Previous => Kind::Number(dimension),
        Reading::Rate => Kind::Number(dimension.over(Dimension::TIME)),
        Reading::Changed => Kind::Unknown,
    }
}

/// Reports a sum or comparison of inputs of different dimensions. Returns true if it did.
fn sum(library: &Library, inputs: &Inputs<'_>, expr: &Expr, report: &mut DerivationFindings<'_>) -> bool {
    let ExprKind::Call { function, arguments } = &expr.kind else { return false };
    if !ONE_DIMENSION.contains(&function.folded()) {
        return false;
    }
    let numbers = arguments.iter().filter(|argument| !is_zero(argument)).filter_map(|argument| {
        match Kinds::with(library, inputs.clone(), argument) {
            kind @ Kind::Number(_) => Some((argument, kind)),
            _ => None,
        }
    });
    let numbers: Vec<(&Expr, Kind)> = numbers.collect();
    let Some((first, known)) = numbers.first() else { return false };
    let Some((other, found)) = numbers.iter().find(|(_, kind)| kind != known) else { return false };
    let (known, found) = (known.words(), found.words());
    let message = format!("cannot apply `{function}` to {known} and {found}");
    let diagnostic = Diagnostic::error(codes::DIMENSION, report.0.span(other.place), message)
        .label(report.0.span(first.place), format!("this is {known}"))
        .reason("no value could be computed, so the derived variable would have no sample");
    report.1.push(diagnostic);
    true
}

/// Reports a value of another dimension than the declared unit has. A bare number is in that unit.
fn value(
    library: &Library,
    attribute: &Symbol,
    derivation: &Derivation,
    inputs: &Inputs<'_>,
    report: &mut DerivationFindings<'_>,
) {
    let declared = library.state_variables.get(attribute).filter(|declared| declared.unit.is_some());
    let Some(declared) = declared else { return };
    let Kind::Number(found) = Kinds::with(library, inputs.clone(), &derivation.value) else { return };
    if found == declared.dimension || found == Dimension::NONE || is_zero(&derivation.value) {
        return;
    }
    let (wanted, found) = (Kind::Number(declared.dimension).words(), Kind::Number(found).words());
    let message = format!("`({attribute} ..)` is {wanted}, but its expression yields {found}");
    let diagnostic = Diagnostic::error(codes::DIMENSION, report.0.span(derivation.value.place), message)
        .label(report.0.span(declared.place), format!("declared as {wanted} here"))
        .reason("samples of another dimension are refused");
    report.1.push(diagnostic);
}

//! Calls of the program's own functions with values for which a sum or comparison in the function fails.

use super::kinds::{Kind, Kinds, SumMismatch};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::symbol::Symbol;

/// Returns the message about `expr`, if it is a call for which a sum or comparison in the function fails.
pub(super) fn mismatch(library: &Library, expr: &Expr, locator: &mut Locator<'_>) -> Option<Diagnostic> {
    let ExprKind::Call { function, arguments } = &expr.kind else { return None };
    if !library.functions.contains_key(function) {
        return None;
    }
    let kinds: Vec<Kind> = arguments.iter().map(|argument| Kinds::of(library, argument)).collect();
    if let Some(mismatch) = Kinds::mismatch_in(library, function, &kinds) {
        return Some(diagnostic(function, expr, mismatch, locator));
    }
    for (number, argument) in arguments.iter().enumerate() {
        for alternative in alternatives(argument) {
            let mut kinds = kinds.clone();
            kinds.iter_mut().skip(number).take(1).for_each(|kind| *kind = Kinds::of(library, alternative));
            if let Some(mismatch) = Kinds::mismatch_in(library, function, &kinds) {
                return Some(diagnostic(function, alternative, mismatch, locator));
            }
        }
    }
    None
}

/// Returns the expressions of which one gives the value of `expr`: the parts of an `or`, the branches of an `if` that has both. Empty for
/// any other expression.
fn alternatives(expr: &Expr) -> Vec<&Expr> {
    match &expr.kind {
        ExprKind::Or(parts) => parts.iter().collect(),
        ExprKind::If(_, then, Some(otherwise)) => vec![then, otherwise],
        _ => Vec::new(),
    }
}

fn diagnostic(function: &Symbol, at: &Expr, mismatch: SumMismatch, locator: &mut Locator<'_>) -> Diagnostic {
    let SumMismatch { function: inner, kinds: [known, found], place } = mismatch;
    let message =
        format!("`({function} ..)` fails here: it cannot apply `{inner}` to {} and {}", known.words(), found.words());
    Diagnostic::error(codes::DIMENSION, locator.span(at.place), message)
        .label(locator.span(place), "computed here")
        .reason("only values of one dimension can be added or compared")
}

//! Sums and comparisons with variables of goals whose dimension follows from their other uses: a depth that a command takes as a length
//! is not compared with a time.

use super::findings::Findings;
use super::types::Types;
use crate::analysis::kinds::{Kind, Kinds, ONE_DIMENSION, is_zero};
use crate::analysis::methods::Method;
use crate::analysis::walk;
use crate::codes;
use crate::diagnostic::Diagnostic;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use std::collections::BTreeMap;

pub(super) fn check(library: &Library, types: &Types<'_>, findings: &mut Findings<'_>) {
    for (number, procedure) in library.procedures.iter().enumerate() {
        let variables = types.dimensions(Method::Procedure(number));
        if !variables.is_empty() {
            walk::procedure(procedure, &mut |expr| sum(library, expr, &variables, findings));
        }
    }
    for (number, primitive) in library.primitives.iter().enumerate() {
        let variables = types.dimensions(Method::Primitive(number));
        if !variables.is_empty() {
            walk::primitive(primitive, &mut |expr| sum(library, expr, &variables, findings));
        }
    }
}

fn sum(library: &Library, expr: &Expr, variables: &BTreeMap<&Symbol, Kind>, findings: &mut Findings<'_>) {
    let ExprKind::Call { function, arguments } = &expr.kind else { return };
    if !ONE_DIMENSION.contains(&function.folded()) {
        return;
    }
    let counted = || arguments.iter().filter(|argument| !is_zero(argument));
    let numbers: Vec<Kind> = counted()
        .map(|argument| Kinds::with(library, variables.clone(), argument))
        .filter(|kind| matches!(kind, Kind::Number(_)))
        .collect();
    let plain: Vec<Kind> =
        counted().map(|argument| Kinds::of(library, argument)).filter(|kind| matches!(kind, Kind::Number(_))).collect();
    // A difference that exists without the variables is reported elsewhere.
    let (Some(different), None) = (differing(&numbers), differing(&plain)) else { return };
    let [known, found] = different.map(Kind::words);
    let message = format!("cannot apply `{function}` to {known} and {found}");
    let diagnostic = Diagnostic::error(codes::DIMENSION, findings.locator.span(expr.place), message)
        .reason("the dimension of a goal's variable follows from the command or goal that it is an argument of");
    findings.add(diagnostic);
}

fn differing(kinds: &[Kind]) -> Option<[Kind; 2]> {
    let first = *kinds.first()?;
    kinds.iter().find(|kind| **kind != first).map(|other| [first, *other])
}

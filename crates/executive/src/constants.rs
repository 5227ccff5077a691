//! Constants: every `defconstant` that is an expression is computed once, as the agent is loaded.

use crate::expression::{Surroundings, evaluate};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::symbol::Symbol;

/// The constants of `library` that are not written as values, with their values.
///
/// # Errors
/// Place and reason of the first constant that has no value.
pub(crate) fn compute(library: &Library, surroundings: &dyn Surroundings) -> Result<Vec<(Symbol, Expr)>, String> {
    let mut values: Vec<(Symbol, Expr)> = Vec::new();
    for (name, expr) in &library.constants {
        if matches!(expr.kind, ExprKind::Constant(_)) {
            continue;
        }
        let value = evaluate(expr, surroundings).map_err(|error| {
            let place = library.describe_place(error.place);
            format!("{place}: the constant `{name}` has no value: {}", error.message)
        })?;
        values.push((name.clone(), Expr { kind: ExprKind::Constant(value), place: expr.place }));
    }
    Ok(values)
}

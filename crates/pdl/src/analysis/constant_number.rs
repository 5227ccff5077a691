//! The value of an expression that is computed from literals only.

use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::quantity::Dimension;

/// Maximum nesting that is followed.
const DEPTH_MAX: usize = 16;

/// Returns the number, in SI units, and its dimension if the expression always has this value.
pub(super) fn constant_number(library: &Library, expr: &Expr) -> Option<(f64, Dimension)> {
    of(library, expr, DEPTH_MAX)
}

fn of(library: &Library, expr: &Expr, depth: usize) -> Option<(f64, Dimension)> {
    let depth = depth.checked_sub(1)?;
    match &expr.kind {
        ExprKind::Constant(value) => value.as_number(),
        ExprKind::Indexical(name) => of(library, library.indexicals.get(name)?, depth),
        ExprKind::Call { function, arguments } if !library.functions.contains_key(function) => {
            let (first, rest) = arguments.split_first()?;
            let first = of(library, first, depth)?;
            let rest = rest.iter().map(|argument| of(library, argument, depth)).collect::<Option<Vec<_>>>()?;
            computed(function.folded(), first, &rest)
        }
        _ => None,
    }
}

fn computed(function: &str, first: (f64, Dimension), rest: &[(f64, Dimension)]) -> Option<(f64, Dimension)> {
    let is_one_dimension = rest.iter().all(|(_, dimension)| *dimension == first.1);
    let numbers = rest.iter().map(|(number, _)| *number);
    match function {
        "-" if rest.is_empty() => Some((-first.0, first.1)),
        "-" if is_one_dimension => Some((first.0 - numbers.sum::<f64>(), first.1)),
        "+" if is_one_dimension => Some((first.0 + numbers.sum::<f64>(), first.1)),
        "min" if is_one_dimension => Some((numbers.fold(first.0, f64::min), first.1)),
        "max" if is_one_dimension => Some((numbers.fold(first.0, f64::max), first.1)),
        "*" => Some(rest.iter().fold(first, |(product, of), (number, by)| (product * number, of.times(*by)))),
        _ => None,
    }
}

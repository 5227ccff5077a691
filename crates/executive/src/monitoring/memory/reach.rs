//! Reach into the past (M&I)
//! What: computes how far in the past constraints on time and the instants of queries can lie.
//! Runs: when a library is surveyed, and when a monitor is created.
//! Reads: expressions, the library's constants.
//! Writes: nothing.
//! Bound: linear in the constraints.
//! PDL: `:timestamp`, `:timing`, `(- +now+ D)`.
//! Paper: section IV, policies on logged data quantity.

use apex_model::condition::{Constraint, Relation};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Depth up to which definitions that refer to other definitions are followed.
const DEFINITIONS_MAX: u32 = 8;

/// Returns the span before now within which all of `constraints` on an instant can hold; `None` if there is no such span.
pub(crate) fn of_constraints(constraints: &[Constraint], library: &Library) -> Option<Duration> {
    let earliest = constraints.iter().filter_map(|constraint| match constraint {
        Constraint::Compare {
            relation: Relation::Greater | Relation::GreaterOrEqual | Relation::Equal,
            right,
            tolerance: None,
        } => before_now(right, library),
        Constraint::Range(Some(least), _) => before_now(least, library),
        _ => None,
    });
    earliest.min()
}

/// Returns the time between the instant that `expr` names and now, if that is a literal: `+now+`, `(- +now+ P10M)`.
pub(crate) fn before_now(expr: &Expr, library: &Library) -> Option<Duration> {
    match &expr.kind {
        ExprKind::Indexical(name) if name.is("now") => Some(Duration::ZERO),
        ExprKind::Call { function, arguments } if function.is("-") => match arguments.as_slice() {
            [from, back] => Some(before_now(from, library)? + duration(back, library)?),
            _ => None,
        },
        _ => None,
    }
}

/// Returns the duration of `expr` if it is a literal or a constant defined as one.
pub(crate) fn duration(expr: &Expr, library: &Library) -> Option<Duration> {
    let mut expr = expr;
    for _ in 0..DEFINITIONS_MAX {
        expr = match &expr.kind {
            ExprKind::Constant(Value::Duration(duration)) => {
                return Some(*duration).filter(|span| *span >= Duration::ZERO);
            }
            ExprKind::Indexical(name) => library.indexicals.get(name)?,
            ExprKind::Named(name) => library.constants.get(name)?,
            _ => return None,
        };
    }
    None
}

//! Constraints of orders (M&I)
//! What: translates constraints between the tags of neighbouring parts into limits of the time between their points.
//! Runs: when the monitor of an order is made.
//! Reads: the order.
//! Writes: nothing.
//! Bound: O(constraints * parts).
//! PDL: `:constraint` in an `:in-order`.
//! Paper: Table 1, row 11.

use crate::monitoring::combination::point_steps::{PointRole, points};
use crate::monitoring::episodes::episode::limits_of;
use crate::state::monitors::monitor::Composite;
use apex_model::condition::Relation;
use apex_model::expression::{Expr, ExprKind};
use apex_model::time::Duration;
use apex_model::value::Value;

/// The least and the greatest time from one point of an order to the next one.
pub(crate) type GapLimits = (Duration, Duration);

/// No limit.
const ANY: GapLimits = (Duration(i64::MIN), Duration::MAX);

/// Returns, for each point of the order, the limits that the constraints set on the time from the preceding point; `None` if a constraint
/// states something else.
pub(crate) fn limits(composite: &Composite) -> Option<Vec<GapLimits>> {
    let mut limits = vec![ANY; points(composite).len()];
    composite.constraints.iter().all(|each| add(each, composite, &mut limits)).then_some(limits)
}

/// Adds a constraint to the limits; returns false if it states something else.
fn add(constraint: &Expr, composite: &Composite, limits: &mut [GapLimits]) -> bool {
    let ExprKind::Call { function, arguments } = &constraint.kind else {
        return match &constraint.kind {
            ExprKind::And(parts) => parts.iter().all(|part| add(part, composite, limits)),
            _ => false,
        };
    };
    let [left, right] = arguments.as_slice() else { return false };
    let Some(relation) = relation(function.folded()) else { return false };
    let (relation, between, length) = match (length(left), length(right)) {
        (None, Some(length)) => (relation, left, length),
        (Some(length), None) => (turned(relation), right, length),
        _ => return false,
    };
    let Some((place, (least, most))) = place_of(between, composite).zip(limits_of(relation, length)) else {
        return false;
    };
    let Some(limit) = limits.get_mut(place) else { return false };
    *limit = (limit.0.max(least), limit.1.min(most));
    true
}

fn relation(function: &str) -> Option<Relation> {
    Some(match function {
        "<" => Relation::Less,
        "<=" => Relation::LessOrEqual,
        ">" => Relation::Greater,
        ">=" => Relation::GreaterOrEqual,
        "=" => Relation::Equal,
        _ => return None,
    })
}

/// Returns the relation of the right side to the left side.
fn turned(relation: Relation) -> Relation {
    match relation {
        Relation::Less => Relation::Greater,
        Relation::LessOrEqual => Relation::GreaterOrEqual,
        Relation::Greater => Relation::Less,
        Relation::GreaterOrEqual => Relation::LessOrEqual,
        Relation::Equal | Relation::Different => relation,
    }
}

fn length(expr: &Expr) -> Option<Duration> {
    match &expr.kind {
        ExprKind::Constant(Value::Duration(length)) => Some(*length),
        _ => None,
    }
}

/// Returns the place of the later one of two neighbouring points whose distance the expression states.
fn place_of(expr: &Expr, composite: &Composite) -> Option<usize> {
    let ExprKind::Call { function, arguments } = &expr.kind else { return None };
    let (earlier, later) = match (function.folded(), arguments.as_slice()) {
        ("-", [later, earlier]) => (point(earlier, composite)?, point(later, composite)?),
        ("duration-of", [tag]) => (end_of("start-of", tag, composite)?, end_of("end-of", tag, composite)?),
        _ => return None,
    };
    (later == earlier + 1).then_some(later)
}

/// Returns the place of the point that `(start-of ?tag)` or `(end-of ?tag)` names.
fn point(expr: &Expr, composite: &Composite) -> Option<usize> {
    let ExprKind::Call { function, arguments } = &expr.kind else { return None };
    let [tag] = arguments.as_slice() else { return None };
    end_of(function.folded(), tag, composite)
}

fn end_of(edge: &str, tag: &Expr, composite: &Composite) -> Option<usize> {
    let role = match edge {
        "start-of" => PointRole::Start,
        "end-of" => PointRole::End,
        _ => return None,
    };
    let ExprKind::Variable { name, .. } = &tag.kind else { return None };
    let part = composite.parts.iter().position(|part| part.tag.as_ref() == Some(name))?;
    points(composite).iter().position(|(index, of)| *index == part && (*of == role || *of == PointRole::Whole))
}

//! Constraints between points (M&I)
//! What: translates constraints between the tags of parts into limits of the time between their points.
//! Runs: when the monitor of an order or of a conjunction is made.
//! Reads: the order or the conjunction.
//! Writes: nothing.
//! Bound: O(constraints * parts).
//! PDL: `:constraint` in an `:in-order` or an `:and`.
//! Paper: Table 1, row 11.

use crate::monitoring::combination::point_steps::{PointRole, points};
use crate::monitoring::episodes::episode::limits_of;
use crate::state::monitors::monitor::{Composite, PointLimit};
use apex_model::condition::Relation;
use apex_model::expression::{Expr, ExprKind};
use apex_model::time::Duration;
use apex_model::value::Value;
use std::cmp::Ordering;

/// The least and the greatest time from one point of an order to the next one.
pub(crate) type GapLimits = (Duration, Duration);

/// No limit.
const ANY: GapLimits = (Duration(i64::MIN), Duration::MAX);

/// Returns, for each point of the order, the limits that the constraints set on the time from the preceding point, and the limits between
/// points that are not neighbours; `None` if a constraint states something else.
pub(crate) fn limits(composite: &Composite) -> Option<(Vec<GapLimits>, Vec<PointLimit>)> {
    let mut gaps = vec![ANY; points(composite).len()];
    let mut far = Vec::new();
    for limit in between(composite)? {
        match gaps.get_mut(limit.second).filter(|_| limit.second == limit.first + 1) {
            Some(gap) => *gap = (gap.0.max(limit.least), gap.1.min(limit.most)),
            None => far.push(limit),
        }
    }
    Some((gaps, far))
}

/// Returns the limits that the constraints set on the time between points of the parts, one for each pair of points; `None` if a constraint
/// states something else.
pub(crate) fn between(composite: &Composite) -> Option<Vec<PointLimit>> {
    let mut limits = Vec::new();
    composite.constraints.iter().all(|each| add(each, composite, &mut limits)).then_some(limits)
}

/// Adds a constraint to the limits; returns false if it states something else.
fn add(constraint: &Expr, composite: &Composite, limits: &mut Vec<PointLimit>) -> bool {
    let ExprKind::Call { function, arguments } = &constraint.kind else {
        return match &constraint.kind {
            ExprKind::And(parts) => parts.iter().all(|part| add(part, composite, limits)),
            _ => false,
        };
    };
    let [left, right] = arguments.as_slice() else { return false };
    let Some(relation) = relation(function.folded()) else { return false };
    let (relation, places, length) = match (length(left), length(right)) {
        (None, Some(length)) => (relation, places_of(left, composite), length),
        (Some(length), None) => (turned(relation), places_of(right, composite), length),
        // An order of two instants is that of their distance and zero.
        _ => (relation, point(right, composite).zip(point(left, composite)), Duration::ZERO),
    };
    let Some(((first, second), (least, most))) = places.zip(limits_of(relation, length)) else { return false };
    let limit = match first.cmp(&second) {
        Ordering::Less => PointLimit { first, second, least, most },
        Ordering::Equal => return false,
        Ordering::Greater => {
            let (least, most) = (Duration(most.0.saturating_neg()), Duration(least.0.saturating_neg()));
            PointLimit { first: second, second: first, least, most }
        }
    };
    match limits.iter_mut().find(|other| (other.first, other.second) == (limit.first, limit.second)) {
        Some(other) => (other.least, other.most) = (other.least.max(limit.least), other.most.min(limit.most)),
        None => limits.push(limit),
    }
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

/// Returns the places of the two points for which the expression states the time from the first one to the second one.
fn places_of(expr: &Expr, composite: &Composite) -> Option<(usize, usize)> {
    let ExprKind::Call { function, arguments } = &expr.kind else { return None };
    match (function.folded(), arguments.as_slice()) {
        ("-", [second, first]) => Some((point(first, composite)?, point(second, composite)?)),
        ("duration-of", [tag]) => Some((end_of("start-of", tag, composite)?, end_of("end-of", tag, composite)?)),
        _ => None,
    }
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

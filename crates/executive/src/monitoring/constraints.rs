//! Constraints (M&I)
//! What: judges one value, object, instant or duration against constraints.
//! Runs: on every sample that is watched, and when results are formed.
//! Reads: evaluation context.
//! Writes: bindings, faults.
//! Bound: O(1) per constraint for fixed comparisons; else one bounded evaluation.
//! PDL: `REL expr +/- e`, `(:range a b)`, predicates.
//! Paper: Appendix B, constraints on individual measurements.

use super::pattern_matching::match_pattern;
use crate::expression::arithmetic::{compare, described, duration, equal, instant, with_unit};
use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError, WithBindings, evaluate};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Test, Tests};
use apex_model::condition::{Constraint, Relation};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::quantity::{Dimension, Unit};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::cmp::Ordering;

/// Interpretation of the right side of a comparison.
#[derive(Clone, Copy)]
pub(crate) enum RightSide {
    /// The number as written; a bare number has this unit.
    Value(Option<&'static Unit>),
    /// As an instant.
    Instant,
    /// As a duration.
    Span,
    /// The number as written; a bare number is multiplied by the factor and then has this dimension in SI.
    Scaled(f64, Dimension),
}

/// Prepares value constraints: comparisons whose right side never changes are evaluated once.
///
/// # Errors
/// When a right side that never changes cannot be evaluated.
pub(crate) fn prepare(
    constraints: &[Constraint],
    unit: Option<&'static Unit>,
    context: &dyn EvalContext,
) -> Result<Tests, EvaluationError> {
    prepare_as(constraints, RightSide::Value(unit), context)
}

/// Prepares value constraints like [`prepare`], with right sides evaluated by `reading`.
///
/// # Errors
/// When a right side that never changes cannot be evaluated.
pub(crate) fn prepare_as(
    constraints: &[Constraint],
    reading: RightSide,
    context: &dyn EvalContext,
) -> Result<Tests, EvaluationError> {
    constraints
        .iter()
        .zip(0..)
        .map(|(constraint, index)| match constraint {
            Constraint::Compare { relation, right, tolerance: None } if never_changes(right, context.library(), 8) => {
                let right = read(evaluate(right, context)?, reading, right.place)?;
                Ok(Test::Fixed { relation: *relation, right })
            }
            _ => Ok(Test::General(index)),
        })
        .collect()
}

/// Returns true if the expression has the same value at every evaluation.
pub(crate) fn never_changes(expr: &Expr, library: &Library, depth: u32) -> bool {
    let Some(depth) = depth.checked_sub(1) else { return false };
    match &expr.kind {
        ExprKind::Constant(_) => true,
        ExprKind::Indexical(name) => match name.folded() {
            "pos-infinity" => true,
            _ => library.indexicals.get(name).is_some_and(|definition| never_changes(definition, library, depth)),
        },
        ExprKind::Named(name) => {
            library.constants.get(name).is_some_and(|definition| never_changes(definition, library, depth))
        }
        ExprKind::Call { function, arguments } => {
            matches!(function.folded(), "+" | "-" | "*" | "/" | "quantity")
                && arguments.iter().all(|argument| never_changes(argument, library, depth))
        }
        _ => false,
    }
}

/// Returns true if `value` satisfies all `tests`, which were prepared from `constraints`. Patterns may bind variables.
///
/// # Errors
/// When a right side cannot be evaluated or compared.
pub(crate) fn satisfies_all(
    tests: &[Test],
    constraints: &[Constraint],
    value: &Value,
    attribute: &Symbol,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
    place: Place,
) -> Result<bool, EvaluationError> {
    let reading = || RightSide::Value(unit_of(attribute, context.library()));
    satisfies_all_as(tests, constraints, value, reading, bindings, context, place)
}

/// Like [`satisfies_all`], with right sides evaluated by `reading`.
///
/// # Errors
/// When a right side cannot be evaluated or compared.
pub(crate) fn satisfies_all_as(
    tests: &[Test],
    constraints: &[Constraint],
    value: &Value,
    reading: impl Fn() -> RightSide,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
    place: Place,
) -> Result<bool, EvaluationError> {
    for test in tests {
        let holds = match test {
            Test::Fixed { relation, right } => match value.order(right) {
                Some(order) => ordered(*relation, order),
                None => related(*relation, value, right, place)?,
            },
            Test::General(index) => {
                let Some(constraint) = constraints.get(*index as usize) else { continue };
                satisfies(constraint, value, reading(), bindings, context, place)?
            }
        };
        if !holds {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Compares `value` with the fixed operands of `tests`: `Some(false)` if one fails, `None` if that needs an evaluation.
pub(crate) fn satisfies_fixed(tests: &[Test], value: &Value) -> Option<bool> {
    let mut holds = true;
    for test in tests {
        match test {
            Test::Fixed { relation, right } => holds &= ordered(*relation, value.order(right)?),
            Test::General(_) => return None,
        }
    }
    Some(holds)
}

/// Returns true if `value` satisfies all `constraints`, with right sides evaluated by `reading`.
///
/// # Errors
/// When a right side cannot be evaluated or compared.
pub(crate) fn all(
    constraints: &[Constraint],
    value: &Value,
    reading: RightSide,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
    place: Place,
) -> Result<bool, EvaluationError> {
    for constraint in constraints {
        if !satisfies(constraint, value, reading, bindings, context, place)? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn satisfies(
    constraint: &Constraint,
    value: &Value,
    reading: RightSide,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
    place: Place,
) -> Result<bool, EvaluationError> {
    match constraint {
        Constraint::Compare { relation, right, tolerance } => {
            if let (Relation::Equal, None, ExprKind::Variable { name, must_be_bound: false }) =
                (relation, tolerance, &right.kind)
                && bindings.get(name).is_none()
                && context.variable(name).is_none()
            {
                bindings.set(name.clone(), value.clone());
                return Ok(true);
            }
            let side = |expr: &Expr| {
                let value = evaluate(expr, &WithBindings { below: context, bindings })?;
                read(value, reading, expr.place)
            };
            let right_value = side(right)?;
            match (relation, tolerance) {
                (Relation::Equal | Relation::Different, Some(tolerance)) => {
                    let near = within(value, &right_value, &side(tolerance)?, right.place)?;
                    Ok(near == (*relation == Relation::Equal))
                }
                _ => related(*relation, value, &right_value, right.place),
            }
        }
        Constraint::Matches(Pattern::Literal(literal)) if literal.as_number().is_some() => {
            related(Relation::Equal, value, &read(literal.clone(), reading, place)?, place)
        }
        Constraint::Matches(pattern) => match_pattern(pattern, value, bindings, context, place),
        Constraint::Predicate(predicate, arguments) => {
            let constant = Expr { kind: ExprKind::Constant(value.clone()), place };
            let arguments = std::iter::once(constant).chain(arguments.iter().cloned()).collect();
            let call = Expr { kind: ExprKind::Call { function: predicate.clone(), arguments }, place };
            evaluate(&call, &WithBindings { below: context, bindings }).map(|value| value.is_true())
        }
        Constraint::Range(least, most) => {
            for (bound, relation) in [(least, Relation::GreaterOrEqual), (most, Relation::LessOrEqual)] {
                let Some(bound) = bound else { continue };
                let right = evaluate(bound, &WithBindings { below: context, bindings })?;
                if !related(relation, value, &read(right, reading, bound.place)?, bound.place)? {
                    return Ok(false);
                }
            }
            Ok(true)
        }
    }
}

/// Returns the right side `right` as `reading` interprets it.
pub(crate) fn read(right: Value, reading: RightSide, place: Place) -> Result<Value, EvaluationError> {
    let error = |message| EvaluationError { message, place };
    match (reading, right.as_number()) {
        (RightSide::Value(Some(unit)), Some((number, Dimension::NONE))) if number.is_finite() => {
            Ok(with_unit(number, unit))
        }
        (RightSide::Scaled(factor, dimension), Some((number, Dimension::NONE))) if number.is_finite() => {
            Ok(Value::measured(number * factor, dimension))
        }
        (RightSide::Value(_) | RightSide::Scaled(..), _) => Ok(right),
        (RightSide::Instant, _) => instant(&right).map(Value::Time).map_err(error),
        (RightSide::Span, _) => duration(&right).map(Value::Duration).map_err(error),
    }
}

fn related(relation: Relation, value: &Value, right: &Value, place: Place) -> Result<bool, EvaluationError> {
    let error = |message| EvaluationError { message, place };
    match relation {
        Relation::Equal => equal(value, right).map_err(error),
        Relation::Different => equal(value, right).map(|equal| !equal).map_err(error),
        other => Ok(compare(value, right).map_err(error)?.is_some_and(|order| ordered(other, order))),
    }
}

fn ordered(relation: Relation, order: Ordering) -> bool {
    match relation {
        Relation::Equal => order.is_eq(),
        Relation::Different => order.is_ne(),
        Relation::Less => order.is_lt(),
        Relation::LessOrEqual => order.is_le(),
        Relation::Greater => order.is_gt(),
        Relation::GreaterOrEqual => order.is_ge(),
    }
}

fn within(value: &Value, right: &Value, tolerance: &Value, place: Place) -> Result<bool, EvaluationError> {
    if let (Value::Time(a), Value::Time(b)) = (value, right) {
        let tolerance = duration(tolerance).map_err(|message| EvaluationError { message, place })?;
        return Ok((*a - *b).0.abs() <= tolerance.0);
    }
    match (value.as_number(), right.as_number(), tolerance.as_number()) {
        (Some((a, da)), Some((b, db)), Some((t, dt))) if da == db && db == dt => Ok(a == b || libm::fabs(a - b) <= t),
        _ => Err(EvaluationError {
            message: format!(
                "cannot compare {} with {} +/- {}",
                described(value),
                described(right),
                described(tolerance)
            ),
            place,
        }),
    }
}

/// Returns true if the constraint is a lower bound, which stays satisfied as the value grows.
pub(crate) fn is_lower_bound(constraint: &Constraint) -> bool {
    match constraint {
        Constraint::Compare { relation: Relation::Greater | Relation::GreaterOrEqual, tolerance: None, .. } => true,
        Constraint::Range(Some(_), None) => true,
        Constraint::Compare { .. } | Constraint::Range(..) | Constraint::Matches(_) | Constraint::Predicate(..) => {
            false
        }
    }
}

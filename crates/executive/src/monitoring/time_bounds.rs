//! Time bounds (M&I)
//! What: computes the closed interval of instants that satisfy constraints on a time stamp, for values that hold between samples.
//! Runs: when a value of an estimator is requested.
//! Reads: evaluation context.
//! Writes: nothing.
//! Bound: linear in the constraints.
//! PDL: `:timestamp` under `:estimation`.
//! Paper: Table 1, rows 5 and 6.

use crate::expression::arithmetic::{duration, instant};
use crate::expression::{EvalContext, EvaluationError, evaluate};
use apex_model::condition::{Constraint, Relation};
use apex_model::expression::Expr;
use apex_model::source::Place;
use apex_model::time::{Duration, Time};

/// One tick of time: the difference between `(> D)` and `(>= D)`.
pub(crate) const TICK: Duration = Duration(1);

/// Closed bounds; an end that is not stated is open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TimeBounds {
    pub(crate) from: Option<Time>,
    pub(crate) to: Option<Time>,
}

impl TimeBounds {
    fn from(&mut self, at: Time) {
        self.from = Some(self.from.map_or(at, |before| before.max(at)));
    }

    fn to(&mut self, at: Time) {
        self.to = Some(self.to.map_or(at, |before| before.min(at)));
    }
}

/// Returns an instant that an expression gives.
///
/// # Errors
/// If it cannot be evaluated, or is not an instant.
pub(crate) fn instant_of(expr: &Expr, context: &dyn EvalContext) -> Result<Time, EvaluationError> {
    let value = evaluate(expr, context)?;
    instant(&value).map_err(|message| EvaluationError { message, place: expr.place })
}

/// Returns a duration that an expression gives.
///
/// # Errors
/// If it cannot be evaluated, or is not a duration.
pub(crate) fn duration_of(expr: &Expr, context: &dyn EvalContext) -> Result<Duration, EvaluationError> {
    let value = evaluate(expr, context)?;
    duration(&value).map_err(|message| EvaluationError { message, place: expr.place })
}

/// Returns the instants that satisfy all `constraints`.
///
/// # Errors
/// If a side cannot be evaluated, or a constraint is not a bound (the checker rejects those).
pub(crate) fn bounds(
    constraints: &[Constraint],
    context: &dyn EvalContext,
    place: Place,
) -> Result<TimeBounds, EvaluationError> {
    let mut found = TimeBounds::default();
    for constraint in constraints {
        match constraint {
            Constraint::Compare { relation, right, tolerance } => {
                let at = instant_of(right, context)?;
                let around = match tolerance {
                    Some(tolerance) => duration_of(tolerance, context)?,
                    None => Duration::ZERO,
                };
                match relation {
                    Relation::Equal => {
                        found.from(at - around);
                        found.to(at + around);
                    }
                    Relation::Less => found.to(at - TICK),
                    Relation::LessOrEqual => found.to(at),
                    Relation::Greater => found.from(at + TICK),
                    Relation::GreaterOrEqual => found.from(at),
                    Relation::Different => return Err(no_bound(right.place)),
                }
            }
            Constraint::Range(least, most) => {
                if let Some(least) = least {
                    found.from(instant_of(least, context)?);
                }
                if let Some(most) = most {
                    found.to(instant_of(most, context)?);
                }
            }
            Constraint::Matches(_) | Constraint::Predicate(..) => return Err(no_bound(place)),
        }
    }
    Ok(found)
}

fn no_bound(place: Place) -> EvaluationError {
    let message = "the time stamp of an estimated value can be bounded only by comparisons and ranges".to_owned();
    EvaluationError { message, place }
}

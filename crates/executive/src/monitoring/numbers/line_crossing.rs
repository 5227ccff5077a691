//! Line crossing (M&I)
//! What: finds the earliest instant of a window at which a least-squares line satisfies constraints on its value.
//! Runs: when a regression is evaluated.
//! Reads: evaluation context.
//! Writes: nothing.
//! Bound: linear in the constraints.
//! PDL: `:estimation :linear-regression`.
//! Paper: Table 1, row 6.

use crate::expression::arithmetic::described;
use crate::expression::{EvalContext, EvaluationError, WithBindings, evaluate};
use crate::monitoring::constraints::{RightSide, read};
use crate::state::bindings::Bindings;
use crate::state::monitors::moments::Moments;
use apex_model::condition::{Constraint, Relation};
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::quantity::{Dimension, Unit};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};

/// The values that satisfy the constraints: an interval, each end included or not, and the variables to bind to the value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ValueInterval {
    least: (f64, bool),
    greatest: (f64, bool),
    binds: Vec<Symbol>,
}

impl ValueInterval {
    fn at_least(&mut self, value: f64, closed: bool) {
        if value > self.least.0 || (value == self.least.0 && !closed) {
            self.least = (value, closed);
        }
    }

    fn at_most(&mut self, value: f64, closed: bool) {
        if value < self.greatest.0 || (value == self.greatest.0 && !closed) {
            self.greatest = (value, closed);
        }
    }

    fn contains(&self, value: f64) -> bool {
        let above = value > self.least.0 || (self.least.1 && value == self.least.0);
        above && (value < self.greatest.0 || (self.greatest.1 && value == self.greatest.0))
    }
}

/// Scale of a right side: values of this dimension, with bare numbers in this unit.
#[derive(Clone, Copy)]
pub(crate) struct ValueScale {
    pub(crate) unit: Option<&'static Unit>,
    pub(crate) dimension: Dimension,
}

/// Returns the SI number of an expression.
///
/// # Errors
/// If it cannot be evaluated, or has another dimension.
pub(crate) fn number_of(expr: &Expr, scale: ValueScale, context: &dyn EvalContext) -> Result<f64, EvaluationError> {
    let value = read(evaluate(expr, context)?, RightSide::Value(scale.unit), expr.place)?;
    match value.as_number() {
        Some((number, dimension)) if dimension == scale.dimension => Ok(number),
        _ => {
            let message = format!("{} is used where {} is needed", described(&value), scale.dimension);
            Err(EvaluationError { message, place: expr.place })
        }
    }
}

/// Returns the values that all `constraints` leave.
///
/// # Errors
/// If a side cannot be evaluated, or a constraint is not a bound (the checker rejects those).
pub(crate) fn band(
    constraints: &[Constraint],
    scale: ValueScale,
    bindings: &Bindings,
    context: &dyn EvalContext,
    place: Place,
) -> Result<ValueInterval, EvaluationError> {
    let mut band =
        ValueInterval { least: (f64::NEG_INFINITY, true), greatest: (f64::INFINITY, true), binds: Vec::new() };
    let seen = WithBindings { below: context, bindings };
    for constraint in constraints {
        match constraint {
            Constraint::Compare { relation: Relation::Equal, right, tolerance: None }
                if free(right, &seen).is_some() =>
            {
                band.binds.extend(free(right, &seen));
            }
            Constraint::Compare { relation, right, tolerance } => {
                let value = number_of(right, scale, &seen)?;
                match relation {
                    Relation::Equal => {
                        let around = tolerance.as_ref().map_or(Ok(0.0), |around| number_of(around, scale, &seen))?;
                        band.at_least(value - around, true);
                        band.at_most(value + around, true);
                    }
                    Relation::Less => band.at_most(value, false),
                    Relation::LessOrEqual => band.at_most(value, true),
                    Relation::Greater => band.at_least(value, false),
                    Relation::GreaterOrEqual => band.at_least(value, true),
                    Relation::Different => return Err(unsolvable(right.place)),
                }
            }
            Constraint::Range(least, most) => {
                if let Some(least) = least {
                    band.at_least(number_of(least, scale, &seen)?, true);
                }
                if let Some(most) = most {
                    band.at_most(number_of(most, scale, &seen)?, true);
                }
            }
            Constraint::Matches(Pattern::Variable(name)) if seen.variable(name).is_none() => {
                band.binds.push(name.clone());
            }
            Constraint::Matches(Pattern::Variable(name) | Pattern::BoundVariable(name)) => {
                let value = seen.variable(name).and_then(|value| value.as_number()).ok_or_else(|| unsolvable(place))?;
                band.at_least(value.0, true);
                band.at_most(value.0, true);
            }
            Constraint::Matches(_) | Constraint::Predicate(..) => return Err(unsolvable(place)),
        }
    }
    Ok(band)
}

/// Returns the variable on the right side, if it is not bound yet.
fn free(right: &Expr, seen: &dyn EvalContext) -> Option<Symbol> {
    match &right.kind {
        ExprKind::Variable { name, must_be_bound: false } => seen.variable(name).is_none().then(|| name.clone()),
        _ => None,
    }
}

fn unsolvable(place: Place) -> EvaluationError {
    let message = "the value of a line can be constrained only by comparisons and ranges of numbers".to_owned();
    EvaluationError { message, place }
}

/// Returns the earliest instant from `from` to `to` at which the line through `moments` lies within the interval, with the line's value
/// there; `None` if it never does, or there is no line.
pub(crate) fn earliest(moments: &Moments, band: &ValueInterval, from: Time, to: Time) -> Option<(Time, f64)> {
    let (mut first, mut last) = (from, to);
    match moments.slope_per_s()? {
        0.0 => {
            return (first <= last && band.contains(moments.line_at(first)?))
                .then_some((first, moments.line_at(first)?));
        }
        slope => {
            let rising = slope > 0.0;
            let (entry, exit) = if rising { (band.least, band.greatest) } else { (band.greatest, band.least) };
            if entry.0.is_finite() {
                first = first.max(crossing(moments, entry.0)?.first(entry.1));
            }
            if exit.0.is_finite() {
                let crossing = crossing(moments, exit.0)?;
                // If a single value is required that the line has between two ticks, the second tick counts.
                let between = entry == exit && entry.1 && !crossing.exact;
                last = last.min(if between { crossing.first(true) } else { crossing.last(exit.1) });
            }
        }
    }
    if first > last {
        return None;
    }
    Some((first, moments.line_at(first)?))
}

/// Instant at which a line has a value: exactly at a tick, or between it and the next one.
struct Crossing {
    /// The last tick that is not after the crossing.
    tick: Time,
    /// True if the crossing is at the tick itself.
    exact: bool,
}

impl Crossing {
    /// Returns the first tick at or after the crossing; after it if the value itself is excluded.
    fn first(&self, closed: bool) -> Time {
        if self.exact && closed { self.tick } else { self.tick + Duration(1) }
    }

    /// Returns the last tick at or before the crossing; before it if the value itself is excluded.
    fn last(&self, closed: bool) -> Time {
        if self.exact && !closed { self.tick - Duration(1) } else { self.tick }
    }
}

fn crossing(moments: &Moments, value: f64) -> Option<Crossing> {
    let (anchor, offset_ns) = moments.line_reaches(value)?;
    let nearest = libm::round(offset_ns);
    // A crossing this near to a tick differs from it by rounding alone.
    let rounding = (1e-3 + libm::fabs(offset_ns) * 4e-15).min(0.49);
    let exact = libm::fabs(offset_ns - nearest) <= rounding;
    let tick = if exact { nearest } else { libm::floor(offset_ns) };
    Some(Crossing { tick: anchor + Duration(tick as i64), exact })
}

/// Binds the variables of the interval to the value.
pub(crate) fn bind(band: &ValueInterval, value: f64, scale: ValueScale, bindings: &mut Bindings) {
    for name in &band.binds {
        bindings.set(name.clone(), crate::monitoring::numbers::aggregates::in_unit(value, scale.dimension, scale.unit));
    }
}

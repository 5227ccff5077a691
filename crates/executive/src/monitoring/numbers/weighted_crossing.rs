//! Weighted crossing (M&I)
//! What: finds the instants between samples at which a statistic weighted by time crosses a limit, as the value held last gains weight.
//! Runs: from statistic runs, for statistics weighted by time and a largest gap.
//! Reads: the moments of a run or window over time, evaluation context.
//! Writes: nothing.
//! Bound: logarithmic in the length of the span for each limit that is crossed, constant for others.
//! PDL: `:time-weighted`.
//! Paper: Table 1, rows 8 and 9.

use crate::expression::{EvalContext, evaluate};
use crate::monitoring::constraints::read;
use crate::monitoring::numbers::aggregates::reading;
use crate::monitoring::time_bounds::TICK;
use crate::state::monitors::moments::HeldMoments;
use crate::state::monitors::numbers::{Criterion, Measure};
use apex_model::condition::{Constraint, Relation};
use apex_model::expression::Expr;
use apex_model::time::{Duration, Time};

/// A side of a limit: values above the limit, or from it on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LimitSide {
    limit: f64,
    with_limit: bool,
}

impl LimitSide {
    /// Returns true if the value is on this side; false too if nothing has held for any time.
    fn contains(self, value: Option<f64>) -> bool {
        value.is_some_and(|value| if self.with_limit { value >= self.limit } else { value > self.limit })
    }
}

/// Statistics weighted by time, each with the limits of its constraints.
pub(crate) struct WeightedLimits(Vec<(Measure, Vec<LimitSide>)>);

impl WeightedLimits {
    /// Returns the limits of the criteria that are weighted by time; `None` if there are none. Constraints that are not limits, such as
    /// predicates, have no crossing.
    pub(crate) fn of(criteria: &[Criterion], context: &dyn EvalContext) -> Option<WeightedLimits> {
        let weighted = criteria.iter().filter(|criterion| is_weighted(&criterion.measure));
        let limits: Vec<_> = weighted.map(|criterion| (criterion.measure.clone(), sides(criterion, context))).collect();
        (!limits.is_empty()).then_some(WeightedLimits(limits))
    }

    /// Adds the instants after `first` and up to `until` at which a statistic crosses a limit to the other instants, in order. Samples leave
    /// the window only at `instants`, which are in order.
    pub(crate) fn add_crossings(
        &self,
        (first, until): (Time, Time),
        instants: &mut Vec<Time>,
        held: &dyn Fn(Time) -> HeldMoments,
    ) {
        let mut crossings = Vec::new();
        let mut from = first;
        for at in instants.iter().copied().filter(|at| *at > first) {
            // A sample leaves the window one tick after its weight begins to fall.
            crossings.extend(self.crossings((from, at - TICK), held));
            from = at;
        }
        crossings.extend(self.crossings((from, until), held));
        instants.extend(crossings);
        instants.sort_unstable();
        instants.dedup();
    }

    /// Returns the instants after `from` and up to `to` at which a statistic has crossed a limit. `held` returns the moments at an instant;
    /// between `from` and `to` one value at most gains weight, and one at most loses it.
    fn crossings(&self, (from, to): (Time, Time), held: &dyn Fn(Time) -> HeldMoments) -> Vec<Time> {
        let mut found = Vec::new();
        if from >= to {
            return found;
        }
        // The first value has no weight when it arrives, and any weight one tick later.
        let mut begin = from;
        if held(from).mean().is_none() {
            begin = from + TICK;
            found.push(begin);
        }
        for (measure, sides) in &self.0 {
            let value = |at: Time| value_of(measure, held(at));
            let turn = turn(begin, to, held).filter(|_| *measure != Measure::HeldMean);
            // The turn lies between this tick and the next one.
            let after = turn.map(|at| at + TICK);
            let ends: Vec<Time> = [Some(begin), turn, after, Some(to)].into_iter().flatten().collect();
            for (first, last) in ends.iter().zip(ends.iter().skip(1)) {
                found.extend(sides.iter().filter_map(|side| crossing(*side, (*first, *last), &value)));
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// Returns true for a measure that is weighted by time.
pub(crate) fn is_weighted(measure: &Measure) -> bool {
    matches!(measure, Measure::HeldMean | Measure::HeldVariance | Measure::HeldStandardDeviation)
}

fn value_of(measure: &Measure, held: HeldMoments) -> Option<f64> {
    match measure {
        Measure::HeldMean => held.mean(),
        Measure::HeldVariance => held.variance(),
        Measure::HeldStandardDeviation => held.variance().map(libm::sqrt),
        _ => None,
    }
}

/// Returns the sides of the limits in the constraints. A limit that cannot be computed is reported where the criterion is judged.
fn sides(criterion: &Criterion, context: &dyn EvalContext) -> Vec<LimitSide> {
    let number = |expr: &Expr| {
        let value = read(evaluate(expr, context).ok()?, reading(criterion.bare), expr.place).ok()?;
        value.as_number().map(|(number, _)| number).filter(|number| number.is_finite())
    };
    let mut sides = Vec::new();
    // Values from the least one on, and values above the greatest one.
    let mut range = |least: Option<f64>, greatest: Option<f64>| {
        sides.extend(least.map(|limit| LimitSide { limit, with_limit: true }));
        sides.extend(greatest.map(|limit| LimitSide { limit, with_limit: false }));
    };
    for constraint in &criterion.constraints {
        match constraint {
            Constraint::Compare { relation, right, tolerance } => {
                let limit = number(right);
                match relation {
                    Relation::Greater | Relation::LessOrEqual => range(None, limit),
                    Relation::GreaterOrEqual | Relation::Less => range(limit, None),
                    Relation::Equal | Relation::Different => {
                        let around = tolerance.as_ref().map_or(Some(0.0), &number);
                        let ends = limit.zip(around);
                        range(ends.map(|(limit, around)| limit - around), ends.map(|(limit, around)| limit + around));
                    }
                }
            }
            Constraint::Range(least, greatest) => {
                range(least.as_ref().and_then(&number), greatest.as_ref().and_then(&number));
            }
            Constraint::Matches(_) | Constraint::Predicate(..) => {}
        }
    }
    sides
}

/// Returns the first instant at which the value is on another side of the limit than at `first`. From `first` to `last` the value only
/// rises or only falls.
fn crossing(side: LimitSide, (first, last): (Time, Time), value: &dyn Fn(Time) -> Option<f64>) -> Option<Time> {
    let before = side.contains(value(first));
    if first >= last || side.contains(value(last)) == before {
        return None;
    }
    let (mut known, mut crossed) = (first, last);
    while known + TICK < crossed {
        let middle = known + Duration((crossed - known).0 / 2);
        if side.contains(value(middle)) == before { known = middle } else { crossed = middle }
    }
    Some(crossed)
}

/// Returns the instant between `from` and `to` at which the variance is greatest; `None` if it only rises or only falls. With `w` the sum
/// of the weights, which is linear in time, and `q = w^2 variance`, which is quadratic, the variance has its extremum where
/// `q' w = 2 q w'`, which is linear in time.
fn turn(from: Time, to: Time, held: &dyn Fn(Time) -> HeldMoments) -> Option<Time> {
    let length = to - from;
    let middle = Duration(length.0 / 2);
    let q = |held: HeldMoments| held.variance().map(|variance| held.weight_ns() * held.weight_ns() * variance);
    let (first, last) = (held(from), held(to));
    let (w0, w1) = (first.weight_ns(), last.weight_ns() - first.weight_ns());
    // q(s) = q0 + q1 s + q2 s^2 through three points, s from 0 to 1; the middle is a whole instant, at half the length or a little less.
    let (q0, half, end) = (q(first)?, q(held(from + middle))?, q(last)?);
    let share = middle.0 as f64 / length.0 as f64;
    let q2 = ((end - q0) - (half - q0) / share) / (1.0 - share);
    let q1 = (end - q0) - q2;
    let at = (2.0 * w1 * q0 - q1 * w0) / (2.0 * q2 * w0 - w1 * q1);
    // Also false where a division by zero leaves no number.
    (at > 0.0 && at < 1.0).then(|| from + Duration((at * length.0 as f64) as i64))
}

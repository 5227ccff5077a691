//! Aggregates (M&I)
//! What: computes the statistics and trends of an episode's criteria, and judges them.
//! Runs: whenever a run or window of numbers is evaluated.
//! Reads: moments, histories (`:custom` only), evaluation context.
//! Writes: nothing.
//! Bound: O(1) per criterion; a median O(log n); `:custom` O(samples of the episode).
//! PDL: `:stats`, `:trend`.
//! Paper: Table 1, rows 8 and 9.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::constraints::{RightSide, prepare_as, satisfies_all_as};
use crate::monitoring::numbers::significance::slope_by_chance;
use crate::state::bindings::Bindings;
use crate::state::monitors::moments::{HeldMoments, Moments};
use crate::state::monitors::numbers::{Criterion, Measure};
use apex_model::agent_limits::Limit;
use apex_model::condition::{Constraint, EpisodeCondition};
use apex_model::estimate::Aggregate;
use apex_model::event::StateVariable;
use apex_model::quantity::{Dimension, Quantity, Unit};
use apex_model::source::Place;
use apex_model::time::Time;
use apex_model::value::Value;

/// Returns the criteria of an episode, statistics first.
///
/// # Errors
/// When a right side that never changes cannot be evaluated.
pub(crate) fn criteria(
    condition: &EpisodeCondition,
    context: &dyn EvalContext,
) -> Result<Vec<Criterion>, EvaluationError> {
    let unit = unit_of(&condition.variable.attribute, context.library());
    let groups = condition.stats.iter().chain(&condition.trend);
    let measured = groups.filter_map(|(name, constraints)| Some((measure(name.folded(), constraints)?, constraints)));
    measured
        .map(|(measure, constraints)| {
            let bare = bare(&measure, unit);
            let constraints = if let Measure::Significance(_) = measure { Vec::new() } else { constraints.clone() };
            let tests = prepare_as(&constraints, reading(bare), context)?;
            Ok(Criterion { measure, constraints, tests, bare })
        })
        .collect()
}

fn measure(name: &str, constraints: &[Constraint]) -> Option<Measure> {
    Some(match name {
        "mean" => Measure::Mean,
        "count" => Measure::Count,
        "stddev" => Measure::StandardDeviation,
        "variance" => Measure::Variance,
        "sum" => Measure::Sum,
        "difference" => Measure::Difference,
        "min" => Measure::Least,
        "max" => Measure::Greatest,
        "median" => Measure::Median,
        "time-weighted-mean" => Measure::HeldMean,
        "time-weighted-variance" => Measure::HeldVariance,
        "time-weighted-stddev" => Measure::HeldStandardDeviation,
        "rate" => Measure::Rate,
        "step" => Measure::Step,
        "frequency" => Measure::Frequency,
        "custom" => Measure::Custom,
        "significance" => match constraints.first() {
            Some(Constraint::Compare { right, .. }) => Measure::Significance(right.clone()),
            _ => return None,
        },
        _ => return None,
    })
}

/// Returns the name of a measure: its PDL keyword without the colon.
pub(crate) fn name(measure: &Measure) -> &'static str {
    match measure {
        Measure::Mean => "mean",
        Measure::Count => "count",
        Measure::StandardDeviation => "stddev",
        Measure::Variance => "variance",
        Measure::Sum => "sum",
        Measure::Difference => "difference",
        Measure::Least => "min",
        Measure::Greatest => "max",
        Measure::Median => "median",
        Measure::HeldMean => "time-weighted-mean",
        Measure::HeldVariance => "time-weighted-variance",
        Measure::HeldStandardDeviation => "time-weighted-stddev",
        Measure::Rate => "rate",
        Measure::Step => "step",
        Measure::Frequency => "frequency",
        Measure::Custom => "custom",
        Measure::Significance(_) => "significance",
    }
}

/// Returns the meaning of a bare number on a right side: factor to SI and dimension.
fn bare(measure: &Measure, unit: Option<&'static Unit>) -> Option<(f64, Dimension)> {
    let unit = unit?;
    match measure {
        Measure::Count | Measure::Frequency | Measure::Custom | Measure::Significance(_) => None,
        Measure::Variance | Measure::HeldVariance => {
            Some((unit.factor * unit.factor, unit.dimension.times(unit.dimension)))
        }
        Measure::Rate => Some((unit.factor, unit.dimension.over(Dimension::TIME))),
        _ => Some((unit.factor, unit.dimension)),
    }
}

/// Returns how a right side is read: a bare number is scaled.
pub(crate) fn reading(bare: Option<(f64, Dimension)>) -> RightSide {
    bare.map_or(RightSide::Value(None), |(factor, dimension)| RightSide::Scaled(factor, dimension))
}

/// Returns an SI number as a value that prints in `unit`.
pub(crate) fn in_unit(si: f64, dimension: Dimension, unit: Option<&'static Unit>) -> Value {
    match Value::measured(si, dimension) {
        Value::Quantity(quantity) => match unit.filter(|unit| unit.dimension == dimension) {
            Some(unit) => Value::Quantity(Quantity { unit: Quantity::of(1.0, unit).unit, ..quantity }),
            None => Value::Quantity(quantity),
        },
        other => other,
    }
}

/// The numbers of a run or window, gathered.
#[derive(Clone, Debug, Default)]
pub(crate) struct RunStatistics {
    /// Moments of all of them.
    pub(crate) moments: Moments,
    /// Moments over time.
    pub(crate) held: HeldMoments,
    /// The median, if a criterion needs it.
    pub(crate) median: Option<f64>,
    /// True if there were more numbers than are kept in order; the median is then unknown.
    pub(crate) is_overfull: bool,
    /// The last two numbers, older first.
    pub(crate) last_two: Option<(f64, f64)>,
    /// True if a step does not satisfy the constraints on steps.
    pub(crate) bad_step: bool,
    /// For a sliding window: whether its first value satisfies the constraint; `None` if the newest sample is the only one.
    pub(crate) first_holds: Option<bool>,
    /// First and last sample's instant.
    pub(crate) interval: (Time, Time),
}

/// Verdict of a criterion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CriterionResult {
    /// The criterion is satisfied by this value.
    Holds(Value),
    /// The criterion is not satisfied by this value.
    Fails(Value),
    /// There is no value, for this reason.
    Undefined(&'static str),
}

/// Context in which a criterion is judged.
pub(crate) struct CriterionContext<'a> {
    pub(crate) variable: &'a StateVariable,
    pub(crate) dimension: Dimension,
    pub(crate) context: &'a dyn EvalContext,
    pub(crate) place: Place,
}

impl CriterionContext<'_> {
    /// Judges one criterion.
    ///
    /// # Errors
    /// When a right side cannot be evaluated or compared.
    pub(crate) fn judge(
        &self,
        criterion: &Criterion,
        numbers: &RunStatistics,
    ) -> Result<CriterionResult, EvaluationError> {
        let value = match &criterion.measure {
            Measure::Significance(level) => return self.significance(level, &numbers.moments),
            Measure::Custom => self.values(numbers.interval)?,
            Measure::Step => match numbers.last_two {
                None => return Ok(CriterionResult::Undefined("fewer than two numbers: no step")),
                Some((before, last)) => {
                    let value = self.measured(last - before, &criterion.measure);
                    return Ok(if numbers.bad_step {
                        CriterionResult::Fails(value)
                    } else {
                        CriterionResult::Holds(value)
                    });
                }
            },
            measure => match computed(measure, numbers) {
                Err(reason) => return Ok(CriterionResult::Undefined(reason)),
                Ok(number) if !number.is_finite() => {
                    return Ok(CriterionResult::Undefined("it is not a finite number"));
                }
                Ok(number) => self.measured(number, measure),
            },
        };
        let holds = satisfies_all_as(
            &criterion.tests,
            &criterion.constraints,
            &value,
            || reading(criterion.bare),
            &mut Bindings::new(),
            self.context,
            self.place,
        )?;
        Ok(if holds { CriterionResult::Holds(value) } else { CriterionResult::Fails(value) })
    }

    /// Returns true if the step between two numbers satisfies the constraints on steps.
    ///
    /// # Errors
    /// When a right side cannot be evaluated or compared.
    pub(crate) fn step_holds(&self, criterion: &Criterion, before: f64, after: f64) -> Result<bool, EvaluationError> {
        let value = self.measured(after - before, &criterion.measure);
        let mut bindings = Bindings::new();
        let read = || reading(criterion.bare);
        let Criterion { tests, constraints, .. } = criterion;
        satisfies_all_as(tests, constraints, &value, read, &mut bindings, self.context, self.place)
    }

    fn measured(&self, number: f64, measure: &Measure) -> Value {
        let dimension = self.dimension;
        let unit = unit_of(&self.variable.attribute, self.context.library());
        match measure {
            Measure::Count => Value::Integer(number as i64),
            Measure::Variance | Measure::HeldVariance => Value::measured(number, dimension.times(dimension)),
            Measure::Rate => Value::measured(number, dimension.over(Dimension::TIME)),
            Measure::Frequency => Value::measured(number, Dimension::FREQUENCY),
            _ => in_unit(number, dimension, unit),
        }
    }

    fn significance(
        &self,
        level: &apex_model::expression::Expr,
        moments: &Moments,
    ) -> Result<CriterionResult, EvaluationError> {
        let value = evaluate(level, self.context)?;
        let Some((level_number, Dimension::NONE)) = value.as_number() else {
            let message = format!(":significance is {value}, which is not a probability");
            return Err(EvaluationError { message, place: level.place });
        };
        Ok(match slope_by_chance(moments) {
            None => CriterionResult::Undefined("fewer than three numbers or two instants: no significance"),
            Some(chance) if chance <= level_number => CriterionResult::Holds(Value::Real(chance)),
            Some(chance) => CriterionResult::Fails(Value::Real(chance)),
        })
    }

    /// Returns the values of the episode, oldest first.
    fn values(&self, (start, end): (Time, Time)) -> Result<Value, EvaluationError> {
        let history = self.context.histories().get(self.variable);
        let samples = history.into_iter().flat_map(|history| history.between(start, end));
        let most = self.context.limits().count(Limit::CustomValues);
        let values: Vec<Value> = samples.take(most.saturating_add(1)).map(|sample| sample.value.clone()).collect();
        if values.len() > most {
            let message = format!("the limit {} = {most} of a condition was reached", Limit::CustomValues.constant());
            return Err(EvaluationError { message, place: self.place });
        }
        Ok(Value::list(values))
    }

    /// Returns the evidence for a criterion that holds.
    pub(crate) fn aggregate(&self, criterion: &Criterion, value: Value, numbers: &RunStatistics) -> Aggregate {
        let value = if criterion.measure == Measure::Custom { Value::truth(true) } else { value };
        Aggregate {
            variable: self.variable.clone(),
            name: name(&criterion.measure).to_owned(),
            value,
            interval: numbers.interval,
            samples: numbers.moments.count(),
        }
    }
}

/// Returns the number that a measure computes, in SI units, or the reason for which there is none.
fn computed(measure: &Measure, numbers: &RunStatistics) -> Result<f64, &'static str> {
    let RunStatistics { moments, held, median, .. } = numbers;
    let none = "no number yet";
    let no_time = "no value has held for longer than an instant yet";
    let one_instant = "fewer than two distinct instants";
    match measure {
        Measure::Mean => moments.mean().ok_or(none),
        // The count of an interval without samples is unknown, because samples may be missing.
        Measure::Count => moments.mean().map(|_| moments.count() as f64).ok_or(none),
        Measure::StandardDeviation => moments.variance().map(libm::sqrt).ok_or(none),
        Measure::Variance => moments.variance().ok_or(none),
        Measure::Sum => moments.sum().ok_or(none),
        Measure::Difference => moments.least().zip(moments.greatest()).map(|(low, high)| high - low).ok_or(none),
        Measure::Least => moments.least().ok_or(none),
        Measure::Greatest => moments.greatest().ok_or(none),
        Measure::Median => {
            median.ok_or(if numbers.is_overfull { "more numbers than are kept for a median" } else { none })
        }
        Measure::HeldMean => held.mean().filter(|_| moments.count() > 0).ok_or(no_time),
        Measure::HeldVariance => held.variance().filter(|_| moments.count() > 0).ok_or(no_time),
        Measure::HeldStandardDeviation => {
            held.variance().filter(|_| moments.count() > 0).map(libm::sqrt).ok_or(no_time)
        }
        Measure::Rate => moments.slope_per_s().ok_or(one_instant),
        Measure::Frequency => moments.frequency_hz().ok_or(one_instant),
        // `CriterionContext::judge` handles these three without this function.
        Measure::Step | Measure::Custom | Measure::Significance(_) => Err(none),
    }
}

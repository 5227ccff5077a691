//! Linear regression (M&I)
//! What: detects that the least-squares line through the samples satisfies the constraints at some instant of the window.
//! Runs: on every sample of the watched variable, and at the instant at which the line meets the constraint.
//! Reads: histories, evaluation context.
//! Writes: the regression part of a monitor.
//! Bound: O(1) per sample and object; a late sample fits all again.
//! PDL: `:estimation :linear-regression` and its options.
//! Paper: Table 1, row 6; Appendix B, constraints on estimators.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::numbers::aggregates::in_unit;
use crate::monitoring::numbers::line_crossing::{ValueScale, band, bind, earliest, number_of};
use crate::monitoring::part::{ConditionFaults, PartContext, Truth};
use crate::monitoring::sampled::{Sampled, object_bindings};
use crate::monitoring::samples::{SampleView, known_variable};
use crate::monitoring::time_bounds::{bounds, duration_of, instant_of};
use crate::monitoring::verdict_query::VerdictQuery;
use crate::planted::{self, Bug};
use crate::state::monitors::moments::{MAGNITUDE_MAX, Moments};
use crate::state::monitors::monitor::{Satisfaction, Window};
use crate::state::monitors::numbers::{Fit, RegressionPart};
use apex_model::because::Evidence;
use apex_model::condition::MeasurementCondition;
use apex_model::condition::VariablePattern;
use apex_model::estimate::{Estimate, Estimator, computed};
use apex_model::event::StateVariable;
use apex_model::expression::Expr;
use apex_model::limits::MONITOR_OBJECTS_MAX;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// A line needs two points.
const POINTS_MIN: u64 = 2;

/// Reason for which there is no reliable line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FitFailure {
    /// No sample of the variable is in the fit interval.
    NoSample,
    /// Older samples of the fit interval are no longer kept.
    Blind,
    /// Fewer samples than `:minimum-points`.
    TooFew { samples: u64, least: u64 },
    /// All samples have the same instant.
    OneInstant,
    /// A gap between samples, or after the last one, is too long.
    Gap { gap: Duration, most: Duration },
    /// The residuals are greater than `:maximum-error`.
    Error { error: Value, most: Value },
    /// An extrapolated value is further from the nearest sample's than `:maximum-difference`.
    Difference { difference: Value, most: Value },
}

impl fmt::Display for FitFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FitFailure::NoSample => f.write_str("no sample yet"),
            FitFailure::Blind => f.write_str("older samples are no longer kept"),
            FitFailure::TooFew { samples, least } => write!(f, "{samples} of at least {least} samples for a line"),
            FitFailure::OneInstant => f.write_str("all samples are of one instant: no line"),
            FitFailure::Gap { gap, most } => write!(f, "no line across a gap of {gap} > {most}"),
            FitFailure::Error { error, most } => write!(f, "the line's error {} > {}", computed(error), computed(most)),
            FitFailure::Difference { difference, most } => {
                let (difference, most) = (computed(difference), computed(most));
                write!(f, "the extrapolated value is {difference} from the nearest sample's, more than {most}")
            }
        }
    }
}

/// Returns the part for `condition`; it has not processed remembered samples yet. All options are evaluated now.
///
/// # Errors
/// When an option cannot be evaluated.
pub(crate) fn create(
    condition: &Arc<MeasurementCondition>,
    options: &[(Symbol, Expr)],
    context: &dyn EvalContext,
) -> Result<RegressionPart, EvaluationError> {
    let option = |name: &str| options.iter().find(|(found, _)| found.is(name)).map(|(_, expr)| expr);
    let (unit, declared) = declared_scale(&condition.variable.attribute, context);
    let number = |expr: &Expr| {
        let dimension = evaluate(expr, context)?.as_number().map_or(Dimension::NONE, |(_, dimension)| dimension);
        let dimension = declared.unwrap_or(dimension);
        number_of(expr, ValueScale { unit, dimension }, context)
    };
    let points_min = match option("minimum-points") {
        Some(expr) => match evaluate(expr, context)? {
            Value::Integer(points) if points >= 0 => points.unsigned_abs(),
            other => {
                let message = format!(":minimum-points is {other}, which is not a number of samples");
                return Err(EvaluationError { message, place: expr.place });
            }
        },
        None => POINTS_MIN,
    };
    Ok(RegressionPart {
        condition: Arc::clone(condition),
        variable: known_variable(&condition.variable, context),
        dimension: declared,
        points_min: points_min.max(POINTS_MIN),
        error_max: option("maximum-error").map(number).transpose()?,
        difference_max: option("maximum-difference").map(number).transpose()?,
        gap_max: option("minimum-frequency").map(|expr| duration_of(expr, context)).transpose()?,
        fit: (
            option("start").map(|expr| instant_of(expr, context)).transpose()?,
            option("end").map(|expr| instant_of(expr, context)).transpose()?,
        ),
        blind: false,
        objects: BTreeMap::new(),
    })
}

/// Returns the unit and dimension that values of `attribute` are declared with.
pub(crate) fn declared_scale(
    attribute: &Symbol,
    context: &dyn EvalContext,
) -> (Option<&'static apex_model::quantity::Unit>, Option<Dimension>) {
    let unit = unit_of(attribute, context.library());
    let declared = context.library().state_variables.get(attribute);
    (unit, declared.filter(|declared| declared.unit.is_some()).map(|declared| declared.dimension))
}

/// Returns the window of the fit: from `:start`, otherwise from the start of the part's window.
fn fit_window(part: &RegressionPart, site: PartContext) -> Window {
    match part.fit.0 {
        Some(start) => Window::from(start),
        None => site.window,
    }
}

impl Sampled for RegressionPart {
    fn pattern(&self) -> &VariablePattern {
        &self.condition.variable
    }

    fn variable(&self) -> Option<&StateVariable> {
        self.variable.as_ref()
    }

    fn newest(&self, object: &Value) -> Option<Time> {
        self.objects.get(object).and_then(Fit::last).map(|(at, _)| at)
    }

    fn begin_again(&mut self, _: PartContext, _: &dyn EvalContext, _: &mut ConditionFaults) {
        self.objects.clear();
    }

    fn note_blind(&mut self, blind: bool, _: Option<Time>) {
        self.blind = blind;
    }

    fn feed(
        &mut self,
        site: PartContext,
        sample: SampleView<'_>,
        context: &dyn EvalContext,
        troubles: &mut ConditionFaults,
    ) {
        feed(self, site, sample, context, troubles);
    }

    fn window(&self, site: PartContext) -> Window {
        fit_window(self, site)
    }

    // The sample replaces one that is no longer stored separately, because a value that is not a number came after it.
    fn must_backfill(&self, sample: SampleView<'_>) -> bool {
        let fit = self.objects.get(&sample.variable.object);
        fit.is_some_and(|fit| fit.newest.is_none() && fit.last().map(|(at, _)| at) == Some(sample.at))
    }
}

fn feed(
    part: &mut RegressionPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if part.fit.1.is_some_and(|end| sample.at > end) {
        return;
    }
    let object = &sample.variable.object;
    if !part.objects.contains_key(object) {
        if part.objects.len() >= MONITOR_OBJECTS_MAX {
            return troubles.limit("MONITOR_OBJECTS_MAX", MONITOR_OBJECTS_MAX, site.place);
        }
        let bindings = object_bindings(part, &part.condition.object, site, sample, context, troubles);
        part.objects.insert(object.clone(), Fit { rank: sample.sequence, bindings, ..Fit::default() });
    }
    let Some(fit) = part.objects.get_mut(object) else { return };
    let Some((number, dimension)) = sample.value.as_number() else {
        fit.miss(sample.at);
        return troubles.add(no_number(sample, site));
    };
    // An infinite value counts as a missing measurement: it opens a gap. A value that is not a number replaces no sample.
    if number.is_nan() {
        return;
    }
    if libm::fabs(number) > MAGNITUDE_MAX {
        return fit.miss(sample.at);
    }
    if *part.dimension.get_or_insert(dimension) != dimension {
        fit.miss(sample.at);
        return troubles.add(no_number(sample, site));
    }
    fit.add(sample.at, number);
}

fn no_number(sample: SampleView<'_>, site: PartContext) -> EvaluationError {
    let message = format!(
        "{} = {} is not a number with the dimension of the values before it: no line is fitted",
        sample.variable, sample.value
    );
    EvaluationError { message, place: site.place }
}

/// A fitted line with its value.
pub(crate) struct FittedLine {
    /// All samples of the fit.
    pub(crate) moments: Moments,
    /// The last fitted sample.
    pub(crate) last: (Time, f64),
    scale: ValueScale,
}

impl FittedLine {
    pub(crate) fn value(&self, si: f64) -> Value {
        in_unit(si, self.scale.dimension, self.scale.unit)
    }
}

/// Returns the line through the samples of one object.
///
/// # Errors
/// The reason for which there is no line.
fn line(part: &RegressionPart, fit: &Fit, context: &dyn EvalContext) -> Result<FittedLine, FitFailure> {
    let Some(last) = fit.last() else { return Err(FitFailure::NoSample) };
    if part.blind {
        return Err(FitFailure::Blind);
    }
    let (moments, gap) = fit.with_newest();
    let (unit, _) = declared_scale(&part.condition.variable.attribute, context);
    let scale = ValueScale { unit, dimension: part.dimension.unwrap_or_default() };
    let line = FittedLine { moments, last, scale };
    if moments.count() < part.points_min {
        return Err(FitFailure::TooFew { samples: moments.count(), least: part.points_min });
    }
    if let Some(most) = part.gap_max.filter(|most| gap > *most && !planted::is(Bug::GapOfLineForgotten)) {
        return Err(FitFailure::Gap { gap, most });
    }
    let Some(error) = moments.error() else { return Err(FitFailure::OneInstant) };
    match part.error_max.filter(|most| error > *most) {
        Some(most) => Err(FitFailure::Error { error: line.value(error), most: line.value(most) }),
        None => Ok(line),
    }
}

/// Verdict of one object's line at `now`.
pub(crate) enum Saying {
    /// The line satisfies the constraints in the window.
    Met(Satisfaction),
    /// The line will satisfy the constraints at this instant, if no sample arrives before.
    WillBe(Time, f64, FittedLine),
    /// The line does not satisfy the constraints in the window.
    Unmet(FittedLine),
    /// There is no line, or the window is not known.
    Unknown(FitFailure),
}

/// Returns the verdict of the line of `object` at `now`.
///
/// # Errors
/// When a bound cannot be evaluated.
pub(crate) fn says(
    part: &RegressionPart,
    site: PartContext,
    (object, fit): (&Value, &Fit),
    now: Time,
    context: &dyn EvalContext,
) -> Result<Saying, EvaluationError> {
    let line = match line(part, fit, context) {
        Ok(line) => line,
        Err(refusal) => return Ok(Saying::Unknown(refusal)),
    };
    let mut bindings = fit.bindings.clone().unwrap_or_default();
    let wanted = band(&part.condition.value, line.scale, &bindings, context, site.place)?;
    let stated = bounds(&part.condition.timestamp, context, site.place)?;
    let Some((first_at, last_at)) = line.moments.span() else { return Ok(Saying::Unknown(FitFailure::NoSample)) };
    let from = match site.window.start {
        Time::BEGINNING => stated.from.unwrap_or(first_at),
        start => stated.from.map_or(start, |from| from.max(start)),
    };
    // Later instants are predicted only if the window includes them.
    let reach = Time(i64::MAX / 2);
    let Some((at, value)) = earliest(&line.moments, &wanted, from, stated.to.unwrap_or(reach.max(from))) else {
        return Ok(unmet(part, line, now));
    };
    let predicts = stated.to.is_some() || at == from;
    let recognised_at = if predicts { last_at } else { last_at.max(at) };
    let extrapolation = (first_at - at).max(at - last_at).max(Duration::ZERO);
    if let Some(most) = part.difference_max.filter(|_| extrapolation > Duration::ZERO) {
        let nearest = if at < first_at { fit.first } else { line.last.1 };
        let difference = libm::fabs(value - nearest);
        if difference > most {
            let (difference, most) = (line.value(difference), line.value(most));
            return Ok(Saying::Unknown(FitFailure::Difference { difference, most }));
        }
    }
    if part.gap_max.is_some_and(|most| recognised_at - last_at > most) {
        return Ok(unmet(part, line, now));
    }
    if recognised_at > now {
        return Ok(Saying::WillBe(at, value, line));
    }
    bind(&wanted, value, line.scale, &mut bindings);
    let variable = StateVariable { attribute: part.condition.variable.attribute.clone(), object: object.clone() };
    let samples = line.moments.count();
    let estimate = Estimate {
        estimator: Estimator::LinearRegression,
        variable: variable.clone(),
        value: line.value(value),
        at,
        extent: (first_at, last_at + Duration(1)),
        samples,
        extrapolation,
        error: line.moments.error().map(|error| line.value(error)),
    };
    let evidence = vec![
        Evidence::Run { variable, start: first_at, end: last_at, samples },
        Evidence::Estimate(Box::new(estimate)),
    ];
    Ok(Saying::Met(Satisfaction { interval: (first_at, last_at), recognised_at, bindings, evidence: evidence.into() }))
}

/// Explains that the line does not meet the constraints, or that this is unknown since samples stopped.
fn unmet(part: &RegressionPart, line: FittedLine, now: Time) -> Saying {
    let gap = now.min(part.fit.1.unwrap_or(Time::END)) - line.last.0;
    match part.gap_max.filter(|most| gap > *most) {
        Some(most) => Saying::Unknown(FitFailure::Gap { gap, most }),
        None => Saying::Unmet(line),
    }
}

/// Returns the verdicts of the lines of all required objects, in order of first appearance.
pub(crate) fn all(part: &RegressionPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Vec<Saying> {
    let wanted = |fit: &Fit| fit.bindings.is_some() && fit.last().is_some();
    let mut objects: Vec<(&Value, &Fit)> = part.objects.iter().filter(|(_, fit)| wanted(fit)).collect();
    objects.sort_by_key(|(_, fit)| fit.rank);
    let mut sayings = Vec::new();
    for object in objects {
        match says(part, site, object, query.now, query.context) {
            Ok(saying) => sayings.push(saying),
            Err(error) => query.troubles.add(error),
        }
    }
    sayings
}

/// Returns the present results of the lines, earliest recognised first.
pub(crate) fn results(part: &RegressionPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
    let met = |saying| match saying {
        Saying::Met(result) => Some(result),
        Saying::WillBe(..) | Saying::Unmet(_) | Saying::Unknown(_) => None,
    };
    let mut results: Vec<Satisfaction> = all(part, site, query).into_iter().filter_map(met).collect();
    results.sort_by_key(|result| result.recognised_at);
    results
}

/// Returns true if an object has no reliable line.
pub(crate) fn in_doubt(part: &RegressionPart, site: PartContext, query: &mut VerdictQuery<'_>) -> bool {
    let silent = part.objects.values().all(|fit| fit.last().is_none());
    silent || all(part, site, query).iter().any(|saying| matches!(saying, Saying::Unknown(_)))
}

/// Returns satisfied; unknown without a reliable line; otherwise not satisfied. The part wakes at the instant at which the line meets the
/// constraint.
pub(crate) fn truth(part: &RegressionPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Truth {
    let sayings = all(part, site, query);
    // Samples of an object that is not required do not make the result known, as for other conditions.
    let mut unknown = part.objects.values().all(|fit| fit.last().is_none());
    let mut met = false;
    for saying in sayings {
        match saying {
            Saying::Met(_) => met = true,
            Saying::WillBe(at, ..) => query.wake_at_after_now(at),
            Saying::Unknown(_) => unknown = true,
            Saying::Unmet(_) => {}
        }
    }
    Truth::of(met, unknown)
}

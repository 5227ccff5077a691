//! Measurement (M&I)
//! What: detects one sample whose value, object and time satisfy the constraints.
//! Runs: on every sample of the watched variable; once over the remembered samples.
//! Reads: histories, evaluation context.
//! Writes: the measurement part of a monitor.
//! Bound: O(1) per sample and object; a late sample looks back over the window again.
//! PDL: `(ATTR OBJ REL VAL [+/- E])`, `(:measurement ..)`.
//! Paper: Table 1, rows 1 to 4.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::constraints::{RightSide, all, prepare};
use crate::monitoring::part::{ConditionFaults, PartContext, remember};
use crate::monitoring::sampled::{SampleConstraints, Sampled};
use crate::monitoring::samples::{SampleView, concerns, known_variable};
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{
    Keep, MeasurementPart, Newest, NewestSample, Satisfaction, SeenSamples, Test, Window,
};
use crate::state::thresholds::Threshold;
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::condition::MeasurementCondition;
use apex_model::condition::VariablePattern;
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::time::Time;
use apex_model::value::Value;
use std::sync::Arc;

/// Creates the monitor part for `condition`, before any remembered sample is examined.
///
/// # Errors
/// An [`EvaluationError`] if an operand of the condition that never changes cannot be evaluated.
pub(crate) fn create(
    condition: &Arc<MeasurementCondition>,
    context: &dyn EvalContext,
) -> Result<MeasurementPart, EvaluationError> {
    let unit = unit_of(&condition.variable.attribute, context.library());
    Ok(MeasurementPart {
        tests: prepare(&condition.value, unit, context)?,
        variable: known_variable(&condition.variable, context),
        condition: Arc::clone(condition),
        blind: false,
        seen: None,
    })
}

/// Returns the comparison with a constant that every matching sample satisfies; `None` if object or timestamp are constrained too, or if
/// the operand can change.
pub(crate) fn threshold(part: &MeasurementPart) -> Option<Threshold> {
    let plain = part.variable.is_some() && part.condition.object.is_empty() && part.condition.timestamp.is_empty();
    match part.tests.first().filter(|_| plain)? {
        Test::Fixed { relation, right } => Threshold::of(*relation, right),
        Test::General(_) => None,
    }
}

/// Processes a sample that has arrived; `newest` is true if every earlier sample of its variable has an earlier time.
pub(crate) fn notice(
    part: &mut MeasurementPart,
    site: PartContext,
    sample: SampleView<'_>,
    newest: bool,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if !concerns(part.variable.as_ref(), &part.condition.variable.attribute, sample.variable) {
        return;
    }
    if !site.window.contains(sample.at, sample.sequence) {
        return;
    }
    let known = part.seen.as_ref().and_then(|seen| seen.newest.get(&sample.variable.object));
    if newest || known.is_none_or(|known| sample.at >= known.at) {
        feed(part, site, sample, context, troubles);
    } else if !planted::is(Bug::LateSampleIgnored) {
        feed_late(part, site, sample, context, troubles);
    }
}

/// Processes a sample that is older than the newest one of its variable. It replaces an earlier sample of the same instant.
fn feed_late(
    part: &mut MeasurementPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    let result = judge(part, site, sample, context, troubles);
    let Some(seen) = &mut part.seen else { return };
    if let Some(newest) = seen.newest.get_mut(&sample.variable.object) {
        newest.rank = newest.rank.min(sample.sequence);
    }
    seen.settled.retain(|result| result.interval.0 != sample.at || variable_of(result) != Some(sample.variable));
    if let Some(result) = result {
        remember(&mut seen.settled, result, site, troubles);
    }
}

impl Sampled for MeasurementPart {
    fn pattern(&self) -> &VariablePattern {
        &self.condition.variable
    }

    fn variable(&self) -> Option<&StateVariable> {
        self.variable.as_ref()
    }

    fn newest(&self, object: &Value) -> Option<Time> {
        self.seen.as_ref()?.newest.get(object).map(|newest| newest.at)
    }

    fn begin_again(&mut self, _: PartContext, _: &dyn EvalContext, _: &mut ConditionFaults) {
        self.seen = None;
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
}

fn feed(
    part: &mut MeasurementPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if site.keep == Keep::First && part.seen.as_ref().is_some_and(|seen| !seen.settled.is_empty()) {
        return;
    }
    if let Some(seen) = &mut part.seen
        && let Some(newest) = seen.newest.get_mut(&sample.variable.object)
        && sample.at > newest.at
        && let Some(result) = newest.result.take()
    {
        remember(&mut seen.settled, result, site, troubles);
        if site.keep == Keep::First {
            return;
        }
    }
    let result = judge(part, site, sample, context, troubles);
    let seen = part.seen.get_or_insert_default();
    let objects = seen.newest.len();
    match seen.newest.get_mut(&sample.variable.object) {
        Some(newest) if newest.at == sample.at && planted::is(Bug::FirstDuplicateWins) => {}
        Some(newest) => {
            newest.at = sample.at;
            newest.rank = newest.rank.min(sample.sequence);
            newest.result = result;
        }
        None if objects >= context.limits().count(Limit::MonitorObjects) => {
            troubles.reached(Limit::MonitorObjects, context, site.place)
        }
        None => {
            let newest = NewestSample { rank: sample.sequence, at: sample.at, result };
            seen.newest.insert(sample.variable.object.clone(), newest);
        }
    }
}

fn judge(
    part: &MeasurementPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Option<Satisfaction> {
    let mut bindings = Bindings::new();
    match holds(part, site, sample, &mut bindings, context) {
        Ok(true) => Some(Satisfaction {
            interval: (sample.at, sample.at),
            recognised_at: sample.at,
            bindings,
            evidence: EvidenceList::one(Evidence::Sample {
                variable: sample.variable.clone(),
                value: sample.value.clone(),
                at: sample.at,
            }),
        }),
        Ok(false) => None,
        Err(error) => {
            troubles.add(error);
            None
        }
    }
}

fn holds(
    part: &MeasurementPart,
    site: PartContext,
    sample: SampleView<'_>,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
) -> Result<bool, EvaluationError> {
    let condition = &part.condition;
    let constraints = SampleConstraints {
        pattern: &condition.variable,
        object: &condition.object,
        value: &condition.value,
        tests: &part.tests,
        known: part.variable.is_some(),
    };
    let stamp = Value::Time(sample.at);
    Ok(constraints.hold(site, sample, bindings, context)?
        && all(&condition.timestamp, &stamp, RightSide::Instant, bindings, context, site.place)?)
}

/// Returns all results up to now, earliest first; results of one instant in the order in which their objects first occurred.
pub(crate) fn results(part: &MeasurementPart) -> Vec<Satisfaction> {
    ordered(part).into_iter().cloned().collect()
}

/// Returns the results of [`results`] by reference.
pub(crate) fn ordered(part: &MeasurementPart) -> Vec<&Satisfaction> {
    let Some(seen) = &part.seen else { return Vec::new() };
    let pending = seen.newest.samples().filter_map(|newest| newest.result.as_ref());
    let mut all: Vec<&Satisfaction> = seen.settled.iter().chain(pending).collect();
    let rank = |result: &Satisfaction| {
        variable_of(result).and_then(|variable| seen.newest.get(&variable.object)).map(|newest| newest.rank)
    };
    all.sort_by_key(|result| (result.recognised_at, rank(result)));
    all
}

/// Returns the variable of the result's sample.
pub(crate) fn variable_of(result: &Satisfaction) -> Option<&StateVariable> {
    match result.evidence.iter().next() {
        Some(Evidence::Sample { variable, .. }) => Some(variable),
        _ => None,
    }
}

/// Returns the first of [`results`].
pub(crate) fn first_result(part: &MeasurementPart) -> Option<Satisfaction> {
    let seen = part.seen.as_ref()?;
    match (&seen.newest, seen.settled.is_empty()) {
        (Newest::One(_, newest), true) => newest.result.clone(),
        _ => results(part).into_iter().next(),
    }
}

/// Returns true if a result exists.
pub(crate) fn any(part: &MeasurementPart) -> bool {
    let found =
        |seen: &SeenSamples| !seen.settled.is_empty() || seen.newest.samples().any(|newest| newest.result.is_some());
    part.seen.as_deref().is_some_and(found)
}

/// Returns the time of the newest sample of `variable` within the window; samples that arrived before the part was created
/// count, too.
fn newest_seen(
    part: &MeasurementPart,
    window: Window,
    variable: &StateVariable,
    context: &dyn EvalContext,
) -> Option<Time> {
    if part.variable.is_none() {
        return part.seen.as_ref()?.newest.get(&variable.object).map(|newest| newest.at);
    }
    let mut samples = context.histories().get(variable)?.samples().rev();
    samples.find(|sample| window.contains(sample.at, sample.sequence)).map(|sample| sample.at)
}

/// Returns true if any sample within the window has arrived, so that an explanation can distinguish "no data".
pub(crate) fn has_seen_any(part: &MeasurementPart, window: Window, context: &dyn EvalContext) -> bool {
    match &part.variable {
        Some(variable) => newest_seen(part, window, variable, context).is_some(),
        None => part.seen.as_ref().is_some_and(|seen| !seen.newest.is_empty()),
    }
}

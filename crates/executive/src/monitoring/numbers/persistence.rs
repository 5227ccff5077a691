//! Persistence (M&I)
//! What: detects a sample that satisfies the constraints and is valid at some instant: until the next sample, or until it expires.
//! Runs: on every sample of the watched variable, and at the instant at which the window begins.
//! Reads: histories, evaluation context.
//! Writes: the persisted part of a monitor.
//! Bound: O(1) per sample and object; a late sample looks back over the window again.
//! PDL: `:estimation :persist`, `(:persist :with-timeout D)`.
//! Paper: Table 1, row 5.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::constraints::prepare;
use crate::monitoring::part::{ConditionFaults, PartContext, Truth, remember};
use crate::monitoring::sampled::{SampleConstraints, Sampled};
use crate::monitoring::samples::{SampleView, concerns, known_variable, seen_of};
use crate::monitoring::time_bounds::{TICK, TimeBounds, bounds, duration_of};
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Keep, Satisfaction};
use crate::state::monitors::numbers::{PersistedPart, PersistedSample};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::condition::MeasurementCondition;
use apex_model::condition::VariablePattern;
use apex_model::estimate::{Estimate, Estimator};
use apex_model::event::StateVariable;
use apex_model::expression::Expr;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Returns the part for `condition`; it has not processed remembered samples yet.
///
/// # Errors
/// When the timeout or a value that never changes cannot be evaluated.
pub(crate) fn create(
    condition: &Arc<MeasurementCondition>,
    timeout: Option<&Expr>,
    context: &dyn EvalContext,
) -> Result<PersistedPart, EvaluationError> {
    let unit = unit_of(&condition.variable.attribute, context.library());
    let timeout = timeout.map(|timeout| duration_of(timeout, context)).transpose()?;
    Ok(PersistedPart {
        tests: prepare(&condition.value, unit, context)?,
        variable: known_variable(&condition.variable, context),
        timeout: timeout.unwrap_or(Duration::MAX),
        blind: false,
        settled: Vec::new(),
        objects: BTreeMap::new(),
        condition: Arc::clone(condition),
    })
}

/// Forgets everything but the sample that holds into the window.
pub(crate) fn begin_again(
    part: &mut PersistedPart,
    site: PartContext,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    part.settled.clear();
    part.objects.clear();
    let known = part.variable.clone();
    let condition = Arc::clone(&part.condition);
    let attribute = &condition.variable.attribute;
    if site.window.after_sequence.is_none() {
        for (variable, history) in context.histories().of_attribute(attribute) {
            let carried = history.before(site.window.start).filter(|_| concerns(known.as_ref(), attribute, variable));
            if let Some(sample) = carried {
                feed(part, site, seen_of(variable, history, sample), context, troubles);
            }
        }
    }
}

/// Processes a sample.
pub(crate) fn notice(
    part: &mut PersistedPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if !concerns(part.variable.as_ref(), &part.condition.variable.attribute, sample.variable) {
        return;
    }
    let newest = part.objects.get(&sample.variable.object);
    // A late sample from before the window may still be valid at the window's start.
    if sample.at < site.window.start || newest.is_some_and(|newest| sample.at < newest.at) {
        let history = context.histories().get(sample.variable);
        if history.is_some_and(|history| history.covers(site.window.start)) {
            part.backfill(site, context, troubles);
        }
    } else if site.window.contains(sample.at, sample.sequence) {
        feed(part, site, sample, context, troubles);
    }
}

impl Sampled for PersistedPart {
    fn pattern(&self) -> &VariablePattern {
        &self.condition.variable
    }

    fn variable(&self) -> Option<&StateVariable> {
        self.variable.as_ref()
    }

    fn newest(&self, object: &Value) -> Option<Time> {
        self.objects.get(object).map(|newest| newest.at)
    }

    fn begin_again(&mut self, site: PartContext, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
        begin_again(self, site, context, troubles);
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
    part: &mut PersistedPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if site.keep == Keep::First && !part.settled.is_empty() {
        return;
    }
    let object = &sample.variable.object;
    let rank = match part.objects.get(object) {
        Some(before) => {
            let rank = before.rank;
            if sample.at > before.at
                && let Some(result) =
                    judged(part, site, sample.variable, before, (sample.at - TICK, true), context, troubles)
            {
                remember(&mut part.settled, result, site, troubles);
            }
            rank
        }
        None if part.objects.len() >= context.limits().count(Limit::MonitorObjects) => {
            return troubles.reached(Limit::MonitorObjects, context, site.place);
        }
        None => sample.sequence,
    };
    let mut bindings = Bindings::new();
    let holds = match holds(part, site, sample, &mut bindings, context) {
        Ok(holds) => holds.then_some(bindings),
        Err(error) => {
            troubles.add(error);
            None
        }
    };
    part.objects.insert(object.clone(), PersistedSample { rank, at: sample.at, value: sample.value.clone(), holds });
}

fn holds(
    part: &PersistedPart,
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
    constraints.hold(site, sample, bindings, context)
}

/// Returns the window of instants that count: from the part's window's start on, or as `:timestamp` states.
fn window(part: &PersistedPart, site: PartContext, context: &dyn EvalContext) -> Result<TimeBounds, EvaluationError> {
    let stated = bounds(&part.condition.timestamp, context, site.place)?;
    Ok(TimeBounds { from: Some(stated.from.unwrap_or(site.window.start).max(site.window.start)), to: stated.to })
}

/// Returns the first and the last instant of the window at which the sample is valid; both may lie in the future.
fn valid(part: &PersistedPart, within: TimeBounds, sample: &PersistedSample) -> Option<(Time, Time)> {
    let first = within.from.map_or(sample.at, |from| from.max(sample.at));
    let last = within.to.unwrap_or(Time::END).min(sample.at + part.timeout);
    (first <= last).then_some((first, last))
}

/// Returns the result of a sample as known at `horizon`; with `over`, the next sample follows then.
fn judged(
    part: &PersistedPart,
    site: PartContext,
    variable: &StateVariable,
    sample: &PersistedSample,
    (horizon, over): (Time, bool),
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Option<Satisfaction> {
    let bindings = sample.holds.as_ref()?;
    let within = match window(part, site, context) {
        Ok(within) => within,
        Err(error) => {
            troubles.add(error);
            return None;
        }
    };
    let (first, last) = valid(part, within, sample).filter(|(first, _)| *first <= horizon)?;
    let last = if over { last.min(horizon) } else { last };
    let value = sample.value.clone();
    let expires = if last == Time::END { last } else { last + TICK };
    let estimate = Estimate {
        estimator: Estimator::Persistence,
        variable: variable.clone(),
        value: value.clone(),
        at: first,
        extent: (sample.at, expires),
        samples: 1,
        extrapolation: first - sample.at,
        error: None,
    };
    Some(Satisfaction {
        interval: (sample.at, sample.at),
        recognised_at: first,
        bindings: bindings.clone(),
        evidence: vec![
            Evidence::Sample { variable: variable.clone(), value, at: sample.at },
            Evidence::Estimate(Box::new(estimate)),
        ]
        .into(),
    })
}

/// Returns all results up to now, earliest recognised first.
pub(crate) fn results(part: &PersistedPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
    let mut results = part.settled.clone();
    if site.keep == Keep::First && !results.is_empty() {
        return results;
    }
    let mut newest: Vec<_> = part.objects.iter().collect();
    newest.sort_by_key(|(_, sample)| sample.rank);
    for (object, sample) in newest {
        let variable = StateVariable { attribute: part.condition.variable.attribute.clone(), object: object.clone() };
        let (now, context) = (query.now, query.context);
        results.extend(judged(part, site, &variable, sample, (now, false), context, &mut query.troubles));
    }
    let rank = |result: &Satisfaction| match result.evidence.iter().next() {
        Some(Evidence::Sample { variable, .. }) => part.objects.get(&variable.object).map(|sample| sample.rank),
        _ => None,
    };
    results.sort_by_key(|result| (result.recognised_at, rank(result)));
    results
}

/// Returns true if the present value is unknown.
pub(crate) fn in_doubt(part: &PersistedPart, now: Time) -> bool {
    part.blind || !part.objects.values().any(|sample| now <= sample.at + part.timeout)
}

/// Returns satisfied; unknown without a valid sample; otherwise not satisfied. The part waits for a future window.
pub(crate) fn truth(part: &PersistedPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Truth {
    if !results(part, site, query).is_empty() {
        return Truth::True;
    }
    let within = match window(part, site, query.context) {
        Ok(within) => within,
        Err(error) => {
            query.troubles.add(error);
            return Truth::Unknown;
        }
    };
    for sample in part.objects.values() {
        let opens = valid(part, within, sample).filter(|(first, _)| sample.holds.is_some() && *first > query.now);
        if let Some((first, _)) = opens {
            query.wake_at_after_now(first);
        }
    }
    Truth::of(false, in_doubt(part, query.now))
}

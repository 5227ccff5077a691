//! Episode detection (M&I)
//! What: detects runs of samples that satisfy constraints on value, time and sampling.
//! Runs: on every sample of the watched variable, and at the instant at which a duration is reached.
//! Reads: histories, evaluation context.
//! Writes: the episode part of a monitor.
//! Bound: O(1) per sample and object, O(1) memory per open run (any pair of samples: O(run)).
//! PDL: `:episode`.
//! Paper: section IV example 1, Table 1 row 7.

use crate::expression::arithmetic::duration;
use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::constraints::{RightSide, all, is_lower_bound, prepare};
use crate::monitoring::episodes::run_update::{Judged, advance_run, pair_of, with_newest};
use crate::monitoring::episodes::{run_fast_path, threshold_backfill};
use crate::monitoring::part::{ConditionFaults, PartContext, Truth, remember};
use crate::monitoring::sampled::{SampleConstraints, Sampled};
use crate::monitoring::samples::{SampleView, known_variable, remembered};
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::wake::WakeReason;
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{EpisodePart, Keep, ObjectRun, PairPoints, Run, RunSample, Satisfaction};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::condition::VariablePattern;
use apex_model::condition::{Constraint, EpisodeCondition, Quality, Relation};
use apex_model::event::StateVariable;
use apex_model::expression::{Expr, ExprKind};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Returns the part for `condition`; it has not processed remembered samples yet. Gap and durations are evaluated now.
///
/// # Errors
/// When the gap or a duration cannot be evaluated.
pub(crate) fn create(
    condition: &Arc<EpisodeCondition>,
    any_pair: bool,
    context: &dyn EvalContext,
) -> Result<EpisodePart, EvaluationError> {
    let unit = unit_of(&condition.variable.attribute, context.library());
    let gap_max = match &condition.quality {
        Quality::NoConstraints => None,
        Quality::MaximumGap(gap) => Some(evaluate_duration(gap, context)?),
    };
    let timing = &condition.timing;
    let mut duration_min = Duration::ZERO;
    for constraint in &timing.duration {
        duration_min = duration_min.max(least_duration(constraint, context)?.unwrap_or_default());
    }
    Ok(EpisodePart {
        tests: prepare(&condition.value, unit, context)?,
        variable: known_variable(&condition.variable, context),
        gap_max,
        duration_min,
        at_close: !timing.duration.iter().chain(&timing.end).all(is_lower_bound),
        any_pair,
        blind: false,
        settled: Vec::new(),
        points: None,
        runs: BTreeMap::new(),
        condition: Arc::clone(condition),
    })
}

fn evaluate_duration(expr: &Expr, context: &dyn EvalContext) -> Result<Duration, EvaluationError> {
    let value = evaluate(expr, context)?;
    duration(&value).map_err(|message| EvaluationError { message, place: expr.place })
}

/// Returns the least duration that a lower bound allows.
fn least_duration(constraint: &Constraint, context: &dyn EvalContext) -> Result<Option<Duration>, EvaluationError> {
    Ok(match constraint {
        Constraint::Compare { relation: Relation::Greater, right, tolerance: None } => {
            let more = if planted::is(Bug::LongerIsAtLeast) { Duration::ZERO } else { TICK };
            Some(evaluate_duration(right, context)? + more)
        }
        Constraint::Compare { relation: Relation::GreaterOrEqual, right, tolerance: None }
        | Constraint::Range(Some(right), None) => Some(evaluate_duration(right, context)?),
        _ => None,
    })
}

/// Returns the least and the greatest duration; `None` if a constraint on the duration is not a fixed limit.
pub(crate) fn durations(part: &EpisodePart) -> Option<(Duration, Duration)> {
    let fixed = |expr: &Expr| match &expr.kind {
        ExprKind::Constant(Value::Duration(length)) => Some(*length),
        _ => None,
    };
    let mut limits = (part.duration_min, Duration::MAX);
    for constraint in part.condition.timing.duration.iter().filter(|each| !is_lower_bound(each)) {
        let (least, most) = match constraint {
            Constraint::Compare { relation, right, tolerance: None } => limits_of(*relation, fixed(right)?)?,
            Constraint::Range(least, Some(most)) => {
                (least.as_ref().map_or(Some(Duration(i64::MIN)), fixed)?, fixed(most)?)
            }
            _ => return None,
        };
        limits = (limits.0.max(least), limits.1.min(most));
    }
    Some(limits)
}

/// Returns the least and the greatest length that has this relation to `length`; `None` if lengths on both sides have it.
pub(crate) fn limits_of(relation: Relation, length: Duration) -> Option<(Duration, Duration)> {
    let (least, most) = (Duration(i64::MIN), Duration::MAX);
    Some(match relation {
        Relation::Less => (least, length - TICK),
        Relation::LessOrEqual => (least, length),
        Relation::Equal => (length, length),
        Relation::GreaterOrEqual => (length, most),
        Relation::Greater => (length + TICK, most),
        Relation::Different => return None,
    })
}

/// Clears the results and processes the remembered samples.
pub(crate) fn backfill(
    part: &mut EpisodePart,
    site: PartContext,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    backfill_with(threshold_backfill::backfill, part, site, context, troubles);
}

/// Like [`backfill`], after `fast_pass` has consumed samples from the start; `fast_pass` returns their number.
pub(crate) fn backfill_with(
    fast_pass: impl FnOnce(
        &mut EpisodePart,
        PartContext,
        &[SampleView<'_>],
        &dyn EvalContext,
        &mut ConditionFaults,
    ) -> usize,
    part: &mut EpisodePart,
    site: PartContext,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    part.begin_again(site, context, troubles);
    let known = part.variable.clone();
    let condition = Arc::clone(&part.condition);
    let (samples, blind) = remembered(known.as_ref(), &condition.variable.attribute, site, context);
    part.blind = blind;
    let passed = fast_pass(part, site, &samples, context, troubles);
    for sample in samples.into_iter().skip(passed) {
        feed(part, site, sample, context, troubles);
    }
}

impl Sampled for EpisodePart {
    fn pattern(&self) -> &VariablePattern {
        &self.condition.variable
    }

    fn variable(&self) -> Option<&StateVariable> {
        self.variable.as_ref()
    }

    fn newest(&self, object: &Value) -> Option<Time> {
        self.runs.get(object).map(|run| run.newest.at)
    }

    fn begin_again(&mut self, _: PartContext, _: &dyn EvalContext, _: &mut ConditionFaults) {
        self.settled.clear();
        self.points = self.points.take().map(|points| Box::new(PairPoints::lasting(points.durations)));
        self.runs.clear();
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

    fn feed_quickly(&mut self, site: PartContext, sample: SampleView<'_>) -> bool {
        run_fast_path::notice(self, site, sample)
    }

    fn backfill(&mut self, site: PartContext, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
        backfill(self, site, context, troubles);
    }
}

fn feed(
    part: &mut EpisodePart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if site.keep == Keep::First && !part.settled.is_empty() {
        return;
    }
    let object = &sample.variable.object;
    let objects = part.runs.len();
    let before = match part.runs.get_mut(object).map(std::mem::take) {
        Some(object_run) if sample.at > object_run.newest.at => {
            settle(part, site, object, object_run, sample.at, context, troubles)
        }
        Some(object_run) => object_run,
        None if objects >= context.limits().count(Limit::MonitorObjects) => {
            troubles.reached(Limit::MonitorObjects, context, site.place);
            return;
        }
        // A known variable has a single object, so objects need not be distinguished.
        None => {
            let rank = if part.variable.is_some() { 0 } else { sample.sequence };
            ObjectRun { rank, ..ObjectRun::default() }
        }
    };
    let newest = judge(part, site, sample, before.run.as_ref(), context, troubles);
    let after = ObjectRun { newest, rank: before.rank.min(sample.sequence), ..before };
    if let Some(mut points) = part.points.take() {
        points.replace_newest(&after.newest, with_newest(part, &after).as_ref());
        part.points = Some(points);
    }
    match part.runs.get_mut(object) {
        Some(slot) => *slot = after,
        None => {
            part.runs.insert(object.clone(), after);
        }
    }
}

/// Adds the newest sample to the past, because one of a later instant, `next`, has arrived.
fn settle(
    part: &mut EpisodePart,
    site: PartContext,
    object: &Value,
    object_run: ObjectRun,
    next: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> ObjectRun {
    let Judged { run, found, over, contradicted, gap, .. } =
        advance_run(part, site, object, &object_run, next - TICK, context, troubles);
    // After a gap no sample shows where a run began.
    let contradicted = contradicted && !is_apart(part, object_run.newest.at, next);
    for result in over {
        remember(&mut part.settled, result, site, troubles);
    }
    let found = match (found, site.keep) {
        (Some(result), Keep::First) => {
            remember(&mut part.settled, result, site, troubles);
            None
        }
        (found, _) => found,
    };
    if let Some(points) = &mut part.points {
        points.settle(object_run.newest.at, site, troubles);
    }
    ObjectRun { run, found, contradicted, gap, ..object_run }
}

/// Returns the sample with its bindings if it satisfies the value constraints, and whether these agree with the preceding run and the
/// constraints on the first and last values hold.
fn judge(
    part: &EpisodePart,
    site: PartContext,
    sample: SampleView<'_>,
    run: Option<&Run>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> RunSample {
    let mut newest = RunSample { at: sample.at, holds: None, joins: true, first_holds: true, last_holds: true };
    let attempt = |mut bindings: Bindings| -> Result<Option<Bindings>, EvaluationError> {
        Ok(holds(part, site, sample, &mut bindings, context)?.then_some(bindings))
    };
    let judged = match run {
        Some(run) => attempt(run.bindings.clone()).and_then(|joined| match joined {
            None if !run.bindings.is_empty() => {
                newest.joins = false;
                attempt(Bindings::new())
            }
            joined => Ok(joined),
        }),
        None => attempt(Bindings::new()),
    };
    match judged {
        Ok(holds) => newest.holds = holds,
        Err(error) => troubles.add(error),
    }
    let condition = &part.condition;
    if let Some(bindings) = &mut newest.holds {
        let unit = unit_of(&condition.variable.attribute, context.library());
        for (constraints, holds) in
            [(&condition.first_value, &mut newest.first_holds), (&condition.last_value, &mut newest.last_holds)]
        {
            if !constraints.is_empty() {
                match all(constraints, sample.value, RightSide::Value(unit), bindings, context, site.place) {
                    Ok(truth) => *holds = truth,
                    Err(error) => {
                        *holds = false;
                        troubles.add(error);
                    }
                }
            }
        }
    }
    newest
}

fn holds(
    part: &EpisodePart,
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

/// Returns all results up to `now`, earliest recognised first.
pub(crate) fn results(
    part: &EpisodePart,
    site: PartContext,
    now: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Vec<Satisfaction> {
    if let Some(points) = &part.points {
        return points.first_pair().and_then(|pair| pair_of(part, pair)).into_iter().collect();
    }
    let mut results = part.settled.clone();
    if site.keep == Keep::First && !results.is_empty() {
        return results;
    }
    for (object, object_run) in &part.runs {
        let judged = advance_run(part, site, object, object_run, now, context, troubles);
        results.extend(judged.over);
        results.extend(judged.closed_by_time);
        results.extend(judged.found);
    }
    // Results of one instant, in the order in which their objects first occurred.
    let rank = |result: &Satisfaction| match result.evidence.iter().next() {
        Some(Evidence::Run { variable, .. }) => part.runs.get(&variable.object).map(|run| run.rank),
        _ => None,
    };
    results.sort_by_key(|result| (result.recognised_at, rank(result)));
    results
}

/// Returns the results of open runs: their intervals may still grow.
pub(crate) fn open_results(
    part: &EpisodePart,
    site: PartContext,
    now: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Vec<Satisfaction> {
    let judged = |(object, object_run): (&Value, &ObjectRun)| {
        advance_run(part, site, object, object_run, now, context, troubles).found
    };
    part.runs.iter().filter_map(judged).collect()
}

/// Returns true if more than the permitted gap lies between the two instants.
pub(crate) fn is_apart(part: &EpisodePart, from: Time, to: Time) -> bool {
    part.gap_max.is_some_and(|most| to - from > most)
}

/// Returns satisfied, contradicted or unknown. Unknown: there is no sample yet, no sample shows where the run began that is not long
/// enough yet, or expected samples are missing, whatever the newest one says.
pub(crate) fn truth(
    part: &EpisodePart,
    site: PartContext,
    now: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Truth {
    if !part.settled.is_empty() || part.points.as_ref().is_some_and(|points| points.holds()) {
        return Truth::True;
    }
    let mut open = part.blind || part.runs.is_empty();
    for (object, object_run) in &part.runs {
        if let Some(undetermined) = run_fast_path::undecided(part, object_run, now) {
            open |= undetermined;
            continue;
        }
        let judged = advance_run(part, site, object, object_run, now, context, troubles);
        if judged.found.is_some() || !judged.over.is_empty() || judged.closed_by_time.is_some() {
            return Truth::True;
        }
        open |= is_apart(part, object_run.newest.at, now) || judged.run.is_some() && !judged.contradicted;
    }
    if open { Truth::Unknown } else { Truth::False }
}

/// Returns the next instant at which time alone can decide, and why.
pub(crate) fn next_wake(part: &EpisodePart, site: PartContext, after: Time) -> Option<(Time, WakeReason)> {
    let gap = part.gap_max?;
    if part.any_pair || (site.keep == Keep::First && !part.settled.is_empty()) {
        return None;
    }
    part.runs
        .values()
        .filter_map(|object_run| {
            let run = with_newest(part, object_run)?;
            let licensed_until = run.last + gap;
            if part.at_close {
                let over = licensed_until + TICK;
                return (over > after).then_some((over, WakeReason::GapEnds(gap)));
            }
            let reached = run.start + part.duration_min;
            let waits = reached > run.last && reached > after && reached <= licensed_until;
            waits.then_some((reached, WakeReason::DurationReached(part.duration_min)))
        })
        .min()
}

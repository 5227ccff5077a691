//! Statistic runs (M&I)
//! What: evaluates the criteria of an episode over a run, or over the window at its end, as samples arrive and time passes.
//! Runs: from statistics, for the past (a later sample has arrived) and for the present (a verdict is requested).
//! Reads: the statistical part, evaluation context.
//! Writes: the totals of a run, when a sample becomes past.
//! Bound: amortised O(1) per sample; instants at which samples leave a window O(1) each.
//! PDL: `:stats`, `:trend`, `:quality`, `:timing`.
//! Paper: Table 1, rows 8 and 9.

use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::constraints::{RightSide, all};
use crate::monitoring::numbers::aggregates::{CriterionContext, CriterionResult, RunStatistics};
use crate::monitoring::numbers::sliding_window::{contents, drop_before, leaving, push};
use crate::monitoring::numbers::weighted_crossing::{WeightedLimits, is_weighted};
use crate::monitoring::part::{ConditionFaults, PartContext};
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Keep, Satisfaction};
use crate::state::monitors::numbers::{Criterion, Measure, NumberRun, Point, StatisticalPart, Totals};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::event::StateVariable;
use apex_model::limits::WINDOW_FORESIGHT_MAX;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

fn wants(part: &StatisticalPart, wanted: impl Fn(&Measure) -> bool) -> bool {
    part.criteria.iter().any(|criterion| wanted(&criterion.measure))
}

fn wants_held(part: &StatisticalPart) -> bool {
    wants(part, is_weighted)
}

/// Returns the gap that separates the newest sample from the preceding run.
fn gap_cut(part: &StatisticalPart, state: &NumberRun) -> Option<Duration> {
    let gap = state.newest.at - state.run.as_ref()?.last;
    part.gap_max.filter(|most| gap > *most).map(|_| gap)
}

/// Returns true if a value outside the constraints was seen since the last gap, the newest sample included.
pub(crate) fn contradicted(part: &StatisticalPart, state: &NumberRun) -> bool {
    let newest = &state.newest;
    let departs = state.run.is_some() && !newest.joins;
    newest.holds.is_none() || (gap_cut(part, state).is_none() && (state.contradicted || departs))
}

/// Takes the newest sample of `state` into its run, the next sample being at `next`.
pub(crate) fn take_in(
    part: &StatisticalPart,
    site: PartContext,
    state: &mut NumberRun,
    next: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    let gap = gap_cut(part, state);
    let apart = part.gap_max.is_some_and(|most| next - state.newest.at > most);
    state.contradicted = contradicted(part, state) && !apart;
    state.gap = gap.or(state.gap);
    let newest = &state.newest;
    let Some(bindings) = newest.holds.clone() else {
        state.run = None;
        return;
    };
    if !newest.joins {
        state.run = None;
    }
    let run = state.run.get_or_insert_with(|| {
        let ordered = wants(part, |measure| *measure == Measure::Median).then(Default::default);
        let window = part.slides.then(Default::default);
        Box::new(Totals { start: newest.at, first_holds: newest.first_holds, ordered, window, ..Totals::default() })
    });
    run.last = newest.at;
    run.bindings = bindings;
    run.last_holds = newest.last_holds;
    if let (true, Some((before, _))) = (newest.bad_step, run.previous) {
        run.bad_step = Some(before);
    }
    if let Some(number) = newest.number {
        run.last_step = run.previous.map(|(at, before)| (at, before, number));
        run.previous = Some((newest.at, number));
    }
    if let (Some(ordered), Some(number)) = (&mut run.ordered, newest.number) {
        if ordered.count() < context.limits().of(Limit::MedianNumbers) {
            ordered.add(number);
        } else {
            // A median of a part of the numbers exists too, but it is not the required one.
            run.is_overfull = true;
            troubles.reached(Limit::MedianNumbers, context, site.place);
        }
    }
    let held = next - newest.at;
    match (&mut run.window, newest.number) {
        (Some(window), number) => {
            push(window, Point { at: newest.at, number, held, may_be_first: newest.first_holds });
            let ordered = &mut run.ordered;
            drop_before(window, next - part.duration_min, wants_held(part), |number| {
                if let Some(ordered) = ordered {
                    ordered.remove(number);
                }
            });
        }
        (None, Some(number)) => {
            run.moments.add(newest.at, number);
            run.held.add(number, held);
        }
        (None, None) => {}
    }
}

/// Joint verdict of the criteria at the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CriteriaVerdict {
    /// The newest sample belongs to no run.
    OutOfRun,
    /// The run is not long enough yet.
    Early,
    /// Something cannot be computed yet.
    Undefined,
    /// All hold.
    Holds,
    /// At least one does not hold.
    Fails,
}

/// Result of an evaluation.
pub(crate) struct Evaluated {
    /// The result that continues to hold.
    pub(crate) found: Option<Satisfaction>,
    /// Results that are over.
    pub(crate) over: Vec<Satisfaction>,
    /// The result of a run that a lack of samples has ended; the next sample ends it with the same result.
    pub(crate) closed_by_time: Option<Satisfaction>,
    /// Verdict of the criteria at the end.
    pub(crate) outcome: CriteriaVerdict,
}

/// Known facts of a run, for explanations.
pub(crate) struct RunSummary {
    pub(crate) start: Time,
    pub(crate) samples: u64,
    /// Instant at which the run or window is long enough, if that lies ahead.
    pub(crate) long_enough_at: Option<Time>,
    pub(crate) gap: Option<Duration>,
    pub(crate) judgements: Vec<(Criterion, CriterionResult)>,
}

/// The evaluation of one object's run.
pub(crate) struct Evaluation<'a> {
    pub(crate) part: &'a StatisticalPart,
    pub(crate) site: PartContext,
    pub(crate) object: &'a Value,
    pub(crate) context: &'a dyn EvalContext,
}

impl Evaluation<'_> {
    fn bench<'b>(&'b self, variable: &'b StateVariable) -> CriterionContext<'b> {
        let dimension = self.part.dimension.unwrap_or_default();
        CriterionContext { variable, dimension, context: self.context, place: self.site.place }
    }

    fn variable(&self) -> StateVariable {
        let attribute = self.part.condition.variable.attribute.clone();
        StateVariable { attribute, object: self.object.clone() }
    }

    /// Returns true if the step between two numbers satisfies all constraints on steps.
    pub(crate) fn step_holds(&self, before: f64, after: f64, troubles: &mut ConditionFaults) -> bool {
        let steps = self.part.criteria.iter().filter(|criterion| criterion.measure == Measure::Step);
        let mut holds = true;
        for criterion in steps {
            let variable = self.variable();
            holds &= self.bench(&variable).step_holds(criterion, before, after).unwrap_or_else(|error| {
                troubles.add(error);
                false
            });
        }
        holds
    }

    /// Returns the start of the run that contains the newest sample.
    fn start(&self, state: &NumberRun) -> Option<Time> {
        state.newest.holds.as_ref()?;
        Some(state.run.as_ref().filter(|_| state.newest.joins).map_or(state.newest.at, |run| run.start))
    }

    /// Evaluates the run with the newest sample, up to and including `horizon`.
    pub(crate) fn up_to(&self, state: &NumberRun, horizon: Time, troubles: &mut ConditionFaults) -> Evaluated {
        let mut evaluated = Evaluated {
            found: state.found.clone(),
            over: Vec::new(),
            closed_by_time: None,
            outcome: CriteriaVerdict::OutOfRun,
        };
        if let Err(error) = self.advance(state, horizon, &mut evaluated) {
            troubles.add(error);
        }
        evaluated
    }

    fn advance(&self, state: &NumberRun, horizon: Time, evaluated: &mut Evaluated) -> Result<(), EvaluationError> {
        let part = self.part;
        let newest = &state.newest;
        if let Some(run) = state.run.as_ref().filter(|_| newest.holds.is_none() || !newest.joins) {
            evaluated.over.extend(evaluated.found.take());
            if part.at_close {
                let silent = part.gap_max.map(|most| run.last + most + TICK);
                let known_at = silent.map_or(newest.at, |silent| silent.min(newest.at));
                evaluated.over.extend(self.at(state, false, run.last, known_at)?.1);
            }
        }
        let Some(start) = self.start(state) else { return Ok(()) };
        if part.at_close {
            let over_at = part.gap_max.map(|most| newest.at + most + TICK).filter(|over_at| *over_at <= horizon);
            evaluated.outcome = CriteriaVerdict::Early;
            if let Some(over_at) = over_at {
                (evaluated.outcome, evaluated.closed_by_time) = self.at(state, true, newest.at, over_at)?;
            }
            return Ok(());
        }
        let instants = self.licensed(state, start, (newest.at - TICK, horizon), usize::MAX);
        for at in std::iter::once(newest.at).chain(instants.into_iter().filter(|at| *at > newest.at)) {
            self.step(state, at, evaluated)?;
            if self.site.keep == Keep::First && evaluated.found.is_some() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Evaluates at an instant: a result begins, continues or ends.
    fn step(&self, state: &NumberRun, at: Time, evaluated: &mut Evaluated) -> Result<(), EvaluationError> {
        let (outcome, result) = self.at(state, true, at, at)?;
        evaluated.outcome = outcome;
        match (result, &mut evaluated.found) {
            (None, found) => evaluated.over.extend(found.take()),
            (Some(result), None) => evaluated.found = Some(result),
            // A result that continues to hold is one result: from the first sample of the run, or of the first window, on.
            (Some(result), Some(found)) => {
                let interval = (found.interval.0, result.interval.1);
                *found = Satisfaction { interval, recognised_at: found.recognised_at, ..result };
            }
        }
        Ok(())
    }

    /// Returns the instants after `after` and up to `horizon` at which time alone may change the verdict, within the span for which the
    /// sampling quality extends the last value.
    fn licensed(&self, state: &NumberRun, start: Time, (after, horizon): (Time, Time), count: usize) -> Vec<Time> {
        let part = self.part;
        let Some(most) = part.gap_max else { return Vec::new() };
        let (newest, until) = (state.newest.at, horizon.min(state.newest.at + most));
        let long_enough = start + part.duration_min;
        let mut instants = Vec::new();
        if long_enough > newest && long_enough > after && part.duration_min > Duration::ZERO {
            instants.push(long_enough);
        }
        if let Some(window) = state.run.as_ref().filter(|_| state.newest.joins).and_then(|run| run.window.as_ref()) {
            instants.extend(leaving(window, part.duration_min, (after.max(newest).max(long_enough), until), count));
        }
        if part.slides {
            let empty = newest + part.duration_min + TICK;
            instants.extend((empty > after && instants.len() < count).then_some(empty));
        }
        instants.retain(|at| *at <= until);
        if let Some(limits) = WeightedLimits::of(&part.criteria, self.context) {
            let first = newest.max(after).max(long_enough);
            limits.add_crossings((first, until), &mut instants, &|at| self.gather(state, true, at).held);
        }
        instants.truncate(count);
        instants
    }

    /// Requests a wake at the next foreseeable instant at which time alone changes the verdict of the criteria.
    pub(crate) fn foresee(&self, state: &NumberRun, outcome: CriteriaVerdict, query: &mut VerdictQuery<'_>) {
        let Some(start) = self.start(state) else { return };
        if self.part.at_close {
            if let Some(over_at) = self.part.gap_max.map(|most| state.newest.at + most + TICK) {
                query.wake_at_after_now(over_at);
            }
            return;
        }
        let instants = self.licensed(state, start, (query.now, Time::END), WINDOW_FORESIGHT_MAX);
        let more = instants.len() == WINDOW_FORESIGHT_MAX;
        let last = instants.last().copied().filter(|_| more);
        let decides = |then: CriteriaVerdict| match then {
            CriteriaVerdict::Holds => true,
            CriteriaVerdict::Fails => outcome != CriteriaVerdict::Fails,
            CriteriaVerdict::OutOfRun | CriteriaVerdict::Early | CriteriaVerdict::Undefined => {
                outcome == CriteriaVerdict::Holds
            }
        };
        let first = instants.into_iter().find(|at| self.at(state, true, *at, *at).is_ok_and(|(then, _)| decides(then)));
        if let Some(at) = first.or(last) {
            query.wake_at_after_now(at);
        }
    }

    /// Returns the verdict of the criteria about the run up to `at`, with or without the newest sample, and the result if they hold.
    fn at(
        &self,
        state: &NumberRun,
        with_newest: bool,
        at: Time,
        recognised_at: Time,
    ) -> Result<(CriteriaVerdict, Option<Satisfaction>), EvaluationError> {
        let part = self.part;
        let run = state.run.as_deref().filter(|_| !with_newest || state.newest.joins);
        let start = run.map_or(state.newest.at, |run| run.start);
        if at - start < part.duration_min && !part.at_close {
            return Ok((CriteriaVerdict::Early, None));
        }
        // If the run may have begun before the oldest remembered sample, it is not known as a whole.
        if !part.slides && part.first_known == Some(start) {
            return Ok((CriteriaVerdict::Undefined, None));
        }
        let numbers = self.gather(state, with_newest, at);
        let variable = self.variable();
        let bench = self.bench(&variable);
        let mut outcome = CriteriaVerdict::Holds;
        let mut values = Vec::new();
        for criterion in &part.criteria {
            match bench.judge(criterion, &numbers)? {
                CriterionResult::Fails(_) => return Ok((CriteriaVerdict::Fails, None)),
                CriterionResult::Undefined(_) => outcome = CriteriaVerdict::Undefined,
                CriterionResult::Holds(value) => values.push((criterion, value)),
            }
        }
        let ends = if with_newest {
            // The first sample of a sliding window changes as the window moves.
            let first = if part.slides { numbers.first_holds } else { run.map(|run| run.first_holds) };
            (first.unwrap_or(state.newest.first_holds), state.newest.last_holds)
        } else if part.slides {
            (numbers.first_holds.unwrap_or(false), run.is_some_and(|run| run.last_holds))
        } else {
            run.map_or((false, false), |run| (run.first_holds, run.last_holds))
        };
        if outcome != CriteriaVerdict::Holds {
            return Ok((outcome, None));
        }
        if ends != (true, true) || !self.bounds_hold(&numbers, at)? {
            return Ok((CriteriaVerdict::Fails, None));
        }
        let (first, last) = numbers.interval;
        let samples =
            Evidence::Run { variable: variable.clone(), start: first, end: last, samples: numbers.moments.count() };
        let computed = values
            .into_iter()
            .map(|(criterion, value)| Evidence::Aggregate(Box::new(bench.aggregate(criterion, value, &numbers))));
        let bindings = match (with_newest, run) {
            (true, _) => state.newest.holds.clone().unwrap_or_default(),
            (false, run) => run.map(|run| run.bindings.clone()).unwrap_or_default(),
        };
        let evidence = std::iter::once(samples).chain(computed).collect();
        Ok((outcome, Some(Satisfaction { interval: numbers.interval, recognised_at, bindings, evidence })))
    }

    /// Returns true if the constraints on start and end of the evidence hold, and those on the duration of the run or window up to `at`.
    fn bounds_hold(&self, numbers: &RunStatistics, at: Time) -> Result<bool, EvaluationError> {
        let timing = &self.part.condition.timing;
        let (start, end) = numbers.interval;
        let holds = |constraints: &[_], value: Value, reading| {
            all(constraints, &value, reading, &mut Bindings::new(), self.context, self.site.place)
        };
        let lasted = if self.part.slides { self.part.duration_min } else { at - start };
        Ok(holds(&timing.start, Value::Time(start), RightSide::Instant)?
            && holds(&timing.end, Value::Time(end), RightSide::Instant)?
            && holds(&timing.duration, Value::Duration(lasted), RightSide::Span)?)
    }

    /// Returns the numbers of the run, or of the window that ends at `at`.
    fn gather(&self, state: &NumberRun, with_newest: bool, at: Time) -> RunStatistics {
        let newest = &state.newest;
        let run = state.run.as_deref().filter(|_| !with_newest || newest.joins);
        let from = if self.part.slides { at - self.part.duration_min } else { Time::BEGINNING };
        let mut numbers = RunStatistics::default();
        let mut left = Vec::new();
        let mut bad_step = None;
        let mut first = None;
        if let Some(run) = run {
            (numbers.moments, numbers.held) = (run.moments, run.held);
            numbers.last_two = run.last_step.filter(|(at, ..)| *at >= from).map(|(_, before, number)| (before, number));
            bad_step = run.bad_step;
            numbers.interval = (run.start, run.last);
            if let Some(window) = &run.window {
                let inside = contents(window, from);
                numbers.first_holds = inside.first.map(|_| inside.first_holds);
                (numbers.moments, numbers.held, left, first) = (inside.moments, inside.held, inside.left, inside.first);
            }
        }
        let previous = run.and_then(|run| run.previous);
        let number = newest.number.filter(|_| with_newest && newest.at >= from);
        if let Some(number) = number {
            numbers.moments.add(newest.at, number);
            numbers.held.add(number, at - newest.at);
            numbers.last_two = previous.filter(|(at, _)| *at >= from).map(|(_, before)| (before, number));
            if newest.bad_step {
                bad_step = previous.map(|(before, _)| before).or(bad_step);
            }
        }
        numbers.bad_step = bad_step.is_some_and(|before| before >= from);
        numbers.is_overfull = run.is_some_and(|run| run.is_overfull);
        numbers.median = match run.and_then(|run| run.ordered.as_ref()) {
            _ if numbers.is_overfull => None,
            Some(ordered) => ordered.median(number, &left),
            None => number,
        };
        let last = run.map_or(newest.at, |run| if with_newest { newest.at } else { run.last });
        numbers.interval = match run.filter(|_| !self.part.slides) {
            Some(run) => (run.start, last),
            None => (first.unwrap_or(last), last),
        };
        numbers
    }

    /// Returns the known facts of the present run; `None` if the newest sample belongs to no run.
    pub(crate) fn standing(&self, state: &NumberRun, now: Time) -> Option<RunSummary> {
        let start = self.start(state)?;
        let numbers = self.gather(state, true, state.newest.at);
        let variable = self.variable();
        let bench = self.bench(&variable);
        let judged = self
            .part
            .criteria
            .iter()
            .filter_map(|criterion| Some((criterion.clone(), bench.judge(criterion, &numbers).ok()?)));
        let silent = self.part.gap_max.is_some_and(|most| now - state.newest.at > most);
        Some(RunSummary {
            start,
            samples: numbers.moments.count(),
            long_enough_at: Some(start + self.part.duration_min).filter(|at| *at > now && !silent),
            gap: state.gap,
            judgements: judged.collect(),
        })
    }
}

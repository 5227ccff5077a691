//! Run update (M&I)
//! What: computes the state of a run of samples after its newest sample and at a later instant.
//! Runs: from episode detection, for the past (a later sample has arrived) and for the present (a verdict is requested).
//! Reads: the episode part, evaluation context.
//! Writes: nothing; the caller keeps what is final.
//! Bound: O(1); any pair of samples: O(run).
//! PDL: `:quality`, `:timing`.
//! Paper: section IV example 1.

use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::constraints::{RightSide, all};
use crate::monitoring::part::{ConditionFaults, PartContext};
use crate::monitoring::time_bounds::TICK;
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{EpisodePart, Keep, ObjectRun, Run, Satisfaction};
use apex_model::because::Evidence;
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::limits::MONITOR_RESULTS_MAX;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// A run with its newest sample taken into account.
pub(crate) struct Judged {
    /// The run that the newest sample belongs to.
    pub(crate) run: Option<Run>,
    /// Its result, if the open run has one.
    pub(crate) found: Option<Satisfaction>,
    /// Results of runs that the newest sample ended, and of pairs that it completes.
    pub(crate) over: Vec<Satisfaction>,
    /// The result of a run that ended because no sample came for longer than the gap allows. Not final here: the next
    /// sample ends the run with the same result.
    pub(crate) closed_by_time: Option<Satisfaction>,
    /// See [`ObjectRun::contradicted`].
    pub(crate) contradicted: bool,
    /// See [`ObjectRun::gap`].
    pub(crate) gap: Option<Duration>,
}

/// Adds the newest sample to the run and lets time pass up to and including `horizon`.
pub(crate) fn advance_run(
    part: &EpisodePart,
    site: PartContext,
    object: &Value,
    state: &ObjectRun,
    horizon: Time,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> Judged {
    let judge = Judge { part, site, object, context };
    match judge.advance(state, horizon) {
        Ok(judged) => {
            if forgets_a_start(part, state, judged.run.as_ref()) {
                troubles.too_many_results(site.place);
            }
            judged
        }
        Err(error) => {
            troubles.add(error);
            let run = with_newest(part, state);
            Judged {
                run,
                found: None,
                over: Vec::new(),
                closed_by_time: None,
                contradicted: state.contradicted,
                gap: state.gap,
            }
        }
    }
}

/// Returns true if the first sample of the run is dropped, because there are too many pairs of samples.
fn forgets_a_start(part: &EpisodePart, state: &ObjectRun, run: Option<&Run>) -> bool {
    let full = |old: &Run| part.any_pair && old.instants.len() >= MONITOR_RESULTS_MAX;
    state.run.as_ref().is_some_and(|old| full(old) && run.is_some_and(|new| new.samples > old.samples))
}

/// Returns the run that contains the newest sample: the extended one, a new one, or none.
pub(crate) fn with_newest(part: &EpisodePart, state: &ObjectRun) -> Option<Run> {
    let newest = &state.newest;
    let bindings = newest.holds.as_ref()?;
    let instants = |before: &[Time]| match part.any_pair && part.points.is_none() {
        true => {
            let kept = before.len().saturating_sub(MONITOR_RESULTS_MAX - 1);
            // Only a sample with a fitting first value may begin a pair.
            let begins = newest.first_holds.then_some(newest.at);
            before.iter().skip(kept).copied().chain(begins).collect()
        }
        false => Vec::new(),
    };
    Some(match &state.run {
        Some(run) if newest.joins && gap_cut(part, state).is_none() => Run {
            last: newest.at,
            samples: run.samples.saturating_add(1),
            bindings: bindings.clone(),
            last_holds: newest.last_holds,
            instants: instants(&run.instants),
            ..*run
        },
        _ => Run {
            start: newest.at,
            last: newest.at,
            samples: 1,
            bindings: bindings.clone(),
            first_holds: newest.first_holds,
            last_holds: newest.last_holds,
            instants: instants(&[]),
        },
    })
}

/// Returns the gap between the run and the newest sample, if it is too long.
pub(crate) fn gap_cut(part: &EpisodePart, state: &ObjectRun) -> Option<Duration> {
    let gap = state.newest.at - state.run.as_ref()?.last;
    part.gap_max.filter(|most| gap > *most).map(|_| gap)
}

struct Judge<'a> {
    part: &'a EpisodePart,
    site: PartContext,
    object: &'a Value,
    context: &'a dyn EvalContext,
}

impl Judge<'_> {
    fn advance(&self, state: &ObjectRun, horizon: Time) -> Result<Judged, EvaluationError> {
        let part = self.part;
        let newest = &state.newest;
        let gap = gap_cut(part, state);
        let run = with_newest(part, state);
        let goes_on = run.as_ref().zip(state.run.as_ref()).is_some_and(|(new, old)| new.samples > old.samples);
        let mut judged = Judged {
            run: None,
            found: state.found.clone(),
            over: Vec::new(),
            closed_by_time: None,
            contradicted: newest.holds.is_none()
                || (gap.is_none() && (state.contradicted || (state.run.is_some() && !goes_on))),
            gap: gap.or(state.gap),
        };
        if let Some(old) = state.run.as_ref().filter(|_| !goes_on) {
            match judged.found.take() {
                Some(found) => judged.over.push(found),
                None if part.at_close && !part.any_pair && self.qualifies_when_over(old)? => {
                    let known_at =
                        part.gap_max.filter(|_| gap.is_some()).map_or(newest.at, |most| old.last + most + TICK);
                    judged.over.push(self.result(old, known_at));
                }
                None => {}
            }
        }
        if let Some(run) = &run {
            if part.points.is_some() {
                // The order makes pairs of the instants that it needs.
            } else if part.any_pair {
                self.pairs(run, &mut judged.over)?;
            } else if part.at_close {
                let over_at = part.gap_max.map(|most| run.last + most + TICK).filter(|over_at| *over_at <= horizon);
                if let Some(over_at) = over_at
                    && self.qualifies_when_over(run)?
                {
                    judged.closed_by_time = Some(self.result(run, over_at));
                }
            } else {
                self.while_open(run, horizon, &mut judged.found)?;
            }
        }
        judged.run = run;
        Ok(judged)
    }

    /// Evaluates an open run against lower bounds only: the sample that reaches them decides, or the instant at which the duration is
    /// reached while the sampling quality implies that the last value still holds.
    fn while_open(&self, run: &Run, horizon: Time, found: &mut Option<Satisfaction>) -> Result<(), EvaluationError> {
        if let Some(result) = found {
            if self.site.keep == Keep::Every {
                *result = self.result(run, result.recognised_at);
            }
            return Ok(());
        }
        let reached = run.start + self.part.duration_min;
        let known_at = match self.part.gap_max {
            _ if reached <= run.last => run.last,
            Some(most) if (reached <= run.last + most || planted::is(Bug::GapToNowForgotten)) && reached <= horizon => {
                reached
            }
            _ => return Ok(()),
        };
        if run.first_holds && run.last_holds && self.bounds_hold(run.start, run.last, false)? {
            *found = Some(self.result(run, known_at));
        }
        Ok(())
    }

    fn qualifies_when_over(&self, run: &Run) -> Result<bool, EvaluationError> {
        Ok(run.first_holds && run.last_holds && self.bounds_hold(run.start, run.last, true)?)
    }

    fn bounds_hold(&self, start: Time, end: Time, with_duration: bool) -> Result<bool, EvaluationError> {
        let timing = &self.part.condition.timing;
        let holds = |constraints, value: Value, reading| {
            all(constraints, &value, reading, &mut Bindings::new(), self.context, self.site.place)
        };
        Ok(holds(&timing.start, Value::Time(start), RightSide::Instant)?
            && holds(&timing.end, Value::Time(end), RightSide::Instant)?
            && (!with_duration || holds(&timing.duration, Value::Duration(end - start), RightSide::Span)?))
    }

    /// Adds the pairs of an earlier sample of the run with the newest one that satisfy the condition.
    fn pairs(&self, run: &Run, over: &mut Vec<Satisfaction>) -> Result<(), EvaluationError> {
        for start in &run.instants {
            if run.last_holds
                && run.last - *start >= self.part.duration_min
                && self.bounds_hold(*start, run.last, true)?
            {
                let pair =
                    Run { start: *start, samples: 2, instants: Vec::new(), bindings: run.bindings.clone(), ..*run };
                over.push(self.result(&pair, run.last));
            }
        }
        Ok(())
    }

    fn result(&self, run: &Run, recognised_at: Time) -> Satisfaction {
        result(self.part, self.object, run, recognised_at)
    }
}

/// Returns the run as a result.
pub(crate) fn result(part: &EpisodePart, object: &Value, run: &Run, recognised_at: Time) -> Satisfaction {
    let attribute = part.condition.variable.attribute.clone();
    let variable = StateVariable { attribute, object: object.clone() };
    Satisfaction {
        interval: (run.start, run.last),
        recognised_at,
        bindings: run.bindings.clone(),
        evidence: EvidenceList::one(Evidence::Run { variable, start: run.start, end: run.last, samples: run.samples }),
    }
}

/// Returns the result of a part that keeps the instants of samples for the pair of samples that bounds `interval`.
pub(crate) fn pair_of(part: &EpisodePart, interval: (Time, Time)) -> Option<Satisfaction> {
    let variable = part.variable.clone()?;
    let evidence = EvidenceList::one(Evidence::Run { variable, start: interval.0, end: interval.1, samples: 2 });
    Some(Satisfaction { interval, recognised_at: interval.1, bindings: Bindings::new(), evidence })
}

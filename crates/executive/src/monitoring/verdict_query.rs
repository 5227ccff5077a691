//! Verdict queries (M&I)
//! What: holds one query of a verdict: its evaluation context, the instant, the faults found, the next instant of interest.
//! Runs: with every verdict.
//! Reads: evaluation context.
//! Writes: nothing.
//! Bound: O(1).
//! PDL: all conditions.
//! Paper: section III, condition monitoring.

use super::part::ConditionFaults;
use super::reported_results::Used;
use crate::expression::EvalContext;
use apex_model::time::Time;

/// A query of the verdict of a monitor.
pub(crate) struct VerdictQuery<'a> {
    pub(crate) context: &'a dyn EvalContext,
    pub(crate) now: Time,
    pub(crate) troubles: ConditionFaults,
    pub(crate) wake: Option<Time>,
    /// Results of parts that do not count any longer.
    pub(crate) used: Option<Used>,
}

impl<'a> VerdictQuery<'a> {
    pub(crate) fn new(context: &'a dyn EvalContext) -> VerdictQuery<'a> {
        VerdictQuery { context, now: context.now(), troubles: ConditionFaults::none(context), wake: None, used: None }
    }

    /// Returns the answer of `ask` with all evidence counted, whenever it arrived.
    pub(crate) fn of_everything<T>(&mut self, ask: impl FnOnce(&mut VerdictQuery<'a>) -> T) -> T {
        let used = self.used.take();
        let answer = ask(self);
        self.used = used;
        answer
    }

    pub(crate) fn wake_at(&mut self, at: Time) {
        self.wake = Some(self.wake.map_or(at, |before| before.min(at)));
    }

    pub(crate) fn wake_at_after_now(&mut self, at: Time) {
        if at > self.now {
            self.wake_at(at);
        }
    }
}

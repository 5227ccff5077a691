//! Questions to monitors (M&I)
//! What: holds one question to a monitor: what it may see, the instant, the errors met, the next instant of interest.
//! Runs: with every verdict.
//! Reads: surroundings.
//! Writes: nothing.
//! Bound: O(1).
//! PDL: all conditions.
//! Paper: section III, condition monitoring.

use super::part::Troubles;
use super::told::Used;
use crate::expression::Surroundings;
use apex_model::time::Time;

/// A question to a monitor.
pub(crate) struct Asking<'a> {
    pub(crate) surroundings: &'a dyn Surroundings,
    pub(crate) now: Time,
    pub(crate) troubles: Troubles,
    pub(crate) wake: Option<Time>,
    /// Results of parts that do not count any longer.
    pub(crate) used: Option<Used>,
}

impl<'a> Asking<'a> {
    pub(crate) fn new(surroundings: &'a dyn Surroundings) -> Asking<'a> {
        Asking { surroundings, now: surroundings.now(), troubles: Troubles::default(), wake: None, used: None }
    }

    /// What `ask` says when everything counts.
    pub(crate) fn of_everything<T>(&mut self, ask: impl FnOnce(&mut Asking<'a>) -> T) -> T {
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

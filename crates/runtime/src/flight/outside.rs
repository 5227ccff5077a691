//! Advances a flight by the clock of an outside simulator.

use super::Flight;
use crate::error::RunError;
use crate::ports::Input;
use crate::run_settings::EndReason;
use apex_model::time::Time;

impl Flight<'_, '_> {
    /// Executes everything up to `to` with these inputs, for an outside clock. Returns `Some` if the run is over.
    pub(crate) fn advance(&mut self, to: Time, inputs: Vec<Input>) -> Result<Option<EndReason>, RunError> {
        if std::mem::take(&mut self.is_new)
            && let Some(reason) = self.live_instant(Time::ZERO, true)?
        {
            return Ok(Some(reason));
        }
        // The next input is popped off the end: inputs of one instant keep the order in which they arrived.
        let mut later: Vec<Input> = inputs.into_iter().rev().collect();
        later.append(&mut self.scheduled);
        later.sort_by_key(|input| std::cmp::Reverse(input.at));
        self.scheduled = later;
        while let Some(at) = self.next_instant().filter(|at| *at <= to) {
            if let Some(reason) = self.live_instant(at, false)? {
                return Ok(Some(reason));
            }
            if let Some(reason) = self.group.finish() {
                return Ok(Some(self.group.ended(reason)));
            }
        }
        self.now = self.now.max(to);
        Ok(None)
    }

    /// Returns the next instant at which the agents request a step, if no input arrives before.
    pub(crate) fn next_wake(&self) -> Option<Time> {
        self.next_instant()
    }

    /// Returns the names of the agents.
    pub(crate) fn names(&self) -> Vec<String> {
        (0..self.group.len()).filter_map(|index| Some(self.group.agent(index)?.name.printed().to_string())).collect()
    }

    /// Checks that an input is for an agent that exists.
    pub(crate) fn check(&self, input: &Input) -> Result<(), RunError> {
        self.group.check(input)
    }
}

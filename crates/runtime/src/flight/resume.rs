//! Continues a recorded flight from an instant on.

use super::Flight;
use crate::error::RunError;
use crate::ports::SolverJob;
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::event::SolverReport;
use apex_model::symbol::Symbol;
use apex_model::time::Time;

/// An answer to a request that is open when a recorded flight is continued.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OpenAnswer {
    /// The solver.
    pub(crate) solver: Symbol,
    /// The request, numbered as outside of the agents.
    pub(crate) request: SolveRequestId,
    /// Instant at which it takes effect.
    pub(crate) due: Time,
    /// The answer.
    pub(crate) report: SolverReport,
}

impl Flight<'_, '_> {
    /// Continues a flight whose agents, vehicle and deliberator have been advanced to `at`. `last_sequences` are the numbers of the
    /// agents' last events. Of the options' inputs, those later than `at` are used; `answers` to open requests take effect when they are
    /// due.
    pub(crate) fn resume(&mut self, at: Time, last_sequences: &[u64], answers: Vec<OpenAnswer>) {
        self.scheduled.retain(|input| input.at > at);
        self.group.resume(last_sequences);
        (self.now, self.is_new) = (at, false);
        for OpenAnswer { solver, request, due, report } in answers {
            self.pool.expect(solver, request, due, report);
        }
    }

    /// Poses and queues a request again that was open when the recorded flight ended.
    pub(crate) fn ask_again(
        &mut self,
        request: &SolveRequest,
        job: Box<dyn SolverJob>,
        at: Time,
    ) -> Result<(), RunError> {
        self.pool.request(request, at, job, !self.pacer.is_paced());
        self.show_answers(at)
    }
}

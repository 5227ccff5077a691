//! Compares the recorded answers of solvers with those that the agents received.

use crate::agent_group::Numbering;
use apex_model::effect::SolveRequestId;
use apex_model::event::{Batch, EventKind, SolverReport};
use apex_model::time::Time;
use std::collections::BTreeMap;

/// The recorded answers by request. Of several answers to one request the last counts, as for every reader.
pub(super) struct RecordedAnswers(BTreeMap<SolveRequestId, (Time, SolverReport)>);

/// An answer that an agent received, and that the record does not have among its answers.
pub(super) struct OtherAnswer {
    pub(super) request: SolveRequestId,
    pub(super) recorded: Option<String>,
    pub(super) received: String,
}

impl RecordedAnswers {
    pub(super) fn new(answers: &[(SolveRequestId, Time, SolverReport)]) -> RecordedAnswers {
        RecordedAnswers(answers.iter().map(|(request, due, report)| (*request, (*due, report.clone()))).collect())
    }

    /// Returns the first answer among the inputs of a step that differs from the recorded answer to its request.
    pub(super) fn check(&self, batch: &Batch, numbering: Numbering) -> Option<OtherAnswer> {
        batch.events.iter().find_map(|event| {
            let EventKind::SolverReported(request, report) = &event.kind else { return None };
            let request = SolveRequestId(numbering.outer(request.0));
            let recorded = self.0.get(&request);
            let is_same = recorded.is_some_and(|(due, stored)| *due == event.at && is_equal(stored, report));
            (!is_same).then(|| OtherAnswer {
                request,
                recorded: recorded.map(|(due, stored)| format!("{stored:?} at {due}")),
                received: format!("{report:?} at {}", event.at),
            })
        })
    }
}

/// Compares bytes, because a number that is not a number differs from itself.
fn is_equal(one: &SolverReport, other: &SolverReport) -> bool {
    let bytes = |report| postcard::to_stdvec(report).ok();
    bytes(one).is_some_and(|one| Some(one) == bytes(other))
}

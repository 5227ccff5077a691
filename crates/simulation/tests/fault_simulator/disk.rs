//! A recorder on a disk that becomes full at some instant.

use apex_executive::state::agent::Agent;
use apex_model::effect::{Effect, SolveRequest, SolveRequestId};
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::ports::{Deliberator, News, Observer, SolverAnswer};
use apex_runtime::record::Recorder;

/// The disk of a recorder.
pub(crate) struct FullDisk<'r> {
    recorder: &'r mut Recorder,
    full_from: Option<Time>,
}

impl FullDisk<'_> {
    /// Without an instant the disk has room for all.
    pub(crate) fn new(recorder: &mut Recorder, full_from: Option<Time>) -> FullDisk<'_> {
        FullDisk { recorder, full_from }
    }
}

impl Observer for FullDisk<'_> {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.recorder.turn(agent)
    }

    fn begin(&mut self, batch: &Batch) -> Result<(), String> {
        if self.full_from.is_some_and(|from| from <= batch.now) {
            // SQLite never shrinks a file below its present size, so this permits no further page.
            self.recorder.set_bytes_max(1).map_err(|error| error.to_string())?;
            self.full_from = None;
        }
        self.recorder.begin(batch)
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.recorder.observe(batch, effects)
    }

    fn inspect(&mut self, agent: &Agent, deliberator: &dyn Deliberator, now: Time) -> Result<(), String> {
        self.recorder.inspect(agent, deliberator, now)
    }

    fn posed(&mut self, request: &SolveRequest, at: Time, problem: &str) -> Result<(), String> {
        self.recorder.posed(request, at, problem)
    }

    fn answered(&mut self, request: SolveRequestId, due: Time, answer: &SolverAnswer) -> Result<(), String> {
        self.recorder.answered(request, due, answer)
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.recorder.note(at, text)
    }

    fn flush(&mut self) -> Result<(), String> {
        self.recorder.flush()
    }

    fn take_news(&mut self) -> Option<News> {
        self.recorder.take_news()
    }
}

//! A thread for solver jobs: requests are queued, answers are collected when they have arrived, and a job that never ends is abandoned.
//!
//! Jobs run in the order of requests. A job that is cancelled before its turn is not started. A panic is an answer.

use crate::limits::SOLVER_STACK_BYTES;
use crate::ports::{CancelToken, SolverAnswer, SolverJob, SolverQueue};
use crate::solver_words::panic_text;
use apex_model::effect::SolveRequestId;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::thread;

/// Returns an answer without a plan.
pub(crate) fn failed(reason: String) -> SolverAnswer {
    SolverAnswer { result: Err(reason), charged: Duration::ZERO }
}

/// A job in the queue.
struct Queued {
    request: SolveRequestId,
    solver: Symbol,
    job: Box<dyn SolverJob>,
    cancel: CancelToken,
}

impl Queued {
    fn run(self) -> SolverAnswer {
        let Queued { solver, job, cancel, .. } = self;
        if cancel.is_cancelled() {
            return failed("it was withdrawn before a solver thread began it".into());
        }
        match catch_unwind(AssertUnwindSafe(|| job.run(&cancel))) {
            Ok(answer) => answer,
            Err(payload) => failed(format!("the solver {solver} failed: {}", panic_text(&*payload))),
        }
    }
}

/// A request whose answer has not arrived.
struct PendingRequest {
    request: SolveRequestId,
    solver: Symbol,
    cancel: CancelToken,
    is_abandoned: bool,
}

/// The ends of the channels to the thread.
struct Worker {
    jobs: Sender<Queued>,
    answers: Receiver<(SolveRequestId, SolverAnswer)>,
}

impl Worker {
    fn start() -> Result<Worker, String> {
        let (jobs, queue) = channel::<Queued>();
        let (outbox, answers) = channel();
        let work = move || {
            while let Ok(queued) = queue.recv() {
                let request = queued.request;
                if outbox.send((request, queued.run())).is_err() {
                    return;
                }
            }
        };
        let builder = thread::Builder::new().name("solver".into()).stack_size(SOLVER_STACK_BYTES);
        builder.spawn(work).map_err(|error| format!("no thread could be started for the solver: {error}"))?;
        Ok(Worker { jobs, answers })
    }
}

/// A queue with one thread, which starts with the first job. A caller that waits gets a failed answer after the timeout.
///
/// While the thread is blocked by an abandoned job, further requests fail at once. When that job returns, its stale answer is dropped and
/// the next request is served again.
pub struct SolverThread {
    worker: Option<Worker>,
    timeout: std::time::Duration,
    /// In the order of requests.
    pending: Vec<PendingRequest>,
}

impl SolverThread {
    /// Returns a queue that waits for an answer for at most `timeout` of wall time.
    pub fn new(timeout: std::time::Duration) -> SolverThread {
        SolverThread { worker: None, timeout, pending: Vec::new() }
    }

    /// Removes an answer's request from the pending ones; `None` if it was abandoned.
    fn settle(&mut self, request: SolveRequestId, answer: SolverAnswer) -> Option<(SolveRequestId, SolverAnswer)> {
        let place = self.pending.iter().position(|pending| pending.request == request)?;
        let pending = self.pending.remove(place);
        (!pending.is_abandoned).then_some((request, answer))
    }

    /// Handles the end of the thread: the oldest request fails.
    fn ended(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        self.worker = None;
        let oldest = self.pending.first()?.request;
        self.settle(oldest, failed("deliberation has ended".into()))
    }

    fn abandon_oldest(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        let timeout_s = self.timeout.as_secs_f64();
        let oldest = self.pending.iter_mut().find(|pending| !pending.is_abandoned)?;
        oldest.is_abandoned = true;
        oldest.cancel.cancel();
        let reason = format!("the solver {} gave no answer within {timeout_s} s and was abandoned", oldest.solver);
        Some((oldest.request, failed(reason)))
    }
}

impl SolverQueue for SolverThread {
    fn submit(&mut self, request: SolveRequestId, solver: &Symbol, job: Box<dyn SolverJob>) -> Result<(), String> {
        // Answers to abandoned requests that have arrived in the meantime free the thread.
        while self.pending.iter().any(|pending| pending.is_abandoned) {
            let Some(worker) = &self.worker else { break };
            let Ok((answered, answer)) = worker.answers.try_recv() else { break };
            self.settle(answered, answer);
        }
        if let Some(hangs) = self.pending.iter().find(|pending| pending.is_abandoned) {
            return Err(format!("deliberation still hangs at request {}, which was abandoned", hangs.request.0));
        }
        let worker = match &mut self.worker {
            Some(worker) => worker,
            none => none.insert(Worker::start()?),
        };
        let cancel = CancelToken::new();
        let queued = Queued { request, solver: solver.clone(), job, cancel: cancel.clone() };
        self.pending.push(PendingRequest { request, solver: solver.clone(), cancel, is_abandoned: false });
        // A thread that has ended is noticed when the answer is fetched.
        let _ = worker.jobs.send(queued);
        Ok(())
    }

    fn cancel(&mut self, request: SolveRequestId) {
        for pending in self.pending.iter().filter(|pending| pending.request == request) {
            pending.cancel.cancel();
        }
    }

    fn try_recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        loop {
            let settled = match self.worker.as_ref()?.answers.try_recv() {
                Ok((request, answer)) => self.settle(request, answer),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => self.ended(),
            };
            if settled.is_some() {
                return settled;
            }
        }
    }

    fn recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        while self.pending.iter().any(|pending| !pending.is_abandoned) {
            let settled = match self.worker.as_ref().map(|worker| worker.answers.recv_timeout(self.timeout)) {
                Some(Ok((request, answer))) => self.settle(request, answer),
                Some(Err(RecvTimeoutError::Timeout)) => self.abandon_oldest(),
                Some(Err(RecvTimeoutError::Disconnected)) | None => self.ended(),
            };
            if settled.is_some() {
                return settled;
            }
        }
        None
    }
}

#[cfg(test)]
#[path = "solver_thread_tests.rs"]
mod tests;

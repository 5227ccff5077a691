//! A deliberator on a thread of its own: requests are left at its desk, answers fetched when they have come, and one that never
//! comes is given up.
//!
//! Requests are answered one after the other, in order. A withdrawn one that has not been begun is not begun.

use crate::invocation::panic_text;
use crate::limits::SOLVER_STACK_BYTES;
use crate::ports::{Deliberator, SolverAnswer, SolverDesk, Withdrawal};
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::thread;

/// An answer without a plan.
pub(crate) fn failed(reason: String) -> SolverAnswer {
    SolverAnswer { result: Err(reason), charged: Duration::ZERO }
}

/// Runs the deliberator on a thread and waits for it, so that its panic is an answer and not ours.
pub(crate) fn answer_on_thread(
    deliberator: &mut (dyn Deliberator + Send),
    request: &SolveRequest,
    at: Time,
) -> SolverAnswer {
    answer_wanted(deliberator, request, at, &Withdrawal::new())
}

fn answer_wanted(
    deliberator: &mut (dyn Deliberator + Send),
    request: &SolveRequest,
    at: Time,
    withdrawal: &Withdrawal,
) -> SolverAnswer {
    let outcome = thread::scope(|scope| {
        let builder = thread::Builder::new().name(format!("solver {}", request.solver)).stack_size(SOLVER_STACK_BYTES);
        let worker = builder.spawn_scoped(scope, || deliberator.deliberate(request, at, withdrawal));
        worker.map(thread::ScopedJoinHandle::join)
    });
    match outcome {
        Ok(Ok(answer)) => answer,
        Ok(Err(payload)) => failed(format!("the solver {} broke down: {}", request.solver, panic_text(&*payload))),
        Err(error) => failed(format!("no thread could be started for the solver {}: {error}", request.solver)),
    }
}

/// What lies on the desk.
struct Errand {
    request: SolveRequest,
    at: Time,
    withdrawal: Withdrawal,
}

/// A request whose answer has not come.
struct Open {
    request: SolveRequestId,
    solver: Symbol,
    withdrawal: Withdrawal,
    given_up: bool,
}

/// A deliberator on a thread that can be given up: where it is waited for, endless work becomes a failed answer after `patience`
/// of wall time.
///
/// While the thread is still at the request that was given up, further requests fail at once; when it comes back, its stale
/// answer is thrown away and the next request is served again.
pub struct Contained {
    errands: Sender<Errand>,
    answers: Receiver<(SolveRequestId, SolverAnswer)>,
    patience: std::time::Duration,
    /// In the order of requests.
    open: Vec<Open>,
}

impl Contained {
    /// Moves `deliberator` to its own thread.
    ///
    /// # Errors
    /// A sentence when the system gives no thread.
    pub fn new(
        mut deliberator: Box<dyn Deliberator + Send>,
        patience: std::time::Duration,
    ) -> Result<Contained, String> {
        let (errands, desk) = channel::<Errand>();
        let (outbox, answers) = channel();
        let work = move || {
            while let Ok(Errand { request, at, withdrawal }) = desk.recv() {
                let answer = if withdrawal.is_withdrawn() {
                    failed("it was withdrawn before anybody began with it".into())
                } else {
                    answer_wanted(&mut *deliberator, &request, at, &withdrawal)
                };
                if outbox.send((request.request, answer)).is_err() {
                    return;
                }
            }
        };
        let builder = thread::Builder::new().name("deliberation".into());
        builder.spawn(work).map_err(|error| format!("No thread could be started for deliberation: {error}."))?;
        Ok(Contained { errands, answers, patience, open: Vec::new() })
    }

    fn leave(&mut self, request: &SolveRequest, at: Time, withdrawal: Withdrawal) -> Result<(), String> {
        if let Some(hangs) = self.open.iter().find(|open| open.given_up) {
            return Err(format!("deliberation still hangs at request {}, which was given up", hangs.request.0));
        }
        let solver = request.solver.clone();
        self.open.push(Open { request: request.request, solver, withdrawal: withdrawal.clone(), given_up: false });
        // A thread that is gone is noticed when the answer is fetched.
        let _ = self.errands.send(Errand { request: request.clone(), at, withdrawal });
        Ok(())
    }

    /// Strikes an answer's request off; nothing where it was given up before.
    fn strike(&mut self, request: SolveRequestId, answer: SolverAnswer) -> Option<(SolveRequestId, SolverAnswer)> {
        let place = self.open.iter().position(|open| open.request == request)?;
        let open = self.open.remove(place);
        (!open.given_up).then_some((request, answer))
    }

    /// The thread is gone: the oldest request fails.
    fn ended(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        let oldest = self.open.first()?.request;
        self.strike(oldest, failed("deliberation has ended".into()))
    }

    fn give_up_oldest(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        let patience_s = self.patience.as_secs_f64();
        let oldest = self.open.iter_mut().find(|open| !open.given_up)?;
        oldest.given_up = true;
        oldest.withdrawal.withdraw();
        let reason = format!("the solver {} gave no answer within {patience_s} s and was given up", oldest.solver);
        Some((oldest.request, failed(reason)))
    }
}

impl SolverDesk for Contained {
    fn hand_over(&mut self, request: &SolveRequest, at: Time) -> Result<(), String> {
        self.leave(request, at, Withdrawal::new())
    }

    fn withdraw(&mut self, request: SolveRequestId) {
        for open in self.open.iter().filter(|open| open.request == request) {
            open.withdrawal.withdraw();
        }
    }

    fn take(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        loop {
            let taken = match self.answers.try_recv() {
                Ok((request, answer)) => self.strike(request, answer),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) if self.open.is_empty() => return None,
                Err(TryRecvError::Disconnected) => self.ended(),
            };
            if taken.is_some() {
                return taken;
            }
        }
    }

    fn wait(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        while self.open.iter().any(|open| !open.given_up) {
            let taken = match self.answers.recv_timeout(self.patience) {
                Ok((request, answer)) => self.strike(request, answer),
                Err(RecvTimeoutError::Timeout) => self.give_up_oldest(),
                Err(RecvTimeoutError::Disconnected) => self.ended(),
            };
            if taken.is_some() {
                return taken;
            }
        }
        None
    }
}

impl Deliberator for Contained {
    fn deliberate(&mut self, request: &SolveRequest, at: Time, withdrawal: &Withdrawal) -> SolverAnswer {
        // What came too late for those who waited.
        while self.take().is_some() {}
        if let Err(reason) = self.leave(request, at, withdrawal.clone()) {
            return failed(reason);
        }
        loop {
            match self.wait() {
                Some((answered, answer)) if answered == request.request => return answer,
                Some(_) => {}
                None => return failed("deliberation has ended".into()),
            }
        }
    }

    fn desk(&mut self) -> Option<&mut dyn SolverDesk> {
        Some(self)
    }
}

#[cfg(test)]
#[path = "contained_tests.rs"]
mod tests;

//! The solver pool: asks the deliberator on a thread of its own and holds answers until their time.
//!
//! In simulation a request made at `t` is answered at `t` plus the simulated time that the solver charges, whatever
//! the clock on the wall says, so the order of answers is the same in every run. A panic of a solver ends as an
//! answer, "failed". Endless work ends so too when the deliberator is wrapped in [`Contained`].

use crate::limits::SOLVER_STACK_BYTES;
use crate::ports::{Deliberator, Input, SolverAnswer};
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::event::{EventKind, SolverReport};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use std::any::Any;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;

/// Open requests with the answers that are not due yet.
#[derive(Debug, Default)]
pub struct SolverPool {
    open: BTreeMap<(Time, SolveRequestId), Open>,
}

#[derive(Debug)]
struct Open {
    solver: Symbol,
    report: SolverReport,
}

impl SolverPool {
    /// A pool without requests.
    pub fn new() -> SolverPool {
        SolverPool::default()
    }

    /// Deliberates on `request`, made at `at`; waits for the solver and keeps its answer until it is due.
    pub fn request(&mut self, deliberator: &mut (dyn Deliberator + Send), request: &SolveRequest, at: Time) {
        let answer = if self.open.len() >= SOLVE_REQUESTS_MAX {
            failed(format!("{SOLVE_REQUESTS_MAX} requests are open already; no more are taken"))
        } else {
            contain(deliberator, request, at)
        };
        let due = at + answer.charged.max(Duration::ZERO);
        let report = match answer.result {
            Ok(plan) => SolverReport::Plan(plan),
            Err(reason) => SolverReport::Failed(reason),
        };
        self.open.insert((due, request.request), Open { solver: request.solver.clone(), report });
    }

    /// Forgets a request; says so when there was an answer to drop.
    pub fn cancel(&mut self, request: SolveRequestId, now: Time) -> Option<String> {
        let key = self.open.keys().find(|(_, open)| *open == request).copied()?;
        let open = self.open.remove(&key)?;
        Some(format!(
            "the answer of {} to request {}, due at {}, was dropped: the request was cancelled at {now}",
            open.solver, request.0, key.0
        ))
    }

    /// When the next answer is due.
    pub fn next_due(&self) -> Option<Time> {
        self.open.first_key_value().map(|((due, _), _)| *due)
    }

    /// Moves the answers that are due at `now` into `inputs`, by due time and then by request.
    pub fn take_due(&mut self, now: Time, inputs: &mut Vec<Input>) {
        while let Some(first) = self.open.first_entry() {
            let (due, request) = *first.key();
            if due > now {
                return;
            }
            inputs.push(Input { at: due, kind: EventKind::SolverReported(request, first.remove().report) });
        }
    }

    /// Drops all answers that did not become due before the end of the run, and names them.
    pub fn close(&mut self, now: Time) -> Vec<String> {
        let open = std::mem::take(&mut self.open);
        let late = |((due, request), open): ((Time, SolveRequestId), Open)| {
            format!(
                "the answer of {} to request {}, due at {due}, came too late: the run ended at {now}",
                open.solver, request.0
            )
        };
        open.into_iter().map(late).collect()
    }
}

fn failed(reason: String) -> SolverAnswer {
    SolverAnswer { result: Err(reason), charged: Duration::ZERO }
}

/// Runs the deliberator on a thread, so that its panic is an answer and not ours.
fn contain(deliberator: &mut (dyn Deliberator + Send), request: &SolveRequest, at: Time) -> SolverAnswer {
    let outcome = thread::scope(|scope| {
        let builder = thread::Builder::new().name(format!("solver {}", request.solver)).stack_size(SOLVER_STACK_BYTES);
        let worker = builder.spawn_scoped(scope, || deliberator.deliberate(request, at));
        worker.map(thread::ScopedJoinHandle::join)
    });
    match outcome {
        Ok(Ok(answer)) => answer,
        Ok(Err(payload)) => failed(format!("the solver {} broke down: {}", request.solver, panic_text(&*payload))),
        Err(error) => failed(format!("no thread could be started for the solver {}: {error}", request.solver)),
    }
}

fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it gave no message".into())
}

/// A deliberator on a thread that can be given up: endless work becomes a failed answer after `patience` of wall time.
///
/// While the thread is still at the request that was given up, further requests fail at once; when it comes back, its
/// stale answer is thrown away and the next request is served again.
pub struct Contained {
    requests: Sender<(SolveRequest, Time)>,
    answers: Receiver<(SolveRequestId, SolverAnswer)>,
    patience: std::time::Duration,
    given_up: Option<SolveRequestId>,
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
        let (requests, inbox) = channel::<(SolveRequest, Time)>();
        let (outbox, answers) = channel();
        let work = move || {
            while let Ok((request, at)) = inbox.recv() {
                let answer = contain(&mut *deliberator, &request, at);
                if outbox.send((request.request, answer)).is_err() {
                    return;
                }
            }
        };
        let builder = thread::Builder::new().name("deliberation".into());
        builder.spawn(work).map_err(|error| format!("No thread could be started for deliberation: {error}."))?;
        Ok(Contained { requests, answers, patience, given_up: None })
    }

    fn throw_away_stale_answer(&mut self) {
        if self.given_up.is_some() && self.answers.try_recv().is_ok() {
            self.given_up = None;
        }
    }
}

impl Deliberator for Contained {
    fn deliberate(&mut self, request: &SolveRequest, at: Time) -> SolverAnswer {
        self.throw_away_stale_answer();
        if let Some(busy) = self.given_up {
            return failed(format!("deliberation still hangs at request {}, which was given up", busy.0));
        }
        if self.requests.send((request.clone(), at)).is_err() {
            return failed("deliberation has ended".into());
        }
        match self.answers.recv_timeout(self.patience) {
            Ok((_, answer)) => answer,
            Err(RecvTimeoutError::Timeout) => {
                self.given_up = Some(request.request);
                let patience_s = self.patience.as_secs_f64();
                failed(format!("the solver {} gave no answer within {patience_s} s and was given up", request.solver))
            }
            Err(RecvTimeoutError::Disconnected) => failed("deliberation has ended".into()),
        }
    }
}

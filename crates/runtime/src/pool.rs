//! The solver pool: open requests, and answers until they are due.
//!
//! In simulation, a request made at `t` is answered at `t` plus the simulated time that the solver charges, whatever the wall clock
//! shows: the pool queues the job and waits, and the order of answers is the same in every run. A paced flight queues the job and
//! continues. Its answer takes effect at the same instant, or on arrival if it arrives later, so a paced run in which no solver is late
//! writes the record of a fast one. An answer that arrives after a cancellation, or never, is reported.

use crate::limits::ANSWER_LATE_REPORTED_MIN;
use crate::ports::{Input, SolverAnswer, SolverJob, SolverQueue};
use crate::solver_thread::failed;
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::event::{EventKind, SolverReport};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use std::collections::BTreeMap;

/// Open requests, and answers that are not due yet.
pub struct SolverPool {
    queue: Box<dyn SolverQueue>,
    answered: BTreeMap<(Time, SolveRequestId), Answered>,
    submitted: BTreeMap<SolveRequestId, Submitted>,
    /// Answers that the observers have not seen.
    fresh: Vec<Arrival>,
}

#[derive(Debug)]
struct Answered {
    solver: Symbol,
    report: SolverReport,
}

/// A request in the queue.
#[derive(Debug)]
struct Submitted {
    solver: Symbol,
    at: Time,
    cancelled: Option<Time>,
}

/// An answer as it arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrival {
    /// The request that it answers.
    pub request: SolveRequestId,
    /// The instant at which it takes effect, unless the request was cancelled.
    pub due: Time,
    /// The answer.
    pub answer: SolverAnswer,
}

impl SolverPool {
    /// Returns a pool whose jobs run in `queue`.
    pub fn new(queue: Box<dyn SolverQueue>) -> SolverPool {
        SolverPool { queue, answered: BTreeMap::new(), submitted: BTreeMap::new(), fresh: Vec::new() }
    }

    /// Queues the job that answers `request`, made at `at`. With `waits`, it returns after the answer.
    pub fn request(&mut self, request: &SolveRequest, at: Time, job: Box<dyn SolverJob>, waits: bool) {
        let (id, solver) = (request.request, &request.solver);
        if self.answered.len() + self.submitted.len() >= SOLVE_REQUESTS_MAX {
            let full = failed(format!("{SOLVE_REQUESTS_MAX} requests are open already; no more are accepted"));
            return self.keep(solver.clone(), id, at, full);
        }
        if let Err(reason) = self.queue.submit(id, solver, job) {
            return self.keep(solver.clone(), id, at, failed(reason));
        }
        self.submitted.insert(id, Submitted { solver: solver.clone(), at, cancelled: None });
        while waits && self.submitted.contains_key(&id) {
            match self.queue.recv() {
                Some((answered, answer)) => {
                    self.arrived(answered, answer, at);
                }
                None => {
                    self.arrived(id, failed("deliberation has ended".into()), at);
                }
            }
        }
    }

    /// Takes the answers that arrived since the last call, in order of arrival.
    pub fn take_fresh(&mut self) -> Vec<Arrival> {
        std::mem::take(&mut self.fresh)
    }

    /// Keeps an answer from an earlier run until it is due.
    pub fn expect(&mut self, solver: Symbol, request: SolveRequestId, due: Time, report: SolverReport) {
        self.answered.insert((due, request), Answered { solver, report });
    }

    fn keep(&mut self, solver: Symbol, request: SolveRequestId, due: Time, answer: SolverAnswer) {
        self.fresh.push(Arrival { request, due, answer: answer.clone() });
        let report = match answer.result {
            Ok(plan) => SolverReport::Plan(plan),
            Err(reason) => SolverReport::Failed(reason),
        };
        self.answered.insert((due, request), Answered { solver, report });
    }

    /// Returns true while a job runs or is queued.
    pub fn is_waiting(&self) -> bool {
        !self.submitted.is_empty()
    }

    /// Returns true if the answer to a request that is not cancelled may still arrive.
    pub fn is_expecting(&self) -> bool {
        self.submitted.values().any(|open| open.cancelled.is_none())
    }

    /// Takes the answers that have arrived by now; with `wait`, waits for all. Returns notes about them, or `None` if none arrived.
    pub fn collect(&mut self, now: Time, wait: bool) -> Option<Vec<String>> {
        let mut notes: Option<Vec<String>> = None;
        while !self.submitted.is_empty() {
            let Some((request, answer)) = (if wait { self.queue.recv() } else { self.queue.try_recv() }) else { break };
            let note = self.arrived(request, answer, now);
            notes.get_or_insert_with(Vec::new).extend(note);
        }
        notes
    }

    /// Records that an answer has arrived at `now`.
    fn arrived(&mut self, request: SolveRequestId, answer: SolverAnswer, now: Time) -> Option<String> {
        let Submitted { solver, at, cancelled } = self.submitted.remove(&request)?;
        let due = at + answer.charged.max(Duration::ZERO);
        if let Some(cancelled) = cancelled {
            let what = match &answer.result {
                Ok(plan) => format!("a plan, {}", plan.summary),
                Err(reason) => format!("no plan, because {reason}"),
            };
            self.fresh.push(Arrival { request, due: due.max(now), answer });
            return Some(format!(
                "the answer of {solver} to request {} came at {now} and is not used, because the request was cancelled at \
                 {cancelled}: {what}",
                request.0
            ));
        }
        let late = now - due;
        self.keep(solver.clone(), request, due.max(now), answer);
        (late >= ANSWER_LATE_REPORTED_MIN).then(|| {
            format!(
                "the answer of {solver} to request {}, due at {due} by its work, came {:.1} s late",
                request.0,
                late.seconds()
            )
        })
    }

    /// Cancels a request; returns a note if an answer is dropped.
    pub fn cancel(&mut self, request: SolveRequestId, now: Time) -> Option<String> {
        if let Some(open) = self.submitted.get_mut(&request) {
            open.cancelled.get_or_insert(now);
            // Its answer is reported when it arrives.
            self.queue.cancel(request);
            return None;
        }
        let key = self.answered.keys().find(|(_, answered)| *answered == request).copied()?;
        let answered = self.answered.remove(&key)?;
        Some(format!(
            "the answer of {} to request {}, due at {}, was dropped: the request was cancelled at {now}",
            answered.solver, request.0, key.0
        ))
    }

    /// Returns the instant of the next due answer among those that have arrived.
    pub fn next_due(&self) -> Option<Time> {
        self.answered.first_key_value().map(|((due, _), _)| *due)
    }

    /// Moves the answers that are due at `now` into `inputs`, by due time and then by request.
    pub fn take_due(&mut self, now: Time, inputs: &mut Vec<Input>) {
        while let Some(first) = self.answered.first_entry() {
            let (due, request) = *first.key();
            if due > now {
                return;
            }
            inputs.push(Input::new(due, EventKind::SolverReported(request, first.remove().report)));
        }
    }

    /// Drops all answers that did not arrive or become due before the end of the run, and returns notes that name them.
    pub fn close(&mut self, now: Time) -> Vec<String> {
        let late = |((due, request), answered): ((Time, SolveRequestId), Answered)| {
            format!(
                "the answer of {} to request {}, due at {due}, came too late: the run ended at {now}",
                answered.solver, request.0
            )
        };
        let mut notes: Vec<String> = std::mem::take(&mut self.answered).into_iter().map(late).collect();
        for (request, open) in std::mem::take(&mut self.submitted) {
            self.queue.cancel(request);
            let Submitted { solver, at, cancelled } = open;
            let cancelled = cancelled.map(|cancelled| format!(" and cancelled at {cancelled}")).unwrap_or_default();
            notes.push(format!(
                "the answer of {solver} to request {}, made at {at}{cancelled}, had not come when the run ended at {now}",
                request.0
            ));
        }
        notes
    }
}

#[cfg(test)]
#[path = "pool_tests.rs"]
mod tests;

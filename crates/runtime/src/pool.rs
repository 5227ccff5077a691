//! The solver pool: requests that are open, and answers until their time.
//!
//! In simulation a request made at `t` is answered at `t` plus the simulated time that the solver charges, whatever the clock on
//! the wall says: the pool asks and waits, and the order of answers is the same in every run. A flight by the clock on the wall
//! does not wait: it leaves the request at the deliberator's desk and goes on. Its answer counts from the same instant, or, where it
//! comes later, from when it came, so a paced run in which no solver is late writes the record of a fast one. What comes after a
//! cancellation, or not at all, is told. A panic of a deliberator ends as an answer, "failed".

use crate::contained::{answer_on_thread, failed};
use crate::limits::ANSWER_LATE_TOLD_MIN;
use crate::ports::{Deliberator, Input, SolverAnswer};
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::event::{EventKind, SolverReport};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use std::collections::BTreeMap;

/// Open requests, and answers that are not due yet.
#[derive(Debug, Default)]
pub struct SolverPool {
    answered: BTreeMap<(Time, SolveRequestId), Answered>,
    handed_over: BTreeMap<SolveRequestId, HandedOver>,
}

#[derive(Debug)]
struct Answered {
    solver: Symbol,
    report: SolverReport,
}

/// A request at the desk.
#[derive(Debug)]
struct HandedOver {
    solver: Symbol,
    at: Time,
    cancelled: Option<Time>,
}

impl SolverPool {
    /// A pool without requests.
    pub fn new() -> SolverPool {
        SolverPool::default()
    }

    /// Has `request`, made at `at`, answered: waits for that, or leaves it at the deliberator's desk if it has one.
    pub fn request(
        &mut self,
        deliberator: &mut (dyn Deliberator + Send),
        request: &SolveRequest,
        at: Time,
        waits: bool,
    ) {
        let solver = request.solver.clone();
        if self.answered.len() + self.handed_over.len() >= SOLVE_REQUESTS_MAX {
            let full = failed(format!("{SOLVE_REQUESTS_MAX} requests are open already; no more are taken"));
            return self.keep(solver, request.request, at, full);
        }
        let answer = match deliberator.desk().filter(|_| !waits).map(|desk| desk.hand_over(request, at)) {
            Some(Ok(())) => {
                self.handed_over.insert(request.request, HandedOver { solver, at, cancelled: None });
                return;
            }
            Some(Err(reason)) => failed(reason),
            None => answer_on_thread(deliberator, request, at),
        };
        let due = at + answer.charged.max(Duration::ZERO);
        self.keep(solver, request.request, due, answer);
    }

    fn keep(&mut self, solver: Symbol, request: SolveRequestId, due: Time, answer: SolverAnswer) {
        let report = match answer.result {
            Ok(plan) => SolverReport::Plan(plan),
            Err(reason) => SolverReport::Failed(reason),
        };
        self.answered.insert((due, request), Answered { solver, report });
    }

    /// True when somebody is still at work on a request.
    pub fn is_waiting(&self) -> bool {
        !self.handed_over.is_empty()
    }

    /// True when an answer may still come that somebody wants.
    pub fn is_expecting(&self) -> bool {
        self.handed_over.values().any(|open| open.cancelled.is_none())
    }

    /// Takes the answers that have come by now, or, with `wait`, all. Nothing when none came, else what there is to tell of them.
    pub fn collect(
        &mut self,
        deliberator: &mut (dyn Deliberator + Send),
        now: Time,
        wait: bool,
    ) -> Option<Vec<String>> {
        let mut told = None;
        while !self.handed_over.is_empty() {
            let desk = deliberator.desk()?;
            let Some((request, answer)) = (if wait { desk.wait() } else { desk.take() }) else { break };
            let notes = told.get_or_insert_with(Vec::new);
            notes.extend(self.arrived(request, answer, now));
        }
        told
    }

    /// An answer has come at `now`.
    fn arrived(&mut self, request: SolveRequestId, answer: SolverAnswer, now: Time) -> Option<String> {
        let HandedOver { solver, at, cancelled } = self.handed_over.remove(&request)?;
        if let Some(cancelled) = cancelled {
            let what = match &answer.result {
                Ok(plan) => format!("a plan, {}", plan.summary),
                Err(reason) => format!("no plan, because {reason}"),
            };
            return Some(format!(
                "the answer of {solver} to request {} came at {now} and is not used, because the request was cancelled at \
                 {cancelled}: {what}",
                request.0
            ));
        }
        let due = at + answer.charged.max(Duration::ZERO);
        let late = now - due;
        self.keep(solver.clone(), request, due.max(now), answer);
        (late >= ANSWER_LATE_TOLD_MIN).then(|| {
            format!(
                "the answer of {solver} to request {}, due at {due} by its work, came {:.1} s late",
                request.0,
                late.seconds()
            )
        })
    }

    /// Forgets a request; says so when there was an answer to drop.
    pub fn cancel(
        &mut self,
        deliberator: &mut (dyn Deliberator + Send),
        request: SolveRequestId,
        now: Time,
    ) -> Option<String> {
        if let Some(open) = self.handed_over.get_mut(&request) {
            open.cancelled.get_or_insert(now);
            // Its answer is told when it comes.
            deliberator.desk()?.withdraw(request);
            return None;
        }
        let key = self.answered.keys().find(|(_, answered)| *answered == request).copied()?;
        let answered = self.answered.remove(&key)?;
        Some(format!(
            "the answer of {} to request {}, due at {}, was dropped: the request was cancelled at {now}",
            answered.solver, request.0, key.0
        ))
    }

    /// When the next answer is due, of those that have come.
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

    /// Drops all answers that did not become due, or did not come, before the end of the run, and names them.
    pub fn close(&mut self, deliberator: &mut (dyn Deliberator + Send), now: Time) -> Vec<String> {
        let late = |((due, request), answered): ((Time, SolveRequestId), Answered)| {
            format!(
                "the answer of {} to request {}, due at {due}, came too late: the run ended at {now}",
                answered.solver, request.0
            )
        };
        let mut told: Vec<String> = std::mem::take(&mut self.answered).into_iter().map(late).collect();
        for (request, open) in std::mem::take(&mut self.handed_over) {
            if let Some(desk) = deliberator.desk() {
                desk.withdraw(request);
            }
            let HandedOver { solver, at, cancelled } = open;
            let cancelled = cancelled.map(|cancelled| format!(" and cancelled at {cancelled}")).unwrap_or_default();
            told.push(format!(
                "the answer of {solver} to request {}, made at {at}{cancelled}, had not come when the run ended at {now}",
                request.0
            ));
        }
        told
    }
}

#[cfg(test)]
#[path = "pool_tests.rs"]
mod tests;

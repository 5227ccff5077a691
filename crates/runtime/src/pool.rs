//! The solver pool: asks the deliberator on a thread of its own and holds answers until their time.
//!
//! In simulation a request made at `t` is answered at `t` plus the simulated time that the solver charges, whatever
//! the clock on the wall says, so the order of answers is the same in every run. A panic of a solver ends as an
//! answer, "failed". Endless work ends so too when the deliberator is wrapped in [`Contained`].

use crate::invocation::panic_text;
use crate::limits::SOLVER_STACK_BYTES;
use crate::ports::{Deliberator, Input, SolverAnswer};
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::event::{EventKind, SolverReport};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
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
            inputs.push(Input::new(due, EventKind::SolverReported(request, first.remove().report)));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use apex_model::task::TaskId;
    use apex_model::value::Value;

    /// Answers by the goal: `plan`, `panic`, `hang`, anything else fails.
    struct Moody;

    impl Deliberator for Moody {
        fn deliberate(&mut self, request: &SolveRequest, _: Time) -> SolverAnswer {
            let charged = Duration::from_seconds(request.budget.map_or(0.0, Duration::seconds));
            if request.goal.equals(&Value::symbol("panic")) {
                panic!("ran out of ideas");
            }
            if request.goal.equals(&Value::symbol("hang")) {
                thread::sleep(std::time::Duration::from_millis(400));
            }
            let plan = request.goal.equals(&Value::symbol("plan"));
            SolverAnswer { result: if plan { Ok(samples::plan()) } else { Err("no idea".into()) }, charged }
        }
    }

    fn request(number: u64, goal: &str, budget_s: f64) -> SolveRequest {
        SolveRequest {
            request: SolveRequestId(number),
            task: TaskId(1),
            goal: Value::symbol(goal),
            solver: Symbol::new("auto"),
            budget: Some(Duration::from_seconds(budget_s)),
        }
    }

    fn due(pool: &mut SolverPool, seconds: f64) -> Vec<(u64, String)> {
        let mut inputs = Vec::new();
        pool.take_due(Time::from_seconds(seconds), &mut inputs);
        let said = |input: Input| match input.kind {
            EventKind::SolverReported(request, SolverReport::Plan(plan)) => (request.0, plan.summary),
            EventKind::SolverReported(request, SolverReport::Failed(reason)) => (request.0, reason),
            other => panic!("{other:?}"),
        };
        inputs.into_iter().map(said).collect()
    }

    #[test]
    fn answers_come_at_request_plus_charge_whatever_the_order_of_requests() {
        let mut pool = SolverPool::new();
        pool.request(&mut Moody, &request(1, "plan", 5.0), Time::from_seconds(10.0));
        pool.request(&mut Moody, &request(2, "nothing", 2.0), Time::from_seconds(10.0));
        assert_eq!(pool.next_due(), Some(Time::from_seconds(12.0)));
        assert_eq!(due(&mut pool, 11.9), []);
        assert_eq!(due(&mut pool, 20.0), [(2, "no idea".to_owned()), (1, "3 targets, value 12".to_owned())]);
    }

    #[test]
    fn a_panic_is_an_answer() {
        let mut pool = SolverPool::new();
        pool.request(&mut Moody, &request(1, "panic", 0.0), Time::ZERO);
        pool.request(&mut Moody, &request(2, "plan", 0.0), Time::ZERO);
        let said = due(&mut pool, 0.0);
        assert_eq!(said[0], (1, "the solver auto broke down: ran out of ideas".to_owned()));
        assert_eq!(said[1].1, "3 targets, value 12", "the next request is served");
    }

    #[test]
    fn dropped_answers_are_named() {
        let mut pool = SolverPool::new();
        pool.request(&mut Moody, &request(1, "plan", 5.0), Time::ZERO);
        pool.request(&mut Moody, &request(2, "plan", 9.0), Time::ZERO);
        let note = pool.cancel(SolveRequestId(1), Time::from_seconds(3.0)).unwrap();
        assert_eq!(note, "the answer of auto to request 1, due at 5s, was dropped: the request was cancelled at 3s");
        assert_eq!(pool.cancel(SolveRequestId(1), Time::from_seconds(3.0)), None);
        assert!(pool.close(Time::from_seconds(4.0))[0].contains("request 2, due at 9s, came too late"));
        assert_eq!(pool.next_due(), None);
    }

    #[test]
    fn too_many_requests_fail_at_once() {
        let mut pool = SolverPool::new();
        for number in 0..=SOLVE_REQUESTS_MAX as u64 {
            pool.request(&mut Moody, &request(number, "plan", 5.0), Time::ZERO);
        }
        assert!(due(&mut pool, 0.0)[0].1.contains("are open already"));
    }

    #[test]
    fn endless_work_is_given_up_and_the_solver_may_come_back() {
        let patience = std::time::Duration::from_millis(100);
        let mut contained = Contained::new(Box::new(Moody), patience).unwrap();
        let mut answer =
            |goal| contained.deliberate(&request(7, goal, 0.0), Time::ZERO).result.map(|plan| plan.summary);
        assert_eq!(answer("hang"), Err("the solver auto gave no answer within 0.1 s and was given up".to_owned()));
        assert_eq!(answer("plan"), Err("deliberation still hangs at request 7, which was given up".to_owned()));
        thread::sleep(std::time::Duration::from_millis(600));
        assert_eq!(answer("plan"), Ok("3 targets, value 12".to_owned()));
    }
}

//! The pool with deliberators that are waited for, and with a desk.

use super::*;
use crate::ports::{SolverDesk, Withdrawal};
use crate::samples;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Answers by the goal: `plan`, `panic`, anything else fails.
struct Moody;

impl Deliberator for Moody {
    fn deliberate(&mut self, request: &SolveRequest, _: Time, _: &Withdrawal) -> SolverAnswer {
        let charged = Duration::from_seconds(request.budget.map_or(0.0, Duration::seconds));
        if request.goal.equals(&Value::symbol("panic")) {
            panic!("ran out of ideas");
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
    pool.request(&mut Moody, &request(1, "plan", 5.0), Time::from_seconds(10.0), true);
    pool.request(&mut Moody, &request(2, "nothing", 2.0), Time::from_seconds(10.0), true);
    assert_eq!(pool.next_due(), Some(Time::from_seconds(12.0)));
    assert_eq!(due(&mut pool, 11.9), []);
    assert_eq!(due(&mut pool, 20.0), [(2, "no idea".to_owned()), (1, "3 targets, value 12".to_owned())]);
}

#[test]
fn a_panic_is_an_answer() {
    let mut pool = SolverPool::new();
    pool.request(&mut Moody, &request(1, "panic", 0.0), Time::ZERO, true);
    pool.request(&mut Moody, &request(2, "plan", 0.0), Time::ZERO, true);
    let said = due(&mut pool, 0.0);
    assert_eq!(said[0], (1, "the solver auto broke down: ran out of ideas".to_owned()));
    assert_eq!(said[1].1, "3 targets, value 12", "the next request is served");
}

#[test]
fn dropped_answers_are_named() {
    let mut pool = SolverPool::new();
    pool.request(&mut Moody, &request(1, "plan", 5.0), Time::ZERO, true);
    pool.request(&mut Moody, &request(2, "plan", 9.0), Time::ZERO, true);
    let note = pool.cancel(&mut Moody, SolveRequestId(1), Time::from_seconds(3.0)).unwrap();
    assert_eq!(note, "the answer of auto to request 1, due at 5s, was dropped: the request was cancelled at 3s");
    assert_eq!(pool.cancel(&mut Moody, SolveRequestId(1), Time::from_seconds(3.0)), None);
    assert!(pool.close(&mut Moody, Time::from_seconds(4.0))[0].contains("request 2, due at 9s, came too late"));
    assert_eq!(pool.next_due(), None);
}

#[test]
fn too_many_requests_fail_at_once() {
    let mut pool = SolverPool::new();
    for number in 0..=SOLVE_REQUESTS_MAX as u64 {
        pool.request(&mut Moody, &request(number, "plan", 5.0), Time::ZERO, true);
    }
    assert!(due(&mut pool, 0.0)[0].1.contains("are open already"));
}

/// Keeps requests until the test says that they are answered.
#[derive(Default)]
struct Office {
    open: Vec<SolveRequestId>,
    withdrawn: Vec<u64>,
    ready: bool,
}

impl Deliberator for Office {
    fn deliberate(&mut self, _: &SolveRequest, _: Time, _: &Withdrawal) -> SolverAnswer {
        panic!("nobody waits here")
    }
    fn desk(&mut self) -> Option<&mut dyn SolverDesk> {
        Some(self)
    }
}

impl SolverDesk for Office {
    fn hand_over(&mut self, request: &SolveRequest, _: Time) -> Result<(), String> {
        self.open.push(request.request);
        Ok(())
    }
    fn withdraw(&mut self, request: SolveRequestId) {
        self.withdrawn.push(request.0);
    }
    fn take(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        if self.ready { self.wait() } else { None }
    }
    fn wait(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        let answer = SolverAnswer { result: Ok(samples::plan()), charged: Duration::from_seconds(5.0) };
        (!self.open.is_empty()).then(|| (self.open.remove(0), answer))
    }
}

#[test]
fn an_answer_from_the_desk_counts_at_its_charge_or_when_it_comes_whichever_is_later() {
    let at = Time::from_seconds;
    for (came, counts, told) in
        [(2.0, 5.0, None), (5.5, 5.5, None), (90.0, 90.0, Some("due at 5s by its work, came 85.0 s late"))]
    {
        let (mut pool, mut office) = (SolverPool::new(), Office::default());
        pool.request(&mut office, &request(1, "plan", 0.0), Time::ZERO, false);
        assert_eq!(pool.collect(&mut office, at(1.0), false), None, "nothing has come");
        assert!(pool.is_expecting() && pool.next_due().is_none());
        office.ready = true;
        let notes = pool.collect(&mut office, at(came), false).unwrap();
        assert_eq!(notes.len(), usize::from(told.is_some()), "{notes:?}");
        assert!(told.is_none_or(|told| notes[0].contains(told)), "{notes:?}");
        assert_eq!(pool.next_due(), Some(at(counts)));
        assert!(!pool.is_waiting());
    }
}

#[test]
fn who_leaves_the_clock_waits_for_the_desk() {
    let (mut pool, mut office) = (SolverPool::new(), Office::default());
    for number in 1..=3 {
        pool.request(&mut office, &request(number, "plan", 0.0), Time::ZERO, false);
    }
    assert_eq!(pool.collect(&mut office, Time::ZERO, true), Some(Vec::new()));
    assert_eq!(due(&mut pool, 5.0).len(), 3);
}

#[test]
fn answers_from_the_desk_that_nobody_wants_are_told_and_not_used() {
    let (mut pool, mut office) = (SolverPool::new(), Office::default());
    for number in 1..=2 {
        pool.request(&mut office, &request(number, "plan", 0.0), Time::ZERO, false);
    }
    assert_eq!(pool.cancel(&mut office, SolveRequestId(1), Time::from_seconds(3.0)), None);
    assert_eq!((office.withdrawn.as_slice(), pool.is_expecting()), ([1].as_slice(), true));
    (office.ready, office.open) = (true, vec![SolveRequestId(1)]);
    let notes = pool.collect(&mut office, Time::from_seconds(4.0), false).unwrap();
    assert_eq!(
        notes,
        [
            "the answer of auto to request 1 came at 4s and is not used, because the request was cancelled at 3s: a plan, 3 targets, value 12"
        ]
    );
    assert_eq!(due(&mut pool, 1e3), []);
    let end = pool.close(&mut office, Time::from_seconds(9.0));
    assert_eq!(end, ["the answer of auto to request 2, made at 0s, had not come when the run ended at 9s"]);
    assert_eq!(office.withdrawn, [1, 2]);
}

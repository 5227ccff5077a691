//! The pool with a solver thread, and with a queue whose answers the test releases.

use super::*;
use crate::ports::CancelToken;
use crate::samples;
use crate::solver_thread::SolverThread;
use apex_model::task::TaskId;
use apex_model::value::Value;
use std::cell::RefCell;
use std::rc::Rc;

/// Returns a job that answers by the goal: `plan`, `panic`, anything else fails.
fn job(request: &SolveRequest) -> Box<dyn SolverJob> {
    let charged = Duration::from_seconds(request.budget.map_or(0.0, Duration::seconds));
    let is = |goal| request.goal.equals(&Value::symbol(goal));
    let (panics, plans) = (is("panic"), is("plan"));
    Box::new(move |_: &CancelToken| {
        if panics {
            panic!("ran out of ideas");
        }
        SolverAnswer { result: if plans { Ok(samples::plan()) } else { Err("no idea".into()) }, charged }
    })
}

fn pool() -> SolverPool {
    SolverPool::new(Box::new(SolverThread::new(std::time::Duration::from_secs(60))))
}

fn ask(pool: &mut SolverPool, request: &SolveRequest, at_s: f64, waits: bool) {
    pool.request(request, Time::from_seconds(at_s), job(request), waits);
}

fn request(number: u64, goal: &str, budget_s: f64) -> SolveRequest {
    SolveRequest {
        request: SolveRequestId(number),
        task: TaskId(1),
        goal: Value::symbol(goal),
        solver: Symbol::new("auto"),
        budget: Some(Duration::from_seconds(budget_s)),
        is_failure_handled: false,
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
    let mut pool = pool();
    ask(&mut pool, &request(1, "plan", 5.0), 10.0, true);
    ask(&mut pool, &request(2, "nothing", 2.0), 10.0, true);
    assert_eq!(pool.next_due(), Some(Time::from_seconds(12.0)));
    assert_eq!(due(&mut pool, 11.9), []);
    assert_eq!(due(&mut pool, 20.0), [(2, "no idea".to_owned()), (1, "3 targets, value 12".to_owned())]);
}

#[test]
fn a_panic_is_an_answer() {
    let mut pool = pool();
    ask(&mut pool, &request(1, "panic", 0.0), 0.0, true);
    ask(&mut pool, &request(2, "plan", 0.0), 0.0, true);
    let said = due(&mut pool, 0.0);
    assert_eq!(said[0], (1, "the solver auto failed: ran out of ideas".to_owned()));
    assert_eq!(said[1].1, "3 targets, value 12", "the next request is served");
}

#[test]
fn dropped_answers_are_named() {
    let mut pool = pool();
    ask(&mut pool, &request(1, "plan", 5.0), 0.0, true);
    ask(&mut pool, &request(2, "plan", 9.0), 0.0, true);
    let note = pool.cancel(SolveRequestId(1), Time::from_seconds(3.0)).unwrap();
    assert_eq!(note, "the answer of auto to request 1, due at 5s, was dropped: the request was cancelled at 3s");
    assert_eq!(pool.cancel(SolveRequestId(1), Time::from_seconds(3.0)), None);
    assert!(pool.close(Time::from_seconds(4.0))[0].contains("request 2, due at 9s, came too late"));
    assert_eq!(pool.next_due(), None);
}

#[test]
fn too_many_requests_fail_at_once() {
    let mut pool = pool();
    for number in 0..=SOLVE_REQUESTS_MAX as u64 {
        ask(&mut pool, &request(number, "plan", 5.0), 0.0, true);
    }
    assert!(due(&mut pool, 0.0)[0].1.contains("are open already"));
}

/// State of a queue that keeps requests until the test releases their answers.
#[derive(Default)]
struct Held {
    open: Vec<SolveRequestId>,
    cancelled: Vec<u64>,
    ready: bool,
}

#[derive(Clone, Default)]
struct FakeQueue(Rc<RefCell<Held>>);

impl SolverQueue for FakeQueue {
    fn submit(&mut self, request: SolveRequestId, _: &Symbol, _: Box<dyn SolverJob>) -> Result<(), String> {
        self.0.borrow_mut().open.push(request);
        Ok(())
    }
    fn cancel(&mut self, request: SolveRequestId) {
        self.0.borrow_mut().cancelled.push(request.0);
    }
    fn try_recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        if self.0.borrow().ready { self.recv() } else { None }
    }
    fn recv(&mut self) -> Option<(SolveRequestId, SolverAnswer)> {
        let answer = SolverAnswer { result: Ok(samples::plan()), charged: Duration::from_seconds(5.0) };
        let open = &mut self.0.borrow_mut().open;
        (!open.is_empty()).then(|| (open.remove(0), answer))
    }
}

fn held() -> (SolverPool, FakeQueue) {
    let queue = FakeQueue::default();
    (SolverPool::new(Box::new(queue.clone())), queue)
}

#[test]
fn a_queued_answer_counts_at_its_charge_or_at_its_arrival_whichever_is_later() {
    let at = Time::from_seconds;
    for (came, counts, told) in
        [(2.0, 5.0, None), (5.5, 5.5, None), (90.0, 90.0, Some("due at 5s by its work, came 85.0 s late"))]
    {
        let (mut pool, queue) = held();
        ask(&mut pool, &request(1, "plan", 0.0), 0.0, false);
        assert_eq!(pool.collect(at(1.0), false), None, "nothing has arrived");
        assert!(pool.is_expecting() && pool.next_due().is_none());
        queue.0.borrow_mut().ready = true;
        let notes = pool.collect(at(came), false).unwrap();
        assert_eq!(notes.len(), usize::from(told.is_some()), "{notes:?}");
        assert!(told.is_none_or(|told| notes[0].contains(told)), "{notes:?}");
        assert_eq!(pool.next_due(), Some(at(counts)));
        assert!(!pool.is_waiting());
        let fresh = pool.take_fresh();
        assert_eq!((fresh.len(), fresh[0].due), (1, at(counts)), "observers see it once");
        assert_eq!(pool.take_fresh(), []);
    }
}

#[test]
fn an_unpaced_run_waits_for_all_queued_answers() {
    let (mut pool, _queue) = held();
    for number in 1..=3 {
        ask(&mut pool, &request(number, "plan", 0.0), 0.0, false);
    }
    assert_eq!(pool.collect(Time::ZERO, true), Some(Vec::new()));
    assert_eq!(due(&mut pool, 5.0).len(), 3);
}

#[test]
fn answers_to_cancelled_requests_are_reported_and_not_used() {
    let (mut pool, queue) = held();
    for number in 1..=2 {
        ask(&mut pool, &request(number, "plan", 0.0), 0.0, false);
    }
    assert_eq!(pool.cancel(SolveRequestId(1), Time::from_seconds(3.0)), None);
    assert_eq!((queue.0.borrow().cancelled.as_slice(), pool.is_expecting()), ([1].as_slice(), true));
    *queue.0.borrow_mut() = Held { ready: true, open: vec![SolveRequestId(1)], cancelled: vec![1] };
    let notes = pool.collect(Time::from_seconds(4.0), false).unwrap();
    assert_eq!(
        notes,
        [
            "the answer of auto to request 1 came at 4s and is not used, because the request was cancelled at 3s: a plan, 3 targets, value 12"
        ]
    );
    assert_eq!(due(&mut pool, 1e3), []);
    let end = pool.close(Time::from_seconds(9.0));
    assert_eq!(end, ["the answer of auto to request 2, made at 0s, had not come when the run ended at 9s"]);
    assert_eq!(queue.0.borrow().cancelled, [1, 2]);
}

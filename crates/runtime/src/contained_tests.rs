//! Deliberators that hang, panic and come back, at a desk and waited for.

use super::*;
use crate::samples;
use apex_model::task::TaskId;
use apex_model::value::Value;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Answers by the goal: `plan`, `panic`, `hang` until the gate opens, anything else fails. Counts how often it was asked.
#[derive(Clone, Default)]
struct Moody {
    gate: Arc<AtomicBool>,
    asked: Arc<AtomicU64>,
}

impl Deliberator for Moody {
    fn deliberate(&mut self, request: &SolveRequest, _: Time, withdrawal: &Withdrawal) -> SolverAnswer {
        self.asked.fetch_add(1, Ordering::SeqCst);
        let goal = request.goal.to_string();
        assert!(goal != "panic", "ran out of ideas");
        while goal == "hang" && !self.gate.load(Ordering::SeqCst) {
            thread::sleep(std::time::Duration::from_millis(1));
        }
        while goal == "obey" && !withdrawal.is_withdrawn() {
            thread::sleep(std::time::Duration::from_millis(1));
        }
        let result = if goal == "plan" { Ok(samples::plan()) } else { Err("no idea".into()) };
        SolverAnswer { result, charged: Duration::ZERO }
    }
}

fn request(number: u64, goal: &str) -> SolveRequest {
    let goal = Value::symbol(goal);
    let solver = Symbol::new("auto");
    SolveRequest { request: SolveRequestId(number), task: TaskId(1), goal, solver, budget: None }
}

fn contained(moody: &Moody, patience_ms: u64) -> Contained {
    Contained::new(Box::new(moody.clone()), std::time::Duration::from_millis(patience_ms)).unwrap()
}

fn words((request, answer): (SolveRequestId, SolverAnswer)) -> (u64, Result<String, String>) {
    (request.0, answer.result.map(|plan| plan.summary))
}

#[test]
fn endless_work_is_given_up_and_the_solver_may_come_back() {
    let moody = Moody::default();
    let mut contained = contained(&moody, 100);
    let mut answer = |number, goal| {
        let answer = contained.deliberate(&request(number, goal), Time::ZERO, &Withdrawal::new());
        answer.result.map(|plan| plan.summary)
    };
    assert_eq!(answer(7, "hang"), Err("the solver auto gave no answer within 0.1 s and was given up".to_owned()));
    let hangs = Err("deliberation still hangs at request 7, which was given up".to_owned());
    assert_eq!(answer(8, "plan"), hangs);
    moody.gate.store(true, Ordering::SeqCst);
    let mut last = answer(9, "plan");
    while last == hangs {
        thread::yield_now();
        last = answer(9, "plan");
    }
    assert_eq!(last, Ok("3 targets, value 12".to_owned()));
}

#[test]
fn requests_at_the_desk_are_answered_in_order_and_nobody_waits() {
    let moody = Moody::default();
    let mut contained = contained(&moody, 60_000);
    for (number, goal) in [(1, "hang"), (2, "panic"), (3, "plan")] {
        contained.hand_over(&request(number, goal), Time::ZERO).unwrap();
    }
    assert!(contained.take().is_none(), "the first hangs, and this call came back");
    moody.gate.store(true, Ordering::SeqCst);
    let all: Vec<_> = std::iter::from_fn(|| contained.wait().map(words)).collect();
    let broke = "the solver auto broke down: ran out of ideas".to_owned();
    assert_eq!(all, [(1, Err("no idea".to_owned())), (2, Err(broke)), (3, Ok("3 targets, value 12".to_owned()))]);
}

#[test]
fn what_is_withdrawn_before_its_turn_is_not_begun_and_what_is_begun_hears_of_it() {
    let moody = Moody::default();
    let mut contained = contained(&moody, 60_000);
    contained.hand_over(&request(1, "obey"), Time::ZERO).unwrap();
    contained.hand_over(&request(2, "plan"), Time::ZERO).unwrap();
    contained.withdraw(SolveRequestId(2));
    contained.withdraw(SolveRequestId(1));
    let all: Vec<_> = std::iter::from_fn(|| contained.wait().map(words)).collect();
    assert_eq!(all[1], (2, Err("it was withdrawn before anybody began with it".to_owned())));
    assert!(moody.asked.load(Ordering::SeqCst) <= 1);
}

//! Jobs that hang, panic and return, queued and waited for.

use super::*;
use crate::samples;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Makes jobs that behave as their goal says: `plan`, `panic`, `hang` until the gate opens, anything else fails. Counts the jobs that
/// ran.
#[derive(Clone, Default)]
struct Scripted {
    gate: Arc<AtomicBool>,
    ran: Arc<AtomicU64>,
}

impl Scripted {
    fn job(&self, goal: &'static str) -> Box<dyn SolverJob> {
        let Scripted { gate, ran } = self.clone();
        Box::new(move |cancel: &CancelToken| {
            ran.fetch_add(1, Ordering::SeqCst);
            assert!(goal != "panic", "ran out of ideas");
            while goal == "hang" && !gate.load(Ordering::SeqCst) {
                thread::sleep(std::time::Duration::from_millis(1));
            }
            while goal == "obey" && !cancel.is_cancelled() {
                thread::sleep(std::time::Duration::from_millis(1));
            }
            let result = if goal == "plan" { Ok(samples::plan()) } else { Err("no idea".into()) };
            SolverAnswer { result, charged: Duration::ZERO }
        })
    }
}

fn submit(queue: &mut SolverThread, number: u64, job: Box<dyn SolverJob>) -> Result<(), String> {
    queue.submit(SolveRequestId(number), &Symbol::new("auto"), job)
}

fn queue(timeout_ms: u64) -> SolverThread {
    SolverThread::new(std::time::Duration::from_millis(timeout_ms))
}

fn words((request, answer): (SolveRequestId, SolverAnswer)) -> (u64, Result<String, String>) {
    (request.0, answer.result.map(|plan| plan.summary))
}

#[test]
fn a_job_that_never_ends_is_abandoned_and_its_thread_may_return() {
    let scripted = Scripted::default();
    let mut queue = queue(100);
    let mut answer = |number, goal| {
        submit(&mut queue, number, scripted.job(goal))?;
        words(queue.recv().unwrap()).1
    };
    assert_eq!(answer(7, "hang"), Err("the solver auto gave no answer within 0.1 s and was abandoned".to_owned()));
    let hangs = Err("deliberation still hangs at request 7, which was abandoned".to_owned());
    assert_eq!(answer(8, "plan"), hangs);
    scripted.gate.store(true, Ordering::SeqCst);
    let mut last = answer(9, "plan");
    while last == hangs {
        thread::yield_now();
        last = answer(9, "plan");
    }
    assert_eq!(last, Ok("3 targets, value 12".to_owned()));
}

#[test]
fn queued_jobs_are_answered_in_order_without_a_wait() {
    let scripted = Scripted::default();
    let mut queue = queue(60_000);
    for (number, goal) in [(1, "hang"), (2, "panic"), (3, "plan")] {
        submit(&mut queue, number, scripted.job(goal)).unwrap();
    }
    assert!(queue.try_recv().is_none(), "the first hangs, and this call returned");
    scripted.gate.store(true, Ordering::SeqCst);
    let all: Vec<_> = std::iter::from_fn(|| queue.recv().map(words)).collect();
    let broke = "the solver auto failed: ran out of ideas".to_owned();
    assert_eq!(all, [(1, Err("no idea".to_owned())), (2, Err(broke)), (3, Ok("3 targets, value 12".to_owned()))]);
}

#[test]
fn a_job_cancelled_before_its_turn_is_not_started_and_a_running_one_sees_it() {
    let scripted = Scripted::default();
    let mut queue = queue(60_000);
    submit(&mut queue, 1, scripted.job("obey")).unwrap();
    submit(&mut queue, 2, scripted.job("plan")).unwrap();
    queue.cancel(SolveRequestId(2));
    queue.cancel(SolveRequestId(1));
    let all: Vec<_> = std::iter::from_fn(|| queue.recv().map(words)).collect();
    assert_eq!(all[1], (2, Err("it was withdrawn before a solver thread began it".to_owned())));
    assert!(scripted.ran.load(Ordering::SeqCst) <= 1);
}

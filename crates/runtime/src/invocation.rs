//! Invocation (deliberation): one solver on a separate thread, supervised and isolated.
//!
//! While the solver runs, its best plan so far can be polled, and it can be paused and cancelled. Whatever it does, the caller has an
//! answer in bounded time: the answer names a panic, work beyond the budget, endless work or memory beyond the limit, and contains the
//! best plan reported before. This module trusts no plan: the checker checks it next.
//!
//! Decisions by counted work are the same in every run. The timeout and the memory limit depend on the machine, are generous, and are
//! recorded with the answer. A thread that calls neither `charge` nor `report` cannot be stopped: it is abandoned.

use crate::limits::{SOLVER_GRACE, SOLVER_LOOK, SOLVER_OVERRUN_UNITS, SOLVER_STACK_BYTES, SOLVERS_LEFT_BEHIND_MAX};
use crate::ports::CancelToken;
use crate::solver_words::{panic_text, short};
use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Budget, Environment, MachineLimits, Solver};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Limits of a solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SolverLimits {
    /// Work units.
    pub units: u64,
    /// Wall time until the solver is abandoned, without pauses.
    pub timeout: Duration,
    /// Number of bytes by which the program may grow meanwhile.
    pub memory_bytes: u64,
}

/// Result of an invocation.
#[derive(Debug)]
pub struct Answer {
    /// The plan, unchecked, or the reason why there is none.
    pub plan: Result<Plan, String>,
    /// Work units used.
    pub used: u64,
    /// Processor seconds of the solver's thread; `None` if the system does not measure them, or the thread was abandoned.
    pub cpu_s: Option<f64>,
    /// Contract violation by the solver.
    pub violation: Option<String>,
}

/// Reason for which a solver has to stop.
#[derive(Clone, Debug, PartialEq, Eq)]
enum StopReason {
    Cancelled,
    Overran(u64),
    TimedOut(Duration),
    Memory(u64),
}

impl StopReason {
    /// Returns the violation as text; `None` if the solver was only cancelled.
    fn words(&self) -> Option<String> {
        match self {
            StopReason::Cancelled => None,
            StopReason::Overran(units) => Some(format!("continued after its {units} units of work")),
            StopReason::TimedOut(timeout) => {
                Some(format!("gave no answer within {} s and was abandoned", timeout.as_secs_f64()))
            }
            StopReason::Memory(bytes) => Some(format!("took more than {} MiB of memory", bytes >> 20)),
        }
    }
}

#[derive(Debug, Default)]
struct State {
    paused: bool,
    paused_for: Duration,
    stop: Option<StopReason>,
    best: Option<Plan>,
}

/// State shared by the solver's thread and its watcher.
#[derive(Debug, Default)]
struct SolverState {
    state: Mutex<State>,
    changed: Condvar,
    /// True if a pause or a stop is requested: the solver's thread must then inspect `state`.
    attention: AtomicBool,
    stopped: AtomicBool,
    ended: AtomicBool,
    used: AtomicU64,
}

impl SolverState {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stop(&self, why: StopReason) {
        self.state().stop.get_or_insert(why);
        self.stopped.store(true, Ordering::Relaxed);
        self.attention.store(true, Ordering::Relaxed);
        self.changed.notify_all();
    }

    fn pause(&self, paused: bool) {
        self.state().paused = paused;
        self.attention.store(paused || self.stopped.load(Ordering::Relaxed), Ordering::Relaxed);
        self.changed.notify_all();
    }

    /// Waits while paused.
    fn wait(&self) {
        let begun = Instant::now();
        let mut state = self.state();
        while state.paused && state.stop.is_none() {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.paused_for += begun.elapsed();
    }
}

/// The payload that unwinds a solver that does not stop. It is not a panic, so nothing is printed.
struct UnwindPayload;

struct WatchedBudget {
    shared: Arc<SolverState>,
    machine: MachineLimits,
    allowed: u64,
    used: u64,
    overdue: u64,
}

impl WatchedBudget {
    fn look(&mut self, units: u64) {
        self.shared.wait();
        if self.shared.stopped.load(Ordering::Relaxed) {
            self.overdue = self.overdue.saturating_add(units.max(1));
        }
    }
}

impl Budget for WatchedBudget {
    fn charge(&mut self, units: u64) {
        self.used = self.used.saturating_add(units);
        self.shared.used.store(self.used, Ordering::Relaxed);
        if self.shared.attention.load(Ordering::Relaxed) {
            self.look(units);
        }
        if self.used >= self.allowed.saturating_mul(2).saturating_add(SOLVER_OVERRUN_UNITS) {
            self.shared.stop(StopReason::Overran(self.allowed));
            self.overdue = u64::MAX;
        }
        if self.overdue > SOLVER_OVERRUN_UNITS {
            resume_unwind(Box::new(UnwindPayload));
        }
    }
    fn exhausted(&self) -> bool {
        self.used >= self.allowed || self.shared.stopped.load(Ordering::Relaxed)
    }
    fn used(&self) -> u64 {
        self.used
    }
    fn left(&self) -> Option<u64> {
        Some(self.allowed.saturating_sub(self.used))
    }
    fn is_stopped(&self) -> bool {
        self.shared.stopped.load(Ordering::Relaxed)
    }
    fn machine(&self) -> MachineLimits {
        self.machine
    }
}

enum Ended {
    Answered(Result<Plan, String>),
    Stopped,
    BrokeDown(String),
    LeftBehind,
}

/// A solver at work.
pub struct Invocation {
    solver: Arc<dyn Solver>,
    limits: SolverLimits,
    shared: Arc<SolverState>,
    answers: Receiver<(Ended, Option<f64>)>,
    begun: Instant,
    grown_from: Option<u64>,
}

impl Invocation {
    /// Starts `solver` on `problem`, from the plan `previous` if there is one.
    ///
    /// # Errors
    /// A message if the system gives no thread.
    pub fn begin(
        solver: Arc<dyn Solver>,
        problem: Arc<Problem>,
        previous: Option<Plan>,
        seed: u64,
        limits: SolverLimits,
    ) -> Result<Invocation, String> {
        let shared = Arc::new(SolverState::default());
        let (sender, answers) = channel();
        let (worker, watched) = (Arc::clone(&solver), Arc::clone(&shared));
        let work = move || {
            let before_s = cpu_s();
            let ended = solve(&*worker, &problem, previous.as_ref(), seed, limits, &watched);
            let cpu_s = before_s.zip(cpu_s()).map(|(before_s, after_s)| after_s - before_s);
            watched.ended.store(true, Ordering::Release);
            // No receiver exists if the invocation was abandoned.
            let _ = sender.send((ended, cpu_s));
        };
        let builder = thread::Builder::new().name(format!("solver {}", solver.name())).stack_size(SOLVER_STACK_BYTES);
        let grown_from = resident_bytes();
        builder
            .spawn(work)
            .map_err(|error| format!("no thread could be started for the solver {}: {error}", solver.name()))?;
        Ok(Invocation { solver, limits, shared, answers, begun: Instant::now(), grown_from })
    }

    /// Returns the best plan reported so far, unchecked.
    pub fn best(&self) -> Option<Plan> {
        self.shared.state().best.clone()
    }

    /// Returns the work units used so far.
    pub fn used(&self) -> u64 {
        self.shared.used.load(Ordering::Relaxed)
    }

    /// Pauses the solver at its next unit of work.
    pub fn pause(&self) {
        self.shared.pause(true);
    }

    /// Lets the solver continue.
    pub fn resume(&self) {
        self.shared.pause(false);
    }

    /// Requests the solver to stop with its best plan; [`finish`](Invocation::finish) then returns the answer.
    pub fn cancel(&self) {
        self.shared.stop(StopReason::Cancelled);
    }

    /// Waits for the answer until the timeout, or until the solver must stop because its answer is no longer required.
    pub fn finish(self, cancel: &CancelToken) -> Answer {
        let mut stopped_at: Option<Instant> = None;
        let (ended, cpu_s) = loop {
            match self.answers.recv_timeout(SOLVER_LOOK) {
                Ok(ended) => break ended,
                Err(RecvTimeoutError::Disconnected) => break (Ended::BrokeDown("its thread ended".into()), None),
                Err(RecvTimeoutError::Timeout) => {}
            }
            self.watch(cancel);
            if self.shared.stopped.load(Ordering::Relaxed) {
                let since = *stopped_at.get_or_insert_with(Instant::now);
                if since.elapsed() > SOLVER_GRACE {
                    break (Ended::LeftBehind, None);
                }
            }
        };
        self.answer(ended, cpu_s)
    }

    /// Stops a solver that exceeds its time or memory, or that was cancelled.
    fn watch(&self, cancel: &CancelToken) {
        if cancel.is_cancelled() {
            self.cancel();
        }
        let paused_for = self.shared.state().paused_for;
        if self.begun.elapsed().saturating_sub(paused_for) > self.limits.timeout {
            self.shared.stop(StopReason::TimedOut(self.limits.timeout));
        }
        let grown = self.grown_from.zip(resident_bytes()).map(|(from, now)| now.saturating_sub(from));
        if grown.is_some_and(|bytes| bytes > self.limits.memory_bytes) {
            self.shared.stop(StopReason::Memory(self.limits.memory_bytes));
        }
    }

    fn answer(&self, ended: Ended, cpu_s: Option<f64>) -> Answer {
        let name = self.solver.name();
        let stop = self.shared.state().stop.as_ref().and_then(StopReason::words);
        let (plan, violation) = match ended {
            Ended::Answered(plan) => (plan.map_err(|reason| short(&reason)), stop),
            Ended::Stopped => (Err("it was stopped".into()), stop),
            Ended::BrokeDown(why) => (Err("it failed".into()), Some(format!("failed: {}", short(&why)))),
            Ended::LeftBehind => (Err("it did not stop".into()), stop.or(Some("did not stop when asked to".into()))),
        };
        let violation = violation.map(|what| format!("the solver {name} {what}"));
        let plan = plan.or_else(|why| match self.best() {
            Some(best) => Ok(best),
            None => Err(violation.clone().unwrap_or(why)),
        });
        Answer { plan, used: self.used(), cpu_s, violation }
    }
}

/// Runs the solver on this thread and catches its panics.
fn solve(
    solver: &dyn Solver,
    problem: &Problem,
    previous: Option<&Plan>,
    seed: u64,
    limits: SolverLimits,
    shared: &Arc<SolverState>,
) -> Ended {
    let machine = MachineLimits { memory_bytes: Some(limits.memory_bytes), timeout: Some(limits.timeout) };
    let mut budget = WatchedBudget { shared: Arc::clone(shared), machine, allowed: limits.units, used: 0, overdue: 0 };
    let mut report = |plan: &Plan| shared.state().best = Some(plan.clone());
    let mut environment = Environment { seed, budget: &mut budget, report: &mut report, previous };
    // State that an unwound solver leaves half-changed is dropped with it.
    let outcome = catch_unwind(AssertUnwindSafe(|| solver.solve(problem, &mut environment)));
    match outcome {
        Ok(plan) => Ended::Answered(plan),
        Err(payload) if payload.is::<UnwindPayload>() => Ended::Stopped,
        Err(payload) => Ended::BrokeDown(panic_text(&*payload)),
    }
}

/// Returns the resident memory of the program in bytes; `None` if the system does not report it.
fn resident_bytes() -> Option<u64> {
    let told = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = told.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes << 10)
}

/// Returns the processor time of this thread in seconds; `None` if the system does not report it.
fn cpu_s() -> Option<f64> {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    told.split_whitespace().next()?.parse::<f64>().ok().map(|nanoseconds| 1e-9 * nanoseconds)
}

/// Runs solvers in sequence, and remembers those that never returned.
#[derive(Debug, Default)]
pub struct Invocations {
    left_behind: BTreeMap<String, Arc<SolverState>>,
    worked: Duration,
}

impl Invocations {
    /// Returns a register without abandoned solvers.
    pub fn new() -> Invocations {
        Invocations::default()
    }

    /// Returns the wall time that all solvers together took.
    pub fn worked(&self) -> Duration {
        self.worked
    }

    /// Lets `solver` plan for `problem`, from the plan `previous` if there is one, until it answers or is cancelled.
    pub fn solve(
        &mut self,
        solver: &Arc<dyn Solver>,
        problem: &Arc<Problem>,
        previous: Option<Plan>,
        seed: u64,
        limits: SolverLimits,
        cancel: &CancelToken,
    ) -> Answer {
        let refused = |why: String| Answer { plan: Err(why), used: 0, cpu_s: None, violation: None };
        let name = solver.name();
        self.left_behind.retain(|_, shared| !shared.ended.load(Ordering::Acquire));
        if self.left_behind.contains_key(name) {
            return refused(format!("the solver {name} still hangs at an earlier problem"));
        }
        if self.left_behind.len() >= SOLVERS_LEFT_BEHIND_MAX {
            let names: Vec<&str> = self.left_behind.keys().map(String::as_str).collect();
            return refused(format!(
                "{} solvers hang and were left behind ({}); no further solver starts before one of them returns",
                names.len(),
                names.join(", ")
            ));
        }
        match Invocation::begin(Arc::clone(solver), Arc::clone(problem), previous, seed, limits) {
            Err(why) => refused(why),
            Ok(invocation) => {
                let shared = Arc::clone(&invocation.shared);
                let begun = Instant::now();
                let answer = invocation.finish(cancel);
                self.worked += begun.elapsed();
                if !shared.ended.load(Ordering::Acquire) {
                    self.left_behind.insert(name.to_string(), shared);
                }
                answer
            }
        }
    }
}

#[cfg(test)]
#[path = "invocation_tests.rs"]
mod tests;

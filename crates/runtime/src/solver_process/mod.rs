//! Solver programs (deliberation): a planner of a third party in a separate process, which isolates the flight from its faults.
//!
//! The program reads one request from its standard input and reports on its standard output (`protocol.rs`). To the rest of Apex it is a
//! [`Solver`] like any other: its work is charged, its best plan counts if it must be stopped, its plan is checked. The program ends with
//! a stated cause after a crash, an end without an answer, an exceeded limit of memory, time or output, or a line that violates the
//! protocol. No fault reaches the process of the flight.

mod child;
mod protocol;
mod serve;

pub use child::ProcessLimits;
pub use serve::serve;

use crate::limits::{SOLVER_LOOK, SOLVER_MEMORY_BYTES, SOLVER_STOP_TIMEOUT, SOLVER_TIMEOUT};
use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Environment, Solver};
use child::{Heard, Running};
use protocol::{ProgramLine, ProgramRequest, VERSION};
use std::ffi::OsString;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::time::Instant;

/// A planner that is a program.
pub struct SolverProgram {
    name: String,
    /// The program and its arguments.
    command: Vec<OsString>,
    /// Decides which problems the program serves; `None`: all.
    serves: Option<Arc<dyn Solver>>,
}

impl SolverProgram {
    /// Returns the planner `name` that runs `command`, the program with its arguments. It serves problems of all kinds.
    pub fn new(name: &str, command: Vec<OsString>) -> SolverProgram {
        SolverProgram { name: name.to_string(), command, serves: None }
    }

    /// Returns a program that runs `solver` in a separate process; `command` must run [`serve`] with it.
    pub fn of_solver(solver: Arc<dyn Solver>, command: Vec<OsString>) -> SolverProgram {
        SolverProgram { name: solver.name().to_string(), command, serves: Some(solver) }
    }

    fn request(&self, problem: &Problem, environment: &Environment<'_>) -> Result<String, String> {
        let request = ProgramRequest {
            apex_solver: VERSION,
            solver: self.name.clone(),
            seed: environment.seed,
            work_units: environment.budget.left().unwrap_or(u64::MAX),
            problem: problem.clone(),
            previous: environment.previous.cloned(),
        };
        serde_json::to_string(&request).map_err(|error| format!("the problem cannot be written as JSON: {error}"))
    }
}

/// Ends the invocation with a cause: the best plan that was reported counts.
fn break_down(cause: String) -> ! {
    // This is not a panic: nothing is printed, and the supervisor of the invocation receives the cause.
    resume_unwind(Box::new(cause))
}

impl Solver for SolverProgram {
    fn name(&self) -> &str {
        &self.name
    }

    fn serves(&self, problem: &Problem) -> bool {
        self.serves.as_ref().is_none_or(|solver| solver.serves(problem))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let request = self.request(problem, environment)?;
        let machine = environment.budget.machine();
        let limits = ProcessLimits {
            memory_bytes: machine.memory_bytes.unwrap_or(SOLVER_MEMORY_BYTES),
            processor: machine.timeout.unwrap_or(SOLVER_TIMEOUT),
        };
        let mut running = Running::start(&self.command, limits).unwrap_or_else(|why| break_down(why));
        running.say(request);
        let mut asked_to_stop = false;
        let mut stopped_at: Option<Instant> = None;
        loop {
            match running.hear(SOLVER_LOOK) {
                Heard::Line(line) => match ProgramLine::read(&line, &self.name, problem) {
                    Ok(ProgramLine::Charge(units)) => environment.budget.charge(units),
                    Ok(ProgramLine::Report(plan)) => (environment.report)(&plan),
                    Ok(ProgramLine::Plan(plan)) => return Ok(plan),
                    Ok(ProgramLine::Failed(reason)) => return Err(reason),
                    Err(why) => break_down(why),
                },
                Heard::TooMuch(what) => break_down(what),
                Heard::End => break_down(running.end()),
                Heard::Nothing => {}
            }
            if let Some(what) = running.violation() {
                break_down(what);
            }
            if environment.budget.exhausted() && !std::mem::replace(&mut asked_to_stop, true) {
                running.ask_to_stop();
            }
            if environment.budget.is_stopped()
                && stopped_at.get_or_insert_with(Instant::now).elapsed() > SOLVER_STOP_TIMEOUT
            {
                // The program is killed when `running` is dropped.
                return Err("it was stopped".to_string());
            }
        }
    }
}

#[cfg(test)]
mod tests;

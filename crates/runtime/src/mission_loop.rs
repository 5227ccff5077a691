//! The mission loop: simulated time jumps from instant to instant. At each instant the vehicle reports, the executive steps, the
//! observers receive the step, and the effects are sent.
//!
//! The next instant is the earliest of: the vehicle's next report, the agent's next wake, the next solver answer, the next scheduled
//! input. Time advances in no other way, so a run depends on its inputs only.

use crate::error::RunError;
use crate::flight::{Flight, StepFunction};
use crate::ports::{Deliberator, Observer, SolverQueue, Vehicle};
use crate::solver_thread::SolverThread;
use apex_executive::{Agent, step};

pub use crate::run_settings::{Control, EndReason, RunEnd, RunSettings, ScriptedAnswer};

/// Flies: runs `agent` with `vehicle` from mission time 0 until the application ends or `options.until`.
///
/// Observers are called in order; the recorder comes first, so that no observer sees what is not stored.
///
/// # Errors
/// [`RunError`] if the vehicle's link or an observer fails, or too many steps occur at one instant.
pub fn fly(
    agent: &mut Agent,
    vehicle: &mut dyn Vehicle,
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    options: RunSettings,
) -> Result<RunEnd, RunError> {
    fly_all(std::slice::from_mut(agent), vehicle, deliberator, observers, options)
}

/// Like [`fly`], for all agents of an application with one clock, in the order of their declarations: see [`crate::agent_group`]. The run
/// is over after `(end-application)`, or when all agents have finished.
///
/// # Errors
/// Like [`fly`], and if an input addresses an agent that does not exist.
pub fn fly_all(
    agents: &mut [Agent],
    vehicle: &mut dyn Vehicle,
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    options: RunSettings,
) -> Result<RunEnd, RunError> {
    let queue = Box::new(SolverThread::new(options.solver_timeout));
    fly_by((step, queue), agents, vehicle, deliberator, observers, options)
}

fn fly_by(
    (step, queue): (StepFunction, Box<dyn SolverQueue>),
    agents: &mut [Agent],
    vehicle: &mut dyn Vehicle,
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    options: RunSettings,
) -> Result<RunEnd, RunError> {
    let mut flight = Flight::new(step, agents, vehicle, deliberator, observers, queue, options)?;
    let reason = flight.run()?;
    flight.close(reason)
}

#[cfg(test)]
#[path = "mission_loop_tests.rs"]
mod tests;

//! A program without a vehicle: `apex run`. Inputs come from a list; every command is acknowledged at once.

use crate::error::RunError;
use crate::mission_loop::{FlyOptions, RunEnd, fly, fly_all};
use crate::ports::{Deliberator, Input, Observer, SolverAnswer, Vehicle};
use apex_executive::Agent;
use apex_model::effect::{CommandId, SolveRequest};
use apex_model::event::EventKind;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Runs `agent` without a vehicle until its application ends, `options.until`, or nothing can happen any more.
///
/// Commands are acknowledged at the instant at which they are sent, with `nil`. Requests to solvers fail, with a
/// reason; give a deliberator to [`run_with`] where planners are at hand.
///
/// # Errors
/// As [`fly`].
pub fn run(agent: &mut Agent, observers: &mut [&mut dyn Observer], options: FlyOptions) -> Result<RunEnd, RunError> {
    run_with(agent, &mut NoDeliberator, observers, options)
}

/// As [`run`], with planners.
///
/// # Errors
/// As [`fly`].
pub fn run_with(
    agent: &mut Agent,
    deliberator: &mut (dyn Deliberator + Send),
    observers: &mut [&mut dyn Observer],
    options: FlyOptions,
) -> Result<RunEnd, RunError> {
    fly(agent, &mut NoVehicle::default(), deliberator, observers, options)
}

/// As [`run`], with all agents of an application.
///
/// # Errors
/// As [`fly_all`].
pub fn run_all(
    agents: &mut [Agent],
    observers: &mut [&mut dyn Observer],
    options: FlyOptions,
) -> Result<RunEnd, RunError> {
    fly_all(agents, &mut NoVehicle::default(), &mut NoDeliberator, observers, options)
}

/// Stands in for a vehicle: does nothing, and acknowledges everything at once.
#[derive(Debug, Default)]
pub struct NoVehicle {
    acknowledgements: Vec<Input>,
}

impl Vehicle for NoVehicle {
    fn next_report(&self) -> Option<Time> {
        self.acknowledgements.first().map(|input| input.at)
    }

    fn advance(&mut self, _: Time, inputs: &mut Vec<Input>) -> Result<(), String> {
        inputs.append(&mut self.acknowledgements);
        Ok(())
    }

    fn command(&mut self, command: CommandId, _: &Value, at: Time) {
        let kind = EventKind::CommandAcknowledged(command, Ok(Value::nil()));
        self.acknowledgements.push(Input::new(at, kind));
    }

    fn withdraw(&mut self, command: CommandId, _: Time) {
        self.acknowledgements
            .retain(|input| !matches!(input.kind, EventKind::CommandAcknowledged(pending, _) if pending == command));
    }
}

/// Stands in for planners: every request fails with a reason.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoDeliberator;

impl Deliberator for NoDeliberator {
    fn deliberate(&mut self, request: &SolveRequest, _: Time) -> SolverAnswer {
        let reason = format!("no planner is at hand for {} without a mission", request.goal);
        SolverAnswer { result: Err(reason), charged: Duration::ZERO }
    }
}

//! A program without a vehicle: `apex run`. Inputs come from a list; every command is acknowledged at once, or as the list
//! says.

use crate::error::RunError;
use crate::mission_loop::{FlyOptions, RunEnd, fly, fly_all};
use crate::ports::{Deliberator, Input, Observer, Posed, Vehicle};
use apex_executive::Agent;
use apex_model::effect::{CommandId, SolveRequest};
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;

/// Runs `agent` without a vehicle until its application ends, `options.until`, or nothing can happen any more.
///
/// Commands are acknowledged at the instant at which they are sent, with `nil`; where an input acknowledges a command, as
/// in what was recorded of a flight, only by inputs. Requests to solvers fail, with a
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
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    options: FlyOptions,
) -> Result<RunEnd, RunError> {
    fly(agent, &mut NoVehicle::beside(&options.inputs), deliberator, observers, options)
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
    fly_all(agents, &mut NoVehicle::beside(&options.inputs), &mut NoDeliberator, observers, options)
}

/// Stands in for a vehicle: does nothing, and acknowledges everything at once.
#[derive(Debug, Default)]
pub struct NoVehicle {
    acknowledgements: Vec<Input>,
    /// Somebody else acknowledges.
    silent: bool,
}

impl NoVehicle {
    /// Acknowledges nothing if `inputs` acknowledge anything.
    pub fn beside(inputs: &[Input]) -> NoVehicle {
        let silent = inputs.iter().any(|input| matches!(input.kind, EventKind::CommandAcknowledged(..)));
        NoVehicle { silent, ..NoVehicle::default() }
    }

    /// Acknowledges nothing: a vehicle does, whose reports come in like other inputs.
    pub fn silent() -> NoVehicle {
        NoVehicle { silent: true, ..NoVehicle::default() }
    }
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
        if !self.silent {
            let kind = EventKind::CommandAcknowledged(command, Ok(Value::nil()));
            self.acknowledgements.push(Input::new(at, kind));
        }
    }

    fn withdraw(&mut self, command: CommandId, _: Time) {
        self.acknowledgements
            .retain(|input| !matches!(input.kind, EventKind::CommandAcknowledged(pending, _) if pending == command));
    }

    /// A vehicle that acknowledges by inputs reads commands in the trace.
    fn acts_outside(&self) -> bool {
        self.silent
    }
}

/// Stands in for planners: every request fails with a reason.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoDeliberator;

impl Deliberator for NoDeliberator {
    fn pose(&mut self, request: &SolveRequest, _: Time) -> Posed {
        Posed::failed(format!("no planner is at hand for {} without a mission", request.goal))
    }
}

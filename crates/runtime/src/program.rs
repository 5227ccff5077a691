//! A program without a vehicle: `apex run`. Inputs come from a list, which may acknowledge commands; other commands are acknowledged at
//! once.

use crate::error::RunError;
use crate::mission_loop::{RunEnd, RunSettings, fly, fly_all};
use crate::ports::{Deliberator, Input, Observer, Posed, Vehicle};
use apex_executive::Agent;
use apex_model::effect::{CommandId, SolveRequest};
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use std::collections::BTreeSet;

/// Runs `agent` without a vehicle until its application ends, `options.until`, or nothing can happen any longer.
///
/// Commands are acknowledged with `nil` at the instant at which they are sent, except for those that an input acknowledges, by number or
/// by form. Requests to solvers fail, with a reason; pass a deliberator to [`run_with`] if planners are available.
///
/// # Errors
/// Like [`fly`].
pub fn run(agent: &mut Agent, observers: &mut [&mut dyn Observer], options: RunSettings) -> Result<RunEnd, RunError> {
    run_with(agent, &mut NoDeliberator, observers, options)
}

/// Like [`run`], with planners.
///
/// # Errors
/// Like [`fly`].
pub fn run_with(
    agent: &mut Agent,
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    mut options: RunSettings,
) -> Result<RunEnd, RunError> {
    fly(agent, &mut NoVehicle::beside(&mut options.inputs), deliberator, observers, options)
}

/// Like [`run`], with all agents of an application.
///
/// # Errors
/// Like [`fly_all`].
pub fn run_all(
    agents: &mut [Agent],
    observers: &mut [&mut dyn Observer],
    mut options: RunSettings,
) -> Result<RunEnd, RunError> {
    let mut vehicle = NoVehicle::beside(&mut options.inputs);
    let end = fly_all(agents, &mut vehicle, &mut NoDeliberator, observers, options)?;
    Ok(RunEnd { unused: vehicle.unused(), ..end })
}

/// Replaces a vehicle: does nothing, and acknowledges commands at once unless an input does.
#[derive(Debug, Default)]
pub struct NoVehicle {
    /// Acknowledgements of sent commands that are not reported yet, in order of time.
    acknowledgements: Vec<Input>,
    /// Commands that inputs acknowledge by number.
    numbered: BTreeSet<CommandId>,
    /// Acknowledgements of commands by form, in order of time.
    named: Vec<Input>,
    /// Number of the commands that were sent.
    sent: u64,
    /// True if another source acknowledges the commands.
    silent: bool,
}

impl NoVehicle {
    /// Returns a replacement that leaves the commands that `inputs` acknowledge by number to them, and moves acknowledgements by form out
    /// of `inputs`.
    pub fn beside(inputs: &mut Vec<Input>) -> NoVehicle {
        let (named, others) = std::mem::take(inputs).into_iter().partition(|input| input.command_form.is_some());
        *inputs = others;
        let numbered = inputs.iter().filter_map(|input| match input.kind {
            EventKind::CommandAcknowledged(command, _) | EventKind::CommandProgressed(command, _) => Some(command),
            _ => None,
        });
        NoVehicle { numbered: numbered.collect(), named, ..NoVehicle::default() }
    }

    /// Returns a replacement that acknowledges nothing, for an outside vehicle whose reports arrive like other inputs.
    pub fn silent() -> NoVehicle {
        NoVehicle { silent: true, ..NoVehicle::default() }
    }
}

impl NoVehicle {
    /// Returns the acknowledgements that belong to no command that was sent.
    fn unused(&self) -> Vec<String> {
        let form = |input: &Input| Some(format!("`{}` at {}", input.command_form.as_ref()?, input.at));
        let never = self.numbered.iter().filter(|command| command.0 >= self.sent);
        let numbers = never.map(|command| format!("command {}", command.0));
        self.named.iter().filter_map(form).chain(numbers).collect()
    }

    fn report(&mut self, at: Time, kind: EventKind) {
        let place = self.acknowledgements.partition_point(|input| input.at <= at);
        self.acknowledgements.insert(place, Input::new(at, kind));
    }
}

impl Vehicle for NoVehicle {
    fn next_report(&self) -> Option<Time> {
        self.acknowledgements.first().map(|input| input.at)
    }

    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String> {
        let due = self.acknowledgements.partition_point(|input| input.at <= to);
        inputs.extend(self.acknowledgements.drain(..due));
        Ok(())
    }

    fn command(&mut self, command: CommandId, form: &Value, at: Time) {
        self.sent = self.sent.max(command.0.saturating_add(1));
        if self.silent || self.numbered.contains(&command) {
            return;
        }
        let is_named = |input: &Input| input.command_form.as_ref().is_some_and(|named| named.matches(form));
        let mut goes_on = false;
        while let Some(index) = self.named.iter().position(is_named) {
            let Input { at: then, kind, .. } = self.named.remove(index);
            match kind {
                EventKind::CommandProgressed(_, progress) => {
                    goes_on = true;
                    self.report(then.max(at), EventKind::CommandProgressed(command, progress));
                }
                EventKind::CommandAcknowledged(_, result) => {
                    return self.report(then.max(at), EventKind::CommandAcknowledged(command, result));
                }
                _ => {}
            }
        }
        // A command whose progress arrives as inputs is ended by an input.
        if !goes_on {
            self.report(at, EventKind::CommandAcknowledged(command, Ok(Value::nil())));
        }
    }

    fn withdraw(&mut self, command: CommandId, _: Time) {
        self.acknowledgements.retain(|input| {
            !matches!(input.kind, EventKind::CommandAcknowledged(pending, _) | EventKind::CommandProgressed(pending, _)
                if pending == command)
        });
    }

    /// Returns true if inputs acknowledge the commands: an outside vehicle then reads them from the trace.
    fn acts_outside(&self) -> bool {
        self.silent
    }
}

/// Replaces planners: every request fails with a reason.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoDeliberator;

impl Deliberator for NoDeliberator {
    fn pose(&mut self, request: &SolveRequest, _: Time) -> Posed {
        Posed::failed(format!("no planner is available for {} without a mission", request.goal))
    }
}

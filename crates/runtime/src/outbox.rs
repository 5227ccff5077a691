//! The outbox: sends what a step decided, in the order decided.
//!
//! Commands and withdrawals go to the vehicle, requests to the solver pool. Decisions, `inform`, `print` and `ask` are
//! for observers, who have seen the whole list of effects before anything is sent.

use crate::crew::Numbering;
use crate::pool::SolverPool;
use crate::ports::{Deliberator, Vehicle};
use apex_model::effect::{CommandId, Effect, SolveRequest, SolveRequestId};
use apex_model::event::Message;
use apex_model::symbol::Symbol;
use apex_model::time::Time;

/// What sending left to say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sent {
    /// The reason of `EndApplication`, if it was among the effects.
    pub end: Option<String>,
    /// What other agents are told, in order.
    pub told: Vec<(Symbol, Message)>,
    /// What the shell decided meanwhile (a dropped answer, say), for [`crate::ports::Observer::note`].
    pub notes: Vec<String>,
}

/// Sends `effects` of the step at `now`; `numbering` is that of the agent that stepped. With `waits`, solvers are waited for.
pub fn send(
    effects: &[Effect],
    numbering: Numbering,
    now: Time,
    vehicle: &mut dyn Vehicle,
    (pool, waits): (&mut SolverPool, bool),
    deliberator: &mut (dyn Deliberator + Send),
) -> Sent {
    let mut sent = Sent::default();
    for effect in effects {
        match effect {
            Effect::Command { command, form, .. } => vehicle.command(CommandId(numbering.outer(command.0)), form, now),
            Effect::WithdrawCommand { command, .. } => vehicle.withdraw(CommandId(numbering.outer(command.0)), now),
            Effect::Solve(request) => {
                let outer = SolveRequestId(numbering.outer(request.request.0));
                pool.request(deliberator, &SolveRequest { request: outer, ..request.clone() }, now, waits);
            }
            Effect::CancelSolve(request) => {
                let outer = SolveRequestId(numbering.outer(request.0));
                sent.notes.extend(pool.cancel(deliberator, outer, now));
            }
            Effect::EndApplication { reason } => sent.end = Some(reason.clone()),
            Effect::Tell { to, message, .. } => sent.told.extend(to.iter().map(|name| (name.clone(), message.clone()))),
            Effect::WithdrawQuestion { .. }
            | Effect::AgentEnded { .. }
            | Effect::Decided(_)
            | Effect::Inform { .. }
            | Effect::Print { .. }
            | Effect::Ask { .. } => {}
        }
    }
    sent
}

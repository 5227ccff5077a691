//! The outbox: sends the effects of a step in their order.
//!
//! Commands and withdrawals go to the vehicle, requests to the solver pool. Decisions, `inform`, `print` and `ask` are for observers,
//! which have received the whole list of effects before anything is sent.

use crate::agent_group::Numbering;
use crate::pool::SolverPool;
use crate::ports::Vehicle;
use apex_model::effect::{CommandId, Effect, SolveRequest, SolveRequestId};
use apex_model::event::Message;
use apex_model::symbol::Symbol;
use apex_model::time::Time;

/// Results of sending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sent {
    /// The reason of `EndApplication`, if it was among the effects.
    pub end: Option<String>,
    /// Messages to other agents, in order.
    pub told: Vec<(Symbol, Message)>,
    /// Requests to solvers, in order, with their numbers in the run instead of those in the agent.
    pub requests: Vec<SolveRequest>,
    /// Decisions of the runtime in between (a dropped answer, for example), for [`crate::ports::Observer::note`].
    pub notes: Vec<String>,
}

/// Sends the `effects` of the step at `now` to vehicle and pool; `numbering` belongs to the agent of the step. Requests to solvers are
/// returned, because they are posed and recorded first.
pub fn send(
    effects: &[Effect],
    numbering: Numbering,
    now: Time,
    vehicle: &mut dyn Vehicle,
    pool: &mut SolverPool,
) -> Sent {
    let mut sent = Sent { requests: requests(effects, numbering), ..Sent::default() };
    for effect in effects {
        match effect {
            Effect::Command { command, form, .. } => vehicle.command(CommandId(numbering.outer(command.0)), form, now),
            Effect::WithdrawCommand { command, .. } => vehicle.withdraw(CommandId(numbering.outer(command.0)), now),
            Effect::CancelSolve(request) => {
                sent.notes.extend(pool.cancel(SolveRequestId(numbering.outer(request.0)), now));
            }
            Effect::EndApplication { reason } => sent.end = Some(reason.clone()),
            Effect::Tell { to, message, .. } => sent.told.extend(to.iter().map(|name| (name.clone(), message.clone()))),
            Effect::Solve(_)
            | Effect::WithdrawQuestion { .. }
            | Effect::AgentEnded { .. }
            | Effect::Decided(_)
            | Effect::Inform { .. }
            | Effect::Publish { .. }
            | Effect::Print { .. }
            | Effect::Ask { .. } => {}
        }
    }
    sent
}

/// Returns true for an effect that a vehicle or an operator acts upon.
pub fn leaves(effect: &Effect) -> bool {
    match effect {
        Effect::Command { .. }
        | Effect::WithdrawCommand { .. }
        | Effect::Ask { .. }
        | Effect::WithdrawQuestion { .. } => true,
        Effect::Solve(_)
        | Effect::CancelSolve(_)
        | Effect::Inform { .. }
        | Effect::Publish { .. }
        | Effect::Print { .. }
        | Effect::Tell { .. }
        | Effect::Decided(_)
        | Effect::AgentEnded { .. }
        | Effect::EndApplication { .. } => false,
    }
}

/// Returns the solver requests among the effects of one step, in order, with their numbers in the run. A request that the same step
/// cancels is never posed.
pub fn requests(effects: &[Effect], numbering: Numbering) -> Vec<SolveRequest> {
    let is_cancelled =
        |request| effects.iter().any(|effect| matches!(effect, Effect::CancelSolve(id) if *id == request));
    let wanted = |effect: &Effect| match effect {
        Effect::Solve(request) if !is_cancelled(request.request) => {
            let outer = SolveRequestId(numbering.outer(request.request.0));
            Some(SolveRequest { request: outer, ..request.clone() })
        }
        _ => None,
    };
    effects.iter().filter_map(wanted).collect()
}

//! The outbox: sends what a step decided, in the order decided.
//!
//! Commands and withdrawals go to the vehicle, requests to the solver pool. Decisions, `inform`, `print` and `ask` are
//! for observers, who have seen the whole list of effects before anything is sent.

use crate::pool::SolverPool;
use crate::ports::{Deliberator, Vehicle};
use apex_model::effect::Effect;
use apex_model::time::Time;

/// What sending left to say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sent {
    /// The reason of `EndApplication`, if it was among the effects.
    pub end: Option<String>,
    /// What the shell decided meanwhile (a dropped answer, say), for [`crate::ports::Observer::note`].
    pub notes: Vec<String>,
}

/// Sends `effects` of the step at `now`.
pub fn send(
    effects: &[Effect],
    now: Time,
    vehicle: &mut dyn Vehicle,
    pool: &mut SolverPool,
    deliberator: &mut (dyn Deliberator + Send),
) -> Sent {
    let mut sent = Sent::default();
    for effect in effects {
        match effect {
            Effect::Command { command, form, .. } => vehicle.command(*command, form, now),
            Effect::WithdrawCommand { command, .. } => vehicle.withdraw(*command, now),
            Effect::Solve(request) => pool.request(deliberator, request, now),
            Effect::CancelSolve(request) => sent.notes.extend(pool.cancel(*request, now)),
            Effect::EndApplication { reason } => sent.end = Some(reason.clone()),
            Effect::Decided(_) | Effect::Inform { .. } | Effect::Print { .. } | Effect::Ask { .. } => {}
        }
    }
    sent
}

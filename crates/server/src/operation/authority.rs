//! Authority over a run, in the form in which the API shows it to one caller.

use apex_runtime::authority::{Actor, ActorRole, AuthorityBoard};
use serde::Serialize;

/// Authority in the form of the API.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct AuthorityState {
    /// The number of the epoch, which commands may state.
    epoch: u64,
    /// The holder; `None` while authority is free.
    holder: Option<ActorState>,
    /// True if the holder is silent: another operator may then take authority.
    silent: bool,
    offer: Option<OfferState>,
    /// The caller.
    you: ActorState,
    /// True if the caller holds authority.
    yours: bool,
    /// True if the caller may take authority now.
    may_take: bool,
    /// Other callers with a recent request that may hold it.
    stations: Vec<ActorState>,
}

/// An operator or program, in the form of the API.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ActorState {
    name: String,
    /// `observer`, `operator` or `pilot-in-command`.
    role: &'static str,
}

/// An offer of authority.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct OfferState {
    /// The name of the actor to which it is offered.
    to: String,
    /// Remaining wall time of the offer, in seconds.
    left_s: f64,
}

impl AuthorityState {
    /// Returns authority as shown to `actor`, who can offer it to `stations`.
    pub(crate) fn of(board: &AuthorityBoard, actor: &Actor, stations: &[Actor]) -> AuthorityState {
        let now = board.now();
        let authority = board.authority();
        let offer = authority.offer(now);
        let yours = authority.holder.as_ref().is_some_and(|holder| holder.name == actor.name);
        let offered = offer.is_some_and(|(to, _)| to == actor.name);
        let silent = authority.is_silent(now);
        let open = authority.holder.is_none() || offered || silent || actor.role == ActorRole::PilotInCommand;
        AuthorityState {
            epoch: authority.epoch,
            holder: authority.holder.as_ref().map(ActorState::of),
            silent,
            offer: offer.map(|(to, left)| OfferState { to: to.into(), left_s: left.as_secs_f64() }),
            you: ActorState::of(actor),
            yours,
            may_take: !yours && open && actor.role >= ActorRole::Operator,
            stations: stations.iter().map(ActorState::of).collect(),
        }
    }
}

impl ActorState {
    fn of(actor: &Actor) -> ActorState {
        ActorState { name: actor.name.clone(), role: actor.role.word() }
    }
}

//! Authority over a run: at most one actor holds it, in numbered epochs that only increase.
//!
//! Authority is free at the beginning. An actor can take it while it is free, when it is offered to the actor, or from a holder that has
//! been silent for long; the pilot in command can take it at any time. Each change of the holder begins an epoch. A command of another
//! epoch or of another author is refused. The run applies requests in the order in which it receives them and records each change as the
//! event `(authority EPOCH NAME ROLE HOW)`. It measures silence by wall time; a replay only repeats the recorded changes.

use apex_model::event::EventKind;
use apex_model::value::Value;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The head of the event that records a change.
const HEAD: &str = "authority";
/// Wall time after which an offer is over.
pub const OFFER_LASTS: Duration = Duration::from_secs(60);
/// Wall time without a word of the holder after which another operator may take its authority.
pub const SILENT_AFTER: Duration = Duration::from_secs(30);

/// Rights of a session. A greater role has all rights of a smaller one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ActorRole {
    /// May only read.
    Observer,
    /// May command a run while it holds authority, and may start flights.
    Operator,
    /// May take authority from any holder.
    PilotInCommand,
}

impl ActorRole {
    /// All roles, the smallest first.
    pub const ALL: [ActorRole; 3] = [ActorRole::Observer, ActorRole::Operator, ActorRole::PilotInCommand];

    /// Returns the role as written.
    pub fn word(self) -> &'static str {
        match self {
            ActorRole::Observer => "observer",
            ActorRole::Operator => "operator",
            ActorRole::PilotInCommand => "pilot-in-command",
        }
    }

    /// Returns the role called `word`.
    pub fn of_word(word: &str) -> Option<ActorRole> {
        ActorRole::ALL.into_iter().find(|role| role.word() == word)
    }
}

/// An operator or program that sends commands to a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actor {
    /// Name of the actor; an actor is identified by its name.
    pub name: String,
    /// Its role.
    pub role: ActorRole,
}

/// A request about authority.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AuthorityRequest {
    /// Take authority.
    Take,
    /// Offer authority to the actor of this name, who accepts or rejects it.
    Offer(String),
    /// Refuse the offered authority.
    Refuse,
    /// Release authority; an open offer ends.
    Release,
}

/// The holder of authority, and the open offer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Authority {
    /// The number of changes of the holder.
    pub epoch: u64,
    /// The holder; `None` while authority is free.
    pub holder: Option<Actor>,
    /// The name of the actor to which authority is offered, and the wall time of the offer.
    offer: Option<(String, Duration)>,
    /// Time at which the holder was heard last.
    heard: Duration,
}

/// A change of authority.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuthorityChange {
    /// Authority was free, and the actor holds it now.
    Taken,
    /// The actor to which it was offered holds it now.
    HandedOver,
    /// The pilot in command has taken it from its holder.
    Overridden,
    /// The actor took it from a silent holder.
    TakenFromSilent,
    /// Authority is offered to another actor.
    Offered,
    /// The offer was refused; the holder keeps authority.
    Refused,
    /// Authority is free.
    Released,
}

impl AuthorityChange {
    /// Returns the change as recorded.
    pub fn word(self) -> &'static str {
        match self {
            AuthorityChange::Taken => "taken",
            AuthorityChange::HandedOver => "handed-over",
            AuthorityChange::Overridden => "overridden",
            AuthorityChange::TakenFromSilent => "taken-from-silent",
            AuthorityChange::Offered => "offered",
            AuthorityChange::Refused => "refused",
            AuthorityChange::Released => "released",
        }
    }

    /// Returns the event that records this change by `actor`; `authority` is the state after the change.
    pub(crate) fn entry(self, authority: &Authority, actor: &Actor) -> EventKind {
        let epoch = Value::Integer(i64::try_from(authority.epoch).unwrap_or(i64::MAX));
        let mut parts = vec![
            Value::symbol(HEAD),
            epoch,
            Value::text(&actor.name),
            Value::symbol(actor.role.word()),
            Value::symbol(self.word()),
        ];
        if self == AuthorityChange::Offered {
            parts.extend(authority.offer.iter().map(|(to, _)| Value::text(to)));
        }
        EventKind::Occurrence(Value::list(parts))
    }
}

impl Authority {
    fn is_held_by(&self, actor: &Actor) -> bool {
        self.holder.as_ref().is_some_and(|holder| holder.name == actor.name)
    }

    /// Returns the name of the actor that authority is offered to at `now`, and the time until the offer is over.
    pub fn offer(&self, now: Duration) -> Option<(&str, Duration)> {
        let (to, at) = self.offer.as_ref()?;
        let left = (*at + OFFER_LASTS).checked_sub(now).filter(|left| !left.is_zero())?;
        Some((to, left))
    }

    /// Returns true if the last sign of the holder is at least [`SILENT_AFTER`] old, so that others may take its authority.
    pub fn is_silent(&self, now: Duration) -> bool {
        self.holder.is_some() && now.saturating_sub(self.heard) >= SILENT_AFTER
    }

    /// Records a sign of the holder at `now`, if `name` is the holder.
    pub fn hear(&mut self, name: &str, now: Duration) {
        if self.holder.as_ref().is_some_and(|holder| holder.name == name) {
            self.heard = now;
        }
    }

    /// Applies a request of `actor` at `now`.
    ///
    /// # Errors
    /// The reason of the refusal; nothing has changed then.
    pub fn apply(
        &mut self,
        request: &AuthorityRequest,
        actor: &Actor,
        now: Duration,
    ) -> Result<AuthorityChange, String> {
        if actor.role < ActorRole::Operator {
            return Err(format!("{actor} is an observer, and holds no authority"));
        }
        match request {
            AuthorityRequest::Take => self.take(actor, now),
            AuthorityRequest::Offer(to) => {
                self.must_hold(actor)?;
                if *to == actor.name {
                    return Err(format!("{to} holds authority already"));
                }
                self.offer = Some((to.clone(), now));
                Ok(AuthorityChange::Offered)
            }
            AuthorityRequest::Refuse => match self.offer(now) {
                Some((to, _)) if to == actor.name => {
                    self.offer = None;
                    Ok(AuthorityChange::Refused)
                }
                _ => Err(format!("authority is not offered to {actor}")),
            },
            AuthorityRequest::Release => {
                self.must_hold(actor)?;
                self.epoch += 1;
                (self.holder, self.offer) = (None, None);
                Ok(AuthorityChange::Released)
            }
        }
    }

    fn take(&mut self, actor: &Actor, now: Duration) -> Result<AuthorityChange, String> {
        let change = match &self.holder {
            None => AuthorityChange::Taken,
            Some(holder) if holder.name == actor.name => return Err(format!("{actor} holds authority already")),
            Some(_) if self.offer(now).is_some_and(|(to, _)| to == actor.name) => AuthorityChange::HandedOver,
            Some(_) if actor.role == ActorRole::PilotInCommand => AuthorityChange::Overridden,
            Some(_) if self.is_silent(now) => AuthorityChange::TakenFromSilent,
            Some(holder) => {
                return Err(format!(
                    "{holder} holds authority; it is taken when {holder} offers it to {actor}, releases it, or is silent for \
                     {} s",
                    SILENT_AFTER.as_secs()
                ));
            }
        };
        self.epoch += 1;
        (self.holder, self.offer, self.heard) = (Some(actor.clone()), None, now);
        Ok(change)
    }

    fn must_hold(&self, actor: &Actor) -> Result<(), String> {
        if self.is_held_by(actor) {
            return Ok(());
        }
        Err(match &self.holder {
            Some(holder) => format!("{holder} holds authority, not {actor}"),
            None => format!("{actor} does not hold authority, which is free; take authority first"),
        })
    }

    /// Checks the epoch that a command states.
    pub(crate) fn check_epoch(&self, epoch: Option<u64>) -> Result<(), String> {
        let Some(stale) = epoch.filter(|epoch| *epoch != self.epoch) else { return Ok(()) };
        let holder = self.holder.as_ref().map_or_else(|| "it is free".into(), |holder| format!("{holder} holds it"));
        let is = if stale > self.epoch { "has not begun" } else { "is stale" };
        Err(format!("epoch {stale} of authority {is}: this is epoch {}, {holder}", self.epoch))
    }

    /// Checks that a command of `actor` may be executed; `epoch` is the epoch that it states, if any. While authority is free, operators
    /// and the pilot in command may command; the run then lets the command's author take authority.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn check(&self, actor: &Actor, epoch: Option<u64>) -> Result<(), String> {
        self.check_epoch(epoch)?;
        match &self.holder {
            Some(holder) if holder.name != actor.name => {
                Err(format!("{holder} holds authority; take it before you command"))
            }
            Some(_) => Ok(()),
            None if actor.role >= ActorRole::Operator => Ok(()),
            None => Err(format!("{actor} is an observer, and commands nothing")),
        }
    }
}

impl fmt::Display for Actor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// The authority over one run, shared by the run, which changes it, and by the components that display it.
#[derive(Clone, Debug)]
pub struct AuthorityBoard {
    authority: Arc<Mutex<Authority>>,
    began: Instant,
}

impl Default for AuthorityBoard {
    fn default() -> AuthorityBoard {
        AuthorityBoard { authority: Arc::default(), began: Instant::now() }
    }
}

impl AuthorityBoard {
    /// Returns the wall time that authority counts with.
    pub fn now(&self) -> Duration {
        self.began.elapsed()
    }

    /// Returns the present authority, locked until the guard is dropped.
    pub fn authority(&self) -> MutexGuard<'_, Authority> {
        // Every change is complete when the lock is released, even by a panic, so a poisoned lock is usable.
        self.authority.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records that the actor called `name` was heard: the holder is not silent.
    pub fn hear(&self, name: &str) {
        let now = self.now();
        self.authority().hear(name, now);
    }
}

#[cfg(test)]
#[path = "authority_tests.rs"]
mod tests;

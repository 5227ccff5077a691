//! Operating a flight under way: run control, answers, messages, updates of targets.
//!
//! `authority` shows who holds the authority over the run; `door` carries commands to the run and knows how each ended; `watch`
//! is an observer of the run that keeps what an operator needs to decide: open questions, planning under way, targets; `request`
//! reads and checks commands; `routes` is the table of addresses. A command ends in exactly one of accepted, rejected and expired,
//! and the run records it as an input.

mod authority;
mod door;
mod request;
pub(crate) mod routes;
mod watch;

#[cfg(test)]
pub(crate) use authority::{ActorState, AuthorityState, OfferState};
#[cfg(test)]
pub(crate) use door::{CommandState, Operation, TargetNews};
pub use door::{FlightDoor, ReadDatum};
#[cfg(test)]
pub(crate) use request::Wish;
pub use watch::FlightWatch;
#[cfg(test)]
pub(crate) use watch::{OpenQuestion, Planning};

//! Operates a flight in progress: run control, answers, messages, updates of targets.
//!
//! `alarms` finds the alarms that a command states; `authority` shows the holder of authority over the run; `door` passes commands to the
//! run and stores their ends; `watch` is an observer of the run that keeps what an operator needs for decisions: open questions, planning
//! in progress, targets; `request` reads and checks commands; `routes` is the table of addresses. A command ends as exactly one of
//! accepted, rejected and expired, and the run records it as an input.

mod alarms;
mod authority;
mod door;
mod members;
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

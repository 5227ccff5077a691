//! Task control services: deciding and enacting behaviour (paper, section IV). One file per service.
//!
//! `phases/` holds the phases of a step, `tasks/` the life of a task, `conflicts/` who gets a resource. The files next to
//! them serve all three.

pub(crate) mod conflicts;
pub(crate) mod cycle;
pub(crate) mod matching;
pub(crate) mod phases;
pub(crate) mod tasks;
pub(crate) mod transition;

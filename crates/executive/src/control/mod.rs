//! Task control services: deciding and enacting behaviour (paper, section IV). One file per service.
//!
//! `tasks/` holds the life cycle of a task, `conflicts/` the arbitration of resources. The files next to them serve both, and the phases.

pub(crate) mod conflicts;
pub(crate) mod cycle;
pub(crate) mod matching;
pub(crate) mod memory_budget;
pub(crate) mod tasks;
pub(crate) mod transition;

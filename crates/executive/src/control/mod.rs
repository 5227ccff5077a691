//! Task control services: deciding and enacting behaviour (paper, section IV). One file per service.

pub(crate) mod binding;
pub(crate) mod built_in;
pub(crate) mod competition;
pub(crate) mod conflict;
pub(crate) mod contention;
pub(crate) mod correspondence;
pub(crate) mod enablement;
pub(crate) mod failure;
pub(crate) mod hooks;
pub(crate) mod instantiation;
pub(crate) mod interruption;
pub(crate) mod invariants;
pub(crate) mod invocation;
pub(crate) mod monitoring_clauses;
pub(crate) mod primitive;
pub(crate) mod priority;
pub(crate) mod procedure;
pub(crate) mod question;
pub(crate) mod recording;
pub(crate) mod repetition;
pub(crate) mod resources;
pub(crate) mod restart;
pub(crate) mod selection;
pub(crate) mod sharing;
pub(crate) mod termination;
pub(crate) mod transition;

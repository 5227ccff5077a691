//! The phases of a step, in the order that `step.rs` gives them.

pub(crate) mod built_in;
pub(crate) mod contention;
pub(crate) mod enablement;
pub(crate) mod invariants;
pub(crate) mod invocation;
pub(crate) mod recording;
pub(crate) mod selection;

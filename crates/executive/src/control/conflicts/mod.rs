//! Conflicts over resources: the competitors, their strengths and the arbitration.

pub(crate) mod arbitration;
pub(crate) mod claim_queue;
pub(crate) mod competition;
pub(crate) mod conflict;
pub(crate) mod crossing;
pub(crate) mod curve;
pub(crate) mod deadlock;
pub(crate) mod equal_ranks;
pub(crate) mod families;
mod family_turns;
mod family_watch;
pub(crate) mod front;
mod gap_lines;
mod gap_watch;
pub(crate) mod gaps;
pub(crate) mod precedence;
pub(crate) mod priority;
pub(crate) mod queues;
pub(crate) mod resolution;
pub(crate) mod resources;
pub(crate) mod sharing;
pub(crate) mod value_intervals;

//! Conditions on runs of samples whose values satisfy constraints.

pub(crate) mod episode;
pub(crate) mod plain_combination;
pub(crate) mod plain_episode;
pub(crate) mod plain_look_back;
pub(crate) mod quick_runs;
pub(crate) mod runs;

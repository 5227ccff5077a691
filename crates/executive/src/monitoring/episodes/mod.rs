//! Conditions on runs of samples whose values satisfy constraints.

pub(crate) mod episode;
pub(crate) mod pair_points;
pub(crate) mod run_fast_path;
pub(crate) mod run_update;
pub(crate) mod threshold_backfill;
pub(crate) mod threshold_episode;
pub(crate) mod threshold_formula;

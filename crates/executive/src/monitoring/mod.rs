//! Monitoring and interpretation services: the meaning of conditions (paper, section IV and Appendix B). One file per service.
//!
//! A monitor is plain data (`crate::state::monitors::monitor`). `combination/monitors.rs` creates it, passes it stimuli and returns its
//! verdict; the kinds of parts are in `basic/`, `episodes/`, `numbers/` and `combination/`. The files next to these folders serve all of
//! them.

pub(crate) mod basic;
pub(crate) mod combination;
pub(crate) mod constraints;
pub(crate) mod derivation;
pub(crate) mod episodes;
pub(crate) mod memory;
pub(crate) mod mismatch;
pub(crate) mod numbers;
pub(crate) mod part;
pub(crate) mod pattern_matching;
pub(crate) mod reported_results;
pub(crate) mod sampled;
pub(crate) mod samples;
pub(crate) mod specificity;
pub(crate) mod stimulus;
#[cfg(test)]
mod tests;
pub(crate) mod time_bounds;
pub(crate) mod verdict_query;
pub(crate) mod wake;

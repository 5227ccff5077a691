//! Conditions on numbers: persistence, regression, statistics, trends, cycles.

pub(crate) mod aggregates;
pub(crate) mod cyclic;
pub(crate) mod line_crossing;
pub(crate) mod persistence;
pub(crate) mod regression;
pub(crate) mod significance;
pub(crate) mod sliding_window;
pub(crate) mod statistic_runs;
pub(crate) mod statistics;
pub(crate) mod weighted_crossing;

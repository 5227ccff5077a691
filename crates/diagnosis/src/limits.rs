//! Limits of models and of the search, each with its reason.

/// Failure modes of a model: twenty times the size for which response times are stated.
pub const MODES_MAX: usize = 4_096;
/// Tests of a model, as [`MODES_MAX`].
pub const TESTS_MAX: usize = 4_096;
/// Sets of failure modes that make one signal or test fail, or that keep it working: nested redundancy multiplies them.
pub const TERMS_MAX: usize = 512;
/// Minimal candidate sets kept for one group of failed tests, the likeliest first.
pub const CANDIDATES_MAX: usize = 64;
/// Partial sets examined in the search for candidates of one group. With this limit a changed test result takes less than 1 ms in the
/// hardest case of the benchmark `diagnosis`.
pub const NODES_MAX: usize = 500;
/// Sets of tests that are left out on trial, in order, to find the smallest ones without which the other results are consistent. Limited
/// for use in flight, like [`NODES_MAX`].
pub const RETRACTIONS_MAX: usize = 60;
/// The same for a report on the ground, which may take a second.
pub const RETRACTIONS_REPORT_MAX: usize = 20_000;
/// Partial sets examined to decide whether one set of tests leaves the rest consistent, if passed tests exclude sets of failures.
pub const RETRACTION_NODES_MAX: usize = 40;
/// Number of tried sets as which such a decision counts towards [`RETRACTIONS_MAX`].
pub const RETRACTION_SEARCH: usize = 20;
/// Smallest sets of tests that a contradiction names.
pub const ALTERNATIVES_MAX: usize = 8;
/// Partial sets that the search for the smallest set of tests examines; a report is not made in flight.
pub const TEST_SET_NODES_MAX: usize = 500_000;
/// Pairs of failure modes that this search distinguishes. With more pairs, the result is a small set but perhaps not the smallest.
pub const TEST_SET_PAIRS_MAX: usize = 4_000;
/// Triples of masked failures that a report lists.
pub const MASKS_MAX: usize = 100;

//! A sample in memory.

/// One sample. A word is stored as its index in the list of words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::record::view) struct StoredSample {
    /// Instant of the measurement.
    pub(in crate::record::view) at_ns: i64,
    /// The instant of the step in which it arrived.
    pub(in crate::record::view) arrived_ns: i64,
    pub(in crate::record::view) value: f64,
}

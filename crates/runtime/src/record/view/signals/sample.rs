//! A sample in memory.

/// One sample. Words are their places in the list of words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::record::view) struct StoredSample {
    /// Instant of the measurement.
    pub(in crate::record::view) at_ns: i64,
    /// The instant of the step that it came in.
    pub(in crate::record::view) arrived_ns: i64,
    pub(in crate::record::view) value: f64,
}

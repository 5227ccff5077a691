//! Gaps of a record: steps that its disk did not take.

use apex_model::time::Time;

/// Steps that a record does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordGap {
    /// Number of the first step that is missing.
    pub first_batch: i64,
    /// Number of the last step that is missing.
    pub last_batch: i64,
    /// The instant of the step before.
    pub after: Time,
    /// The instant of the step that follows; `None` if none does.
    pub before: Option<Time>,
}

impl std::fmt::Display for RecordGap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "steps {} to {}, after {}", self.first_batch, self.last_batch, self.after)?;
        self.before.map_or(Ok(()), |before| write!(f, " and before {before}"))
    }
}

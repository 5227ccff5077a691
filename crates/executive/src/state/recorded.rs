//! Result of recording a sample in a history.

/// Result of recording a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// Newer than all before.
    Appended,
    /// Late, but within the variable's lateness: put in order.
    Inserted,
    /// Another value for an instant already known: the later arrival wins.
    Replaced,
    /// The same value for the same instant: nothing changes.
    Repeated,
    /// Later than the variable's lateness allows: kept aside.
    TooLate,
    /// Not a number: a missing measurement.
    Missing,
}

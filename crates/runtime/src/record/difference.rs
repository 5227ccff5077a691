//! A recorded row that differs from its replay.

/// The first row in which a replay differs from the record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RowDifference {
    /// The table's name and the number of its row, from 1: `track 12`.
    pub row: String,
    /// The column; empty if a whole row is missing or added.
    pub column: &'static str,
    /// The recorded side as text; `None` if the record has no such row.
    pub recorded: Option<String>,
    /// The replayed side as text; `None` if the replay makes no such row.
    pub replayed: Option<String>,
}

//! The operator commands in a record, as known at an instant.

use super::command_index::RecordedCommand;
use super::{RecordView, for_reading, for_writing};
use crate::error::RecordError;
use serde::Serialize;

/// Operator commands that were decided by an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RecordedCommands {
    /// By time.
    pub commands: Vec<RecordedCommand>,
}

impl RecordView {
    /// Returns the commands that were decided by mission time `at_ns` (nanoseconds; `None`: the record's end). A command that several
    /// agents received is listed once.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn operator_commands(&self, at_ns: Option<i64>) -> Result<RecordedCommands, RecordError> {
        self.refresh_commands()?;
        let commands = for_reading(&self.indexes.commands).known(at_ns.unwrap_or(i64::MAX)).to_vec();
        Ok(RecordedCommands { commands })
    }

    /// Reads the commands that are new in the record.
    pub(super) fn refresh_commands(&self) -> Result<(), RecordError> {
        self.reader.check_growth()?;
        let newest = self.query("the steps", |connection| {
            let sql = "SELECT ifnull(max(id), 0) FROM main.batch";
            connection.prepare_cached(sql)?.query_row([], |row| row.get::<_, i64>(0))
        })?;
        // Only a view that must extend the index locks out the other views.
        if for_reading(&self.indexes.commands).seen_batch() < newest {
            for_writing(&self.indexes.commands).refresh(&self.reader)?;
        }
        Ok(())
    }
}

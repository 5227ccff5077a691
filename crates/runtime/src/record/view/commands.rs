//! The operator commands in a record, each with its end.

use super::RecordView;
use crate::commands::HEAD;
use crate::error::RecordError;
use crate::record::codec;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::Serialize;

/// Commands by an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RecordedCommands {
    /// By time.
    pub commands: Vec<RecordedCommand>,
}

/// A command of an operator and its end.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RecordedCommand {
    /// Mission time in nanoseconds at which the run decided about it.
    pub t_ns: i64,
    /// Its number.
    pub number: i64,
    /// The command as text.
    pub words: String,
    /// `accepted`, `rejected` or `expired`.
    pub end: String,
    /// Reason of a rejection; empty for other ends.
    pub reason: String,
}

impl RecordView {
    /// Returns the commands that were decided by mission time `at_ns` (nanoseconds; `None`: the record's end). A command that several
    /// agents received is listed once.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn operator_commands(&self, at_ns: Option<i64>) -> Result<RecordedCommands, RecordError> {
        self.reader.check_growth()?;
        let broken = |error| self.reader.damaged("the steps", error);
        // Symbols are stored as they are printed: only batches that name a command are read.
        let sql = "SELECT id, t_ns, events FROM main.batch WHERE t_ns <= ?1 AND instr(events, CAST(?2 AS BLOB)) > 0 ORDER BY id";
        let mut statement = self.reader.connection.prepare_cached(sql).map_err(broken)?;
        let mut rows = statement.query((at_ns.unwrap_or(i64::MAX), HEAD)).map_err(broken)?;
        let mut commands: Vec<RecordedCommand> = Vec::new();
        let mut variables = None;
        while let Some(row) = rows.next().map_err(broken)? {
            let (id, t_ns): (i64, i64) = row.get(0).and_then(|id| Ok((id, row.get(1)?))).map_err(broken)?;
            let bytes = row.get_ref(2).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            if variables.is_none() {
                variables = Some(self.reader.variable_table()?);
            }
            let Some(variables) = &variables else { continue };
            let batch = codec::decode(Time(t_ns), bytes, variables).map_err(|fault| {
                self.reader.garbled(format!("batch {id} at {} cannot be read: {fault}", Time(t_ns)))
            })?;
            for command in batch.events.iter().filter_map(|event| command(t_ns, &event.kind)) {
                if !commands.iter().any(|known| known.number == command.number && known.words == command.words) {
                    commands.push(command);
                }
            }
        }
        Ok(RecordedCommands { commands })
    }
}

fn command(t_ns: i64, kind: &EventKind) -> Option<RecordedCommand> {
    let EventKind::Occurrence(form) = kind else { return None };
    let [head, Value::Integer(number), Value::Text(words), end, rest @ ..] = form.as_list()? else { return None };
    head.as_symbol().filter(|head| head.is(HEAD))?;
    let reason = rest.first().map(|reason| match reason {
        Value::Text(text) => text.to_string(),
        other => other.to_string(),
    });
    Some(RecordedCommand {
        t_ns,
        number: *number,
        words: words.to_string(),
        end: end.to_string(),
        reason: reason.unwrap_or_default(),
    })
}

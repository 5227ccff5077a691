//! The operator commands in a record, each with its end, kept in memory and extended with the record.

use crate::commands::{HEAD, acknowledged_alarm};
use crate::error::RecordError;
use crate::record::{RecordReader, codec};
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::Serialize;

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
    /// Reason of a rejection or an expiry; `None` for other ends.
    pub reason: Option<String>,
    /// The alarm that it acknowledges.
    pub alarm: Option<String>,
}

/// All commands, kept in memory and grown with the record. Bound: each step is read once.
#[derive(Default)]
pub(super) struct CommandIndex {
    /// By time.
    commands: Vec<RecordedCommand>,
    /// The last step that was read.
    seen_batch: i64,
}

impl CommandIndex {
    /// Returns the last step that was read.
    pub(super) fn seen_batch(&self) -> i64 {
        self.seen_batch
    }

    /// Returns the commands that were decided by `at_ns`.
    pub(super) fn known(&self, at_ns: i64) -> &[RecordedCommand] {
        let known = self.commands.partition_point(|command| command.t_ns <= at_ns);
        self.commands.get(..known).unwrap_or_default()
    }

    /// Reads the steps that were recorded since the last call.
    pub(super) fn refresh(&mut self, reader: &RecordReader) -> Result<(), RecordError> {
        let broken = |error| reader.damaged("the steps", error);
        let last = "SELECT ifnull(max(id), 0) FROM main.batch";
        let last: i64 = reader.connection.query_row(last, [], |row| row.get(0)).map_err(broken)?;
        // Symbols are stored as they are printed: only batches that name a command are read.
        let sql = "SELECT id, t_ns, events FROM main.batch \
                   WHERE id > ?1 AND id <= ?2 AND instr(events, CAST(?3 AS BLOB)) > 0 ORDER BY id";
        let mut statement = reader.connection.prepare_cached(sql).map_err(broken)?;
        let mut rows = statement.query((self.seen_batch, last, HEAD)).map_err(broken)?;
        let mut variables = None;
        while let Some(row) = rows.next().map_err(broken)? {
            let (id, t_ns): (i64, i64) = row.get(0).and_then(|id| Ok((id, row.get(1)?))).map_err(broken)?;
            let bytes = row.get_ref(2).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            if variables.is_none() {
                variables = Some(reader.variable_table()?);
            }
            let Some(variables) = &variables else { continue };
            let batch = codec::decode(Time(t_ns), bytes, variables)
                .map_err(|fault| reader.garbled(format!("batch {id} at {} cannot be read: {fault}", Time(t_ns))))?;
            for command in batch.events.iter().filter_map(|event| command(t_ns, &event.kind)) {
                let is_same = |known: &RecordedCommand| known.number == command.number && known.words == command.words;
                if !self.commands.iter().any(is_same) {
                    self.commands.push(command);
                }
            }
        }
        self.seen_batch = last;
        Ok(())
    }
}

fn command(t_ns: i64, kind: &EventKind) -> Option<RecordedCommand> {
    let EventKind::Occurrence(form) = kind else { return None };
    let [head, Value::Integer(number), Value::Text(words), end, rest @ ..] = form.as_list()? else { return None };
    head.as_symbol().filter(|head| head.is(HEAD))?;
    // After the end and its reason come the author and the epoch as keywords.
    let reason = match rest {
        [Value::Text(reason), ..] => Some(reason.to_string()),
        _ => None,
    };
    let alarm = acknowledged_alarm(rest).map(str::to_owned);
    Some(RecordedCommand { t_ns, number: *number, words: words.to_string(), end: end.to_string(), reason, alarm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::authority::{Actor, ActorRole};
    use crate::commands::{Author, Command, CommandEnd, Order, Ticket};

    #[test]
    fn an_acknowledgement_names_its_alarm() {
        let alarm = "fault: the \"mount\" :by ann (0:53:04)";
        let of = |order: Order| {
            let (words, ticket) = (format!("acknowledge {alarm}"), Ticket::default());
            let given = Command { number: 1, words, order, author: None, ticket };
            command(5, &given.entry(&CommandEnd::Accepted { at: Time(5) })).unwrap().alarm
        };
        assert_eq!(of(Order::Acknowledge(alarm.into())).as_deref(), Some(alarm));
        assert_eq!(of(Order::Note), None);
    }

    #[test]
    fn a_rejection_and_an_expiry_have_a_reason() {
        let author = Author { actor: Actor { name: "ann".into(), role: ActorRole::Operator }, epoch: Some(1) };
        let (order, ticket) = (Order::Note, Ticket::default());
        let given = Command { number: 1, words: "pause".into(), order, author: Some(author), ticket };
        let reason = |end: CommandEnd| command(5, &given.entry(&end)).unwrap().reason;
        assert_eq!(reason(CommandEnd::Accepted { at: Time(5) }), None);
        assert_eq!(reason(CommandEnd::Expired { reason: "after 2 s".into() }).as_deref(), Some("after 2 s"));
        assert_eq!(reason(CommandEnd::Rejected { reason: "too late".into() }).as_deref(), Some("too late"));
    }
}

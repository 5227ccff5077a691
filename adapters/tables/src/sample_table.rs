//! A table of samples and messages, written row by row as they arrive.

use crate::{Row, TableWriter};
use apex_executive::MonitorSession;
use apex_model::event::{EventKind, Message, StateVariable};
use apex_model::time::Time;
use apex_model::value::Value;
use std::io;

/// Writes each sample and message with its treatment by a session of conditions: kept, late, refused and so on.
pub struct SampleTable {
    session: MonitorSession,
    writer: Box<dyn TableWriter>,
    rows: i64,
    now: Time,
}

impl SampleTable {
    /// Returns an empty table. `session` holds the declared state variables, and watches no condition.
    pub fn new(session: MonitorSession, writer: Box<dyn TableWriter>) -> SampleTable {
        SampleTable { session, writer, rows: 0, now: Time::BEGINNING }
    }

    /// Writes the row of a sample or message. Other events only advance the instant of arrival.
    ///
    /// # Errors
    /// The table cannot be written.
    pub fn write(&mut self, at: Time, kind: EventKind) -> io::Result<()> {
        match kind {
            EventKind::Measurement(variable, value) | EventKind::Told(_, Message::Measurement(variable, value)) => {
                self.sample(&variable, &value, at)
            }
            EventKind::Occurrence(form) | EventKind::Told(_, Message::Occurrence(form)) => {
                let stamp = self.stamp(at);
                self.writer.write(Row::event(stamp, &form))
            }
            EventKind::CommandAcknowledged(..)
            | EventKind::CommandProgressed(..)
            | EventKind::SolverReported(..)
            | EventKind::OperatorAnswered(..)
            | EventKind::Woken
            | EventKind::Stop(_) => {
                self.now = self.now.max(at);
                Ok(())
            }
        }
    }

    /// Ends the table. Returns the number of its rows.
    ///
    /// # Errors
    /// The rest of the table cannot be written.
    pub fn finish(self) -> io::Result<i64> {
        self.writer.finish()?;
        Ok(self.rows)
    }

    fn sample(&mut self, variable: &StateVariable, value: &Value, at: Time) -> io::Result<()> {
        let stamp = self.stamp(at);
        let recorded = self.session.sample(variable, value.clone(), at);
        // Without watched conditions the session need not keep results.
        self.session.advance_to(at);
        self.session.take_troubles();
        let declared = self.session.library().state_variables.get(&variable.attribute);
        let row = Row::sample(stamp, variable, value, declared.and_then(|declared| declared.unit.as_ref()), recorded);
        self.writer.write(row)
    }

    /// Returns number, own instant and instant of arrival of the next row.
    fn stamp(&mut self, at: Time) -> (i64, Time, Time) {
        self.rows += 1;
        self.now = self.now.max(at);
        (self.rows, at, self.now)
    }
}

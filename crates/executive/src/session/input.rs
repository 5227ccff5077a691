//! Inputs of a session: events of a record, a log or a live feed.

use super::MonitorSession;
use apex_model::event::{EventKind, Message};
use apex_model::time::Time;

impl MonitorSession {
    /// Processes a recorded or live event: a sample, a message, or only an instant that time has reached.
    pub fn take(&mut self, kind: EventKind, at: Time) {
        match kind {
            EventKind::Measurement(variable, value) | EventKind::Told(_, Message::Measurement(variable, value)) => {
                self.sample(&variable, value, at);
            }
            EventKind::Occurrence(form) | EventKind::Told(_, Message::Occurrence(form)) => self.event(form, at),
            EventKind::CommandAcknowledged(..)
            | EventKind::CommandProgressed(..)
            | EventKind::SolverReported(..)
            | EventKind::OperatorAnswered(..)
            | EventKind::Woken
            | EventKind::Stop(_) => self.advance_to(at),
        }
    }
}

//! The inbox: numbers and queues inputs, assembles the batches of executive steps.
//!
//! All inputs of one instant belong to one batch, in order of arrival. The queue is bounded; an input beyond the limit is reported as an
//! error of the sender.

use crate::error::RunError;
use crate::limits::INBOX_INPUTS_MAX;
use crate::ports::Input;
use apex_model::event::{Batch, Event};
use apex_model::limits::BATCH_EVENTS_MAX;
use apex_model::time::Time;
use std::collections::VecDeque;

/// Inputs that wait for their instant.
#[derive(Debug, Default)]
pub struct Inbox {
    queue: VecDeque<Input>,
    ordered: bool,
    last_sequence: u64,
}

impl Inbox {
    /// Returns an empty inbox; the first event gets number 1.
    pub fn new() -> Inbox {
        Inbox { queue: VecDeque::new(), ordered: true, last_sequence: 0 }
    }

    /// Continues the numbering after event `last_sequence`.
    pub fn resume(&mut self, last_sequence: u64) {
        self.last_sequence = last_sequence;
    }

    /// Returns the number of waiting inputs.
    pub fn len(&self) -> usize {
        self.queue.len()
    }

    /// Returns true when nothing waits.
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Queues an input. Inputs of one instant keep the order in which they were pushed.
    ///
    /// # Errors
    /// [`RunError::InboxFull`] when [`INBOX_INPUTS_MAX`] inputs wait already.
    pub fn push(&mut self, input: Input) -> Result<(), RunError> {
        if self.queue.len() >= INBOX_INPUTS_MAX {
            return Err(RunError::InboxFull { at: input.at, limit: INBOX_INPUTS_MAX });
        }
        self.ordered = self.ordered && self.queue.back().is_none_or(|last| last.at <= input.at);
        self.queue.push_back(input);
        Ok(())
    }

    /// Returns the batch of the step at `now`: all inputs up to that instant, oldest first, numbered. More than [`BATCH_EVENTS_MAX`]
    /// events are left for a further batch of the same instant. `None` if there is no input.
    pub fn take(&mut self, now: Time) -> Option<Batch> {
        if !self.ordered {
            self.queue.make_contiguous().sort_by_key(|input| input.at);
            self.ordered = true;
        }
        let count = self.queue.iter().take(BATCH_EVENTS_MAX).take_while(|input| input.at <= now).count();
        if count == 0 {
            return None;
        }
        let mut events = Vec::with_capacity(count);
        for input in self.queue.drain(..count) {
            self.last_sequence = self.last_sequence.saturating_add(1);
            events.push(Event { sequence: self.last_sequence, at: input.at, kind: input.kind });
        }
        Some(Batch { now, events })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::event::EventKind;
    use apex_model::value::Value;

    fn occurrence(seconds: f64, name: &str) -> Input {
        Input::new(Time::from_seconds(seconds), EventKind::Occurrence(Value::symbol(name)))
    }

    #[test]
    fn events_of_one_instant_are_one_batch_in_order_of_arrival() {
        let mut inbox = Inbox::new();
        for input in [occurrence(2.0, "c"), occurrence(1.0, "a"), occurrence(1.0, "b")] {
            inbox.push(input).unwrap();
        }
        let batch = inbox.take(Time::from_seconds(1.0)).unwrap();
        let said: Vec<String> =
            batch.events.iter().map(|event| format!("{}:{:?}", event.sequence, event.kind)).collect();
        assert_eq!(said, ["1:Occurrence(a)", "2:Occurrence(b)"]);
        assert_eq!(inbox.take(Time::from_seconds(1.5)), None);
        assert_eq!(inbox.take(Time::from_seconds(2.0)).unwrap().events[0].sequence, 3);
    }

    #[test]
    fn a_flood_is_split_and_a_deluge_is_refused() {
        let mut inbox = Inbox::new();
        for _ in 0..INBOX_INPUTS_MAX {
            inbox.push(occurrence(1.0, "a")).unwrap();
        }
        let refusal = inbox.push(occurrence(1.0, "a")).unwrap_err().to_string();
        assert!(refusal.contains("400000"), "{refusal}");
        let batch = inbox.take(Time::from_seconds(1.0)).unwrap();
        assert_eq!((batch.events.len(), inbox.len()), (BATCH_EVENTS_MAX, INBOX_INPUTS_MAX - BATCH_EVENTS_MAX));
    }
}

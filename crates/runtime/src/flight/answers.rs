//! The vehicle's answers to commands: the first one ends a command, and a later one that contradicts it is noted as ignored.
//!
//! Bound: O(log n) per answer.

use apex_model::effect::CommandId;
use apex_model::event::{Batch, EventKind};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Maximum number of remembered answers; the oldest are forgotten. A contradiction follows soon.
const ANSWERS_MAX: usize = 1_000;

/// Answers of the last commands, by agent and number.
#[derive(Debug, Default)]
pub(super) struct AnswerBook {
    first: BTreeMap<(usize, CommandId), Result<Value, String>>,
}

impl AnswerBook {
    /// Takes the answers in a batch of agent `index`; `outer` is the number of a command in the application. Returns a note for each
    /// answer that contradicts an earlier one.
    pub(super) fn take(&mut self, index: usize, batch: &Batch, outer: impl Fn(CommandId) -> u64) -> Vec<String> {
        let mut notes = Vec::new();
        for event in &batch.events {
            let EventKind::CommandAcknowledged(command, result) = &event.kind else { continue };
            match self.first.get(&(index, *command)) {
                None => {
                    self.first.insert((index, *command), result.clone());
                }
                Some(first) if first == result => {}
                Some(first) => notes.push(format!(
                    "command {} has ended ({}): the later answer ({}) is ignored",
                    outer(*command),
                    words(first),
                    words(result)
                )),
            }
        }
        while self.first.len() > ANSWERS_MAX {
            self.first.pop_first();
        }
        notes
    }
}

fn words(result: &Result<Value, String>) -> String {
    match result {
        Ok(value) if !value.is_true() => "done".to_string(),
        Ok(value) => format!("done with {value}"),
        Err(reason) => format!("failed: {reason}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::event::Event;
    use apex_model::time::Time;

    #[test]
    fn a_contradiction_is_noted_and_a_repetition_is_not() {
        let mut book = AnswerBook::default();
        let mut notes = |results: &[Result<Value, String>]| {
            let event = |result: &Result<Value, String>| Event {
                sequence: 1,
                at: Time::ZERO,
                kind: EventKind::CommandAcknowledged(CommandId(3), result.clone()),
            };
            let batch = Batch { now: Time::ZERO, events: results.iter().map(event).collect() };
            book.take(0, &batch, |command| command.0)
        };
        assert!(notes(&[Ok(Value::nil()), Ok(Value::nil())]).is_empty());
        let late = notes(&[Err("ice".into())]);
        assert_eq!(late, ["command 3 has ended (done): the later answer (failed: ice) is ignored"]);
    }
}

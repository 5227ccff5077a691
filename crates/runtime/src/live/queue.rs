//! The queue of one source: the latest value of each telemetry variable, and all other inputs.
//!
//! A value replaces an older one of the same variable only if nothing but telemetry is between them, so that the run receives inputs in
//! the order in which they were sent. Bound: O(log n) for each input.

use apex_model::event::{EventKind, StateVariable};
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, VecDeque};

/// Maximum number of waiting inputs other than telemetry; a reader with more must wait, and so does its source.
pub(super) const COMMANDS_MAX: usize = 1_000;
/// Maximum number of values of telemetry that wait; beyond, the oldest is lost.
pub(super) const VALUES_MAX: usize = 4_096;

type ValueKey = (StateVariable, Option<Symbol>);

/// One input of a source.
#[derive(Clone, Debug, PartialEq)]
pub enum LiveInput {
    /// An input for one agent (`None`: for all).
    Event(Option<Symbol>, EventKind),
    /// The run is to end cleanly.
    Stop,
}

/// Inputs that wait.
#[derive(Debug, Default)]
pub(super) struct SourceQueue {
    /// Oldest first; `None` in the place of a lost value.
    slots: VecDeque<Option<LiveInput>>,
    /// The number of the first slot; slots are counted from 0 and never renumbered.
    first: u64,
    /// Slots of values that may be replaced.
    latest: BTreeMap<ValueKey, u64>,
    /// Slots of values, oldest first.
    values: VecDeque<u64>,
    commands: usize,
    lost: Lost,
}

/// Values that the run will not see, since the last report.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lost {
    /// Their number.
    pub(super) count: u64,
    /// The variable of the last lost value.
    pub(super) variable: Option<StateVariable>,
}

/// Outcome of adding an input.
#[derive(Debug, PartialEq)]
pub(super) enum Pushed {
    Kept,
    /// The queue has no space for the input.
    Refused(LiveInput),
}

impl SourceQueue {
    /// Returns true if nothing waits.
    pub(super) fn is_empty(&self) -> bool {
        self.commands == 0 && self.values.is_empty()
    }

    /// Returns true if an input that is not telemetry finds space.
    pub(super) fn has_space(&self) -> bool {
        self.commands < COMMANDS_MAX
    }

    /// Adds an input.
    pub(super) fn push(&mut self, input: LiveInput) -> Pushed {
        let key = match &input {
            LiveInput::Event(agent, EventKind::Measurement(variable, _)) => (variable.clone(), agent.clone()),
            _ if !self.has_space() => return Pushed::Refused(input),
            _ => {
                self.commands += 1;
                self.latest.clear();
                self.slots.push_back(Some(input));
                return Pushed::Kept;
            }
        };
        let older = self.latest.get(&key).and_then(|slot| self.index_of(*slot));
        if let Some(slot) = older.and_then(|index| self.slots.get_mut(index)) {
            *slot = Some(input);
            self.lose(key.0);
            return Pushed::Kept;
        }
        if self.values.len() >= VALUES_MAX {
            self.lose_oldest();
        }
        let number = self.first + self.slots.len() as u64;
        self.values.push_back(number);
        self.latest.insert(key, number);
        self.slots.push_back(Some(input));
        Pushed::Kept
    }

    fn index_of(&self, number: u64) -> Option<usize> {
        usize::try_from(number.checked_sub(self.first)?).ok()
    }

    fn lose(&mut self, variable: StateVariable) {
        self.lost.count += 1;
        self.lost.variable = Some(variable);
    }

    fn lose_oldest(&mut self) {
        let Some(number) = self.values.pop_front() else { return };
        let Some(index) = self.index_of(number) else { return };
        if let Some(input) = self.slots.get_mut(index).and_then(Option::take)
            && let Some(key) = key_of(&input)
        {
            self.forget(&key, number);
            self.lose(key.0);
        }
    }

    /// Lets the value of slot `number` no longer be replaced.
    fn forget(&mut self, key: &ValueKey, number: u64) {
        if self.latest.get(key) == Some(&number) {
            self.latest.remove(key);
        }
    }

    /// Takes the oldest input.
    pub(super) fn pop(&mut self) -> Option<LiveInput> {
        while let Some(slot) = self.slots.pop_front() {
            let number = self.first;
            self.first += 1;
            let Some(input) = slot else { continue };
            match key_of(&input) {
                Some(key) => {
                    self.values.pop_front();
                    self.forget(&key, number);
                }
                None => self.commands -= 1,
            }
            return Some(input);
        }
        None
    }

    /// Returns true if values were lost since the last report.
    pub(super) fn has_lost(&self) -> bool {
        self.lost.count > 0
    }

    /// Returns the losses since the last report.
    pub(super) fn take_lost(&mut self) -> Lost {
        std::mem::take(&mut self.lost)
    }
}

fn key_of(input: &LiveInput) -> Option<ValueKey> {
    match input {
        LiveInput::Event(agent, EventKind::Measurement(variable, _)) => Some((variable.clone(), agent.clone())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::value::Value;
    use proptest::prelude::*;

    fn variable(name: u8) -> StateVariable {
        StateVariable::new(Symbol::new("height"), Value::Integer(i64::from(name)))
    }

    fn value(name: u8, value: i64) -> LiveInput {
        LiveInput::Event(None, EventKind::Measurement(variable(name), Value::Integer(value)))
    }

    fn command(number: i64) -> LiveInput {
        LiveInput::Event(None, EventKind::Occurrence(Value::Integer(number)))
    }

    fn all(queue: &mut SourceQueue) -> Vec<LiveInput> {
        std::iter::from_fn(|| queue.pop()).collect()
    }

    #[test]
    fn the_latest_value_wins_and_commands_keep_their_place() {
        let mut queue = SourceQueue::default();
        for input in [value(1, 1), value(2, 2), value(1, 3), command(4), value(1, 5), value(1, 6), command(7)] {
            assert_eq!(queue.push(input), Pushed::Kept);
        }
        assert_eq!(queue.take_lost(), Lost { count: 2, variable: Some(variable(1)) });
        assert_eq!(all(&mut queue), [value(1, 3), value(2, 2), command(4), value(1, 6), command(7)]);
        assert!(queue.is_empty() && !queue.has_lost());
    }

    #[test]
    fn no_command_is_lost_and_the_oldest_value_is() {
        let mut queue = SourceQueue::default();
        for number in 0..COMMANDS_MAX as i64 {
            assert_eq!(queue.push(command(number)), Pushed::Kept);
        }
        assert_eq!(queue.push(command(-1)), Pushed::Refused(command(-1)));
        assert_eq!(queue.pop(), Some(command(0)));
        assert_eq!(queue.push(command(-1)), Pushed::Kept);
        let mut queue = SourceQueue::default();
        for number in 0..=VALUES_MAX as i64 {
            let variable = StateVariable::new(Symbol::new("height"), Value::Integer(number));
            queue.push(LiveInput::Event(None, EventKind::Measurement(variable, Value::Integer(number))));
        }
        let lost = queue.take_lost();
        assert_eq!((lost.count, lost.variable), (1, Some(variable(0))));
        assert_eq!(all(&mut queue).len(), VALUES_MAX);
    }

    /// Computes the inputs that the run takes (naive twin): a later value of the same variable replaces a waiting one in its place,
    /// unless a command is between them or the run has taken the older one.
    fn naive(said: &[Option<LiveInput>]) -> (Vec<LiveInput>, u64) {
        let (mut waits, mut taken, mut lost): (Vec<LiveInput>, Vec<LiveInput>, u64) = (Vec::new(), Vec::new(), 0);
        for step in said {
            let Some(input) = step else {
                if !waits.is_empty() {
                    taken.push(waits.remove(0));
                }
                continue;
            };
            let since = waits.iter().rposition(|each| key_of(each).is_none()).map_or(0, |last| last + 1);
            let same = |each: &LiveInput| key_of(each).is_some() && key_of(each) == key_of(input);
            match waits[since..].iter().position(same) {
                Some(place) => {
                    waits[since + place] = input.clone();
                    lost += 1;
                }
                None => waits.push(input.clone()),
            }
        }
        taken.extend(waits);
        (taken, lost)
    }

    proptest! {
        #[test]
        fn the_queue_is_its_naive_twin(steps in prop::collection::vec((0u8..5, 0u8..4), 0..60)) {
            let said: Vec<Option<LiveInput>> = steps.iter().enumerate().map(|(index, (kind, name))| match kind {
                0 => None,
                1 => Some(command(index as i64)),
                _ => Some(value(*name, index as i64)),
            }).collect();
            let (mut queue, mut taken) = (SourceQueue::default(), Vec::new());
            for step in &said {
                match step {
                    None => taken.extend(queue.pop()),
                    Some(input) => prop_assert_eq!(queue.push(input.clone()), Pushed::Kept),
                }
            }
            taken.extend(all(&mut queue));
            let lost = queue.take_lost().count;
            prop_assert_eq!((taken, lost), naive(&said));
        }
    }
}

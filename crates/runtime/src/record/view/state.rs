//! A task's state as the word in the record and in answers.

use apex_model::task::TaskState;
use rusqlite::types::{FromSql, FromSqlError, FromSqlResult, ValueRef};
use serde::{Serialize, Serializer};

/// All states, in the order in which a task usually passes them.
const ALL: [TaskState; 5] =
    [TaskState::Pending, TaskState::Enabled, TaskState::Ongoing, TaskState::Interrupted, TaskState::Terminated];

/// A task's state; serialised as its word, `ongoing`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct StateWord(pub TaskState);

impl StateWord {
    /// Returns true unless the task has ended.
    pub fn is_alive(self) -> bool {
        self.0 != TaskState::Terminated
    }

    /// Returns the state's place in the order in which a task usually passes them, from 0.
    pub(super) fn number(self) -> u8 {
        match self.0 {
            TaskState::Pending => 0,
            TaskState::Enabled => 1,
            TaskState::Ongoing => 2,
            TaskState::Interrupted => 3,
            TaskState::Terminated => 4,
        }
    }

    /// Returns the state with this word.
    fn parse(word: &str) -> Option<StateWord> {
        ALL.into_iter().find(|state| state.word() == word).map(StateWord)
    }
}

impl Serialize for StateWord {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.word())
    }
}

impl FromSql for StateWord {
    fn column_result(value: ValueRef<'_>) -> FromSqlResult<Self> {
        let word = value.as_str()?;
        StateWord::parse(word)
            .ok_or_else(|| FromSqlError::Other(format!("expected the state of a task, found `{word}`").into()))
    }
}

/// The page's type is the union of the words.
#[cfg(test)]
impl ts_rs::TS for StateWord {
    type WithoutGenerics = Self;
    type OptionInnerType = Self;
    const IS_ENUM: bool = true;

    fn name(_: &ts_rs::Config) -> String {
        "TaskState".into()
    }

    fn inline(_: &ts_rs::Config) -> String {
        ALL.map(|state| format!("\"{state}\"")).join(" | ")
    }

    fn decl(cfg: &ts_rs::Config) -> String {
        format!("type TaskState = {};", Self::inline(cfg))
    }

    fn docs() -> Option<String> {
        Some("/** A task's state. */\n".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_is_read_back_from_its_word() {
        for state in ALL {
            assert_eq!(StateWord::parse(state.word()), Some(StateWord(state)));
            assert_eq!(ALL.get(usize::from(StateWord(state).number())), Some(&state));
        }
        assert_eq!(StateWord::parse("Ongoing"), None);
    }
}

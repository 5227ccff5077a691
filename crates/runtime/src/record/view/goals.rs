//! Goals of tasks as the index keeps them: as text, with the names in them.

use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// A goal as text, and what programs ask about it, so that they need not read the text.
#[derive(Clone, Debug)]
pub(super) struct IndexedGoal {
    pub(super) text: Box<str>,
    /// The names in it, at any depth, each once; its head is the first one.
    names: Box<[Symbol]>,
}

impl IndexedGoal {
    pub(super) fn of(goal: &Value) -> IndexedGoal {
        let mut names = Vec::new();
        add_names(goal, &mut names);
        IndexedGoal { text: goal.to_string().into_boxed_str(), names: names.into_boxed_slice() }
    }

    /// Returns those of `targets` that the goal names.
    pub(super) fn targets(&self, targets: &TargetNames) -> Vec<String> {
        self.names.iter().filter_map(|name| targets.get(name.folded())).cloned().collect()
    }

    /// Returns true if a task with this goal only sends a message or asks a question.
    pub(super) fn is_message(&self) -> bool {
        self.names.first().is_some_and(|head| MESSAGES.contains(&head.folded()))
    }
}

/// Adds the names in a value that are not among `names` yet.
fn add_names(value: &Value, names: &mut Vec<Symbol>) {
    match value {
        Value::Symbol(name) if !names.contains(name) => names.push(name.clone()),
        Value::List(items) => items.iter().for_each(|item| add_names(item, names)),
        _ => {}
    }
}

/// The identifiers of targets by their text in lower case.
pub(super) type TargetNames = BTreeMap<String, String>;

/// Heads of goals whose tasks only send a message or ask a question.
const MESSAGES: [&str; 3] = ["inform", "print", "ask"];

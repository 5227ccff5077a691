//! The table of interests: which monitors must be told of what, so that an event touches only those that wait for it.

use crate::clause::MonitorId;
use crate::event::StateVariable;
use crate::monitor::Interest;
use crate::symbol::Symbol;
use crate::task::TaskId;
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Monitors by interest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interests {
    variables: BTreeMap<StateVariable, BTreeSet<MonitorId>>,
    attributes: BTreeMap<Symbol, BTreeSet<MonitorId>>,
    heads: BTreeMap<Symbol, HeadInterests>,
    any_event: BTreeSet<MonitorId>,
    tasks: BTreeMap<TaskId, BTreeSet<MonitorId>>,
    any_task: BTreeSet<MonitorId>,
}

/// Monitors of messages that begin with one word, divided further by the second word where it is known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct HeadInterests {
    general: BTreeSet<MonitorId>,
    by_second: BTreeMap<Value, BTreeSet<MonitorId>>,
}

/// Only values that are equal in one way only may divide messages: a number has several spellings, a string two cases.
fn divides(second: &Value) -> bool {
    matches!(second, Value::Symbol(_) | Value::Integer(_) | Value::Task(_))
}

fn second_word(form: &Value) -> Option<&Value> {
    form.as_list().and_then(|items| items.get(1))
}

fn drop_from<K: Ord>(map: &mut BTreeMap<K, BTreeSet<MonitorId>>, key: &K, monitor: MonitorId) {
    if let Some(set) = map.get_mut(key) {
        set.remove(&monitor);
        if set.is_empty() {
            map.remove(key);
        }
    }
}

impl Interests {
    /// Files `monitor` under `interest`. `second` is the second word of the messages it waits for, where that is known.
    pub fn insert(&mut self, interest: &Interest, second: Option<&Value>, monitor: MonitorId) {
        match interest {
            Interest::Variable(variable) => self.variables.entry(variable.clone()).or_default().insert(monitor),
            Interest::Attribute(attribute) => self.attributes.entry(attribute.clone()).or_default().insert(monitor),
            Interest::EventHead(head) => {
                let entry = self.heads.entry(head.clone()).or_default();
                match second.filter(|second| divides(second)) {
                    Some(second) => entry.by_second.entry(second.clone()).or_default().insert(monitor),
                    None => entry.general.insert(monitor),
                }
            }
            Interest::AnyEvent => self.any_event.insert(monitor),
            Interest::Task(task) => self.tasks.entry(*task).or_default().insert(monitor),
            Interest::AnyTask => self.any_task.insert(monitor),
        };
    }

    /// Takes `monitor` out from under `interest`.
    pub fn remove(&mut self, interest: &Interest, second: Option<&Value>, monitor: MonitorId) {
        match interest {
            Interest::Variable(variable) => drop_from(&mut self.variables, variable, monitor),
            Interest::Attribute(attribute) => drop_from(&mut self.attributes, attribute, monitor),
            Interest::EventHead(head) => self.remove_head(head, second, monitor),
            Interest::AnyEvent => {
                self.any_event.remove(&monitor);
            }
            Interest::Task(task) => drop_from(&mut self.tasks, task, monitor),
            Interest::AnyTask => {
                self.any_task.remove(&monitor);
            }
        }
    }

    fn remove_head(&mut self, head: &Symbol, second: Option<&Value>, monitor: MonitorId) {
        let Some(entry) = self.heads.get_mut(head) else { return };
        match second.filter(|second| divides(second)) {
            Some(second) => drop_from(&mut entry.by_second, second, monitor),
            None => {
                entry.general.remove(&monitor);
            }
        }
        if entry.general.is_empty() && entry.by_second.is_empty() {
            self.heads.remove(head);
        }
    }

    /// Who must be told of a sample of `variable`.
    pub fn of_sample(&self, variable: &StateVariable, found: &mut Vec<MonitorId>) {
        found.extend(self.variables.get(variable).into_iter().flatten());
        found.extend(self.attributes.get(&variable.attribute).into_iter().flatten());
    }

    /// Who must be told of a message.
    pub fn of_event(&self, form: &Value, found: &mut Vec<MonitorId>) {
        found.extend(&self.any_event);
        let head = match form {
            Value::Symbol(symbol) => Some(symbol),
            other => other.as_list().and_then(|items| items.first()).and_then(Value::as_symbol),
        };
        let Some(entry) = head.and_then(|head| self.heads.get(head)) else { return };
        found.extend(&entry.general);
        match second_word(form) {
            Some(second) if divides(second) => found.extend(entry.by_second.get(second).into_iter().flatten()),
            // A message whose second word has another spelling of the same value: a real for an integer, say.
            Some(second) if !entry.by_second.is_empty() => {
                let alike = entry.by_second.iter().filter(|(key, _)| key.matches(second));
                found.extend(alike.flat_map(|(_, monitors)| monitors));
            }
            _ => {}
        }
    }

    /// Who must be told of a transition of `task`.
    pub fn of_task(&self, task: TaskId, found: &mut Vec<MonitorId>) {
        found.extend(self.tasks.get(&task).into_iter().flatten());
        found.extend(&self.any_task);
    }

    /// True when nobody must be told of transitions of `task`.
    pub fn ignore_task(&self, task: TaskId) -> bool {
        self.any_task.is_empty() && !self.tasks.contains_key(&task)
    }
}

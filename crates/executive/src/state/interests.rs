//! The table of interests: the monitors that must receive each stimulus, so that an event touches only those that wait for it.

use crate::state::clause::MonitorId;
use crate::state::episode_index::{EpisodeIndex, LeafId, ThresholdEpisode};
use crate::state::histories::variable_map::VariableMap;
use crate::state::monitor_set::{MonitorIds, MonitorSet};
use crate::state::monitors::monitor::{Interest, ObjectRun};
use crate::state::thresholds::{Threshold, Thresholds};
use apex_model::event::StateVariable;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Monitors by interest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interests {
    variables: VariableMap<Watchers>,
    attributes: BTreeMap<Symbol, MonitorSet>,
    heads: BTreeMap<Symbol, HeadInterests>,
    any_event: MonitorSet,
    tasks: BTreeMap<TaskId, MonitorSet>,
    any_task: MonitorSet,
    every_step: MonitorSet,
    /// True if a monitor that is alone is filed by its comparison too: more memory, and less time for each sample.
    narrowing: bool,
}

/// Monitors of samples of one variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Watchers {
    /// Monitors that must receive every sample. A monitor that is alone is filed here, whatever it compares.
    every: MonitorSet,
    /// Monitors that must receive only samples on their side of a bound.
    thresholds: Option<Box<Thresholds>>,
    /// Monitors that need not receive samples that leave their episodes undecided.
    episodes: Option<Box<EpisodeIndex>>,
}

/// Monitors of messages that begin with one word, divided further by the second word if known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct HeadInterests {
    general: MonitorSet,
    by_second: BTreeMap<Value, MonitorSet>,
}

/// Further facts about a monitor, so that fewer stimuli reach it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Narrowed<'a> {
    /// The second word of the messages that the monitor waits for.
    pub second: Option<&'a Value>,
    /// The comparison that a sample must satisfy to satisfy the monitor.
    pub threshold: Option<Threshold>,
}

/// Returns true if messages can be divided by the value: values with several equal notations (numbers, strings) cannot divide them.
fn divides(second: &Value) -> bool {
    matches!(second, Value::Symbol(_) | Value::Integer(_) | Value::Task(_))
}

fn second_word(form: &Value) -> Option<&Value> {
    form.as_list().and_then(|items| items.get(1))
}

fn drop_from<K: Ord>(map: &mut BTreeMap<K, MonitorSet>, key: &K, monitor: MonitorId) {
    if let Some(set) = map.get_mut(key) {
        set.remove(monitor);
        if set.is_empty() {
            map.remove(key);
        }
    }
}

impl Watchers {
    fn is_empty(&self) -> bool {
        self.every.is_empty() && self.thresholds.is_none() && self.episodes.is_none()
    }

    fn insert(&mut self, threshold: Option<Threshold>, alone_too: bool, monitor: MonitorId) {
        match threshold {
            Some(threshold) if alone_too || !self.every.is_empty() || self.thresholds.is_some() => {
                self.thresholds.get_or_insert_default().insert(threshold, monitor);
            }
            _ => self.every.insert(monitor),
        }
    }

    fn remove(&mut self, threshold: Option<Threshold>, monitor: MonitorId) {
        if self.every.remove(monitor) {
            return;
        }
        if let (Some(threshold), Some(thresholds)) = (threshold, &mut self.thresholds) {
            thresholds.remove(threshold, monitor);
            if thresholds.is_empty() {
                self.thresholds = None;
            }
        }
    }
}

impl Interests {
    /// Returns an empty collection that also files monitors by thresholds, for few variables with many samples.
    pub fn narrowing() -> Interests {
        Interests { narrowing: true, ..Interests::default() }
    }

    /// Files `monitor` under `interest`, narrowed by what else is known about it.
    pub fn insert(&mut self, interest: &Interest, narrowed: Narrowed<'_>, monitor: MonitorId) {
        match interest {
            Interest::Variable(variable) => {
                self.variables.entry(variable).insert(narrowed.threshold, self.narrowing, monitor)
            }
            Interest::Attribute(attribute) => self.attributes.entry(attribute.clone()).or_default().insert(monitor),
            Interest::EventHead(head) => {
                let entry = self.heads.entry(head.clone()).or_default();
                match narrowed.second.filter(|second| divides(second)) {
                    Some(second) => entry.by_second.entry(second.clone()).or_default().insert(monitor),
                    None => entry.general.insert(monitor),
                }
            }
            Interest::AnyEvent => self.any_event.insert(monitor),
            Interest::Task(task) => self.tasks.entry(*task).or_default().insert(monitor),
            Interest::AnyTask => self.any_task.insert(monitor),
            Interest::EveryStep => self.every_step.insert(monitor),
        };
    }

    /// Removes `monitor` from `interest`; `narrowed` is the value with which it was filed.
    pub fn remove(&mut self, interest: &Interest, narrowed: Narrowed<'_>, monitor: MonitorId) {
        match interest {
            Interest::Variable(variable) => {
                let Some(watchers) = self.variables.get_mut(variable) else { return };
                watchers.remove(narrowed.threshold, monitor);
                if watchers.is_empty() {
                    self.variables.remove(variable);
                }
            }
            Interest::Attribute(attribute) => drop_from(&mut self.attributes, attribute, monitor),
            Interest::EventHead(head) => self.remove_head(head, narrowed.second, monitor),
            Interest::AnyEvent => {
                self.any_event.remove(monitor);
            }
            Interest::Task(task) => drop_from(&mut self.tasks, task, monitor),
            Interest::AnyTask => {
                self.any_task.remove(monitor);
            }
            Interest::EveryStep => {
                self.every_step.remove(monitor);
            }
        }
    }

    fn remove_head(&mut self, head: &Symbol, second: Option<&Value>, monitor: MonitorId) {
        let Some(entry) = self.heads.get_mut(head) else { return };
        match second.filter(|second| divides(second)) {
            Some(second) => drop_from(&mut entry.by_second, second, monitor),
            None => {
                entry.general.remove(monitor);
            }
        }
        if entry.general.is_empty() && entry.by_second.is_empty() {
            self.heads.remove(head);
        }
    }

    /// Finds the monitors that must receive a sample of `variable`. A sample that is not the newest of its variable, or replaces another
    /// one, can undo the effect of an earlier sample: all monitors of the variable then receive it.
    pub fn of_sample(&self, variable: &StateVariable, value: &Value, newest: bool, found: &mut MonitorIds) {
        if let Some(watchers) = self.variables.get(variable) {
            watchers.every.collect_into(found);
            match &watchers.thresholds {
                Some(thresholds) if newest => thresholds.of_value(value, found),
                Some(thresholds) => thresholds.all(found),
                None => {}
            }
        }
        if !self.attributes.is_empty()
            && let Some(set) = self.attributes.get(&variable.attribute)
        {
            set.collect_into(found);
        }
    }

    /// Finds the monitors that must receive a message.
    pub fn of_event(&self, form: &Value, found: &mut MonitorIds) {
        self.any_event.collect_into(found);
        let head = match form {
            Value::Symbol(symbol) => Some(symbol),
            other => other.as_list().and_then(|items| items.first()).and_then(Value::as_symbol),
        };
        let Some(entry) = head.and_then(|head| self.heads.get(head)) else { return };
        entry.general.collect_into(found);
        match second_word(form) {
            Some(second) if divides(second) => {
                if let Some(set) = entry.by_second.get(second) {
                    set.collect_into(found);
                }
            }
            // A message whose second word is another notation of the same value, such as a real for an integer.
            Some(second) if !entry.by_second.is_empty() => {
                let alike = entry.by_second.iter().filter(|(key, _)| key.matches(second));
                alike.for_each(|(_, monitors)| monitors.collect_into(found));
            }
            _ => {}
        }
    }

    /// Finds the monitors that must receive a transition of `task`.
    pub fn of_task(&self, task: TaskId, found: &mut MonitorIds) {
        if let Some(set) = self.tasks.get(&task) {
            set.collect_into(found);
        }
        self.any_task.collect_into(found);
    }

    /// Moves the undecided episode `leaf` into the episode index of its variable; its monitor then no longer receives stimuli that the
    /// episode index can handle. Returns false, and changes nothing, if the episode index cannot watch it.
    pub fn bank(
        &mut self,
        variable: &StateVariable,
        leaf: LeafId,
        wanted: &ThresholdEpisode,
        run: Option<&ObjectRun>,
    ) -> bool {
        let watchers = self.variables.entry(variable);
        let mut fresh = None;
        let bank =
            watchers.episodes.as_mut().unwrap_or_else(|| fresh.insert(Box::new(EpisodeIndex::new(wanted.dimension))));
        let taken = bank.insert(leaf, wanted, run);
        if taken {
            watchers.every.remove(leaf.monitor);
            watchers.episodes = watchers.episodes.take().or(fresh);
        }
        taken
    }

    /// Returns the undecided threshold episodes of a variable.
    pub fn episodes(&self, variable: &StateVariable) -> Option<&EpisodeIndex> {
        self.variables.get(variable)?.episodes.as_deref()
    }

    /// Returns true if no monitor watches the variable.
    pub fn ignore_variable(&self, variable: &StateVariable) -> bool {
        self.attributes.is_empty() && self.ignore_steps() && self.variables.get(variable).is_none()
    }

    /// Returns the episode index of a variable, mutably.
    pub fn episodes_mut(&mut self, variable: &StateVariable) -> Option<&mut EpisodeIndex> {
        self.variables.get_mut(variable)?.episodes.as_deref_mut()
    }

    /// Returns the watchers that need not receive every sample of a variable; `None` if one of them must.
    pub fn quiet_watchers(
        &mut self,
        variable: &StateVariable,
    ) -> Option<(Option<&Thresholds>, Option<&mut EpisodeIndex>)> {
        let of_attribute = self.attributes.get(&variable.attribute).is_some_and(|set| !set.is_empty());
        if of_attribute || !self.ignore_steps() {
            return None;
        }
        let Some(watchers) = self.variables.get_mut(variable) else { return Some((None, None)) };
        watchers.every.is_empty().then_some((watchers.thresholds.as_deref(), watchers.episodes.as_deref_mut()))
    }

    /// Drops the episode index of a variable if it is empty.
    pub fn drop_empty_bank(&mut self, variable: &StateVariable) {
        let Some(watchers) = self.variables.get_mut(variable) else { return };
        watchers.episodes.take_if(|bank| bank.is_empty());
        if watchers.is_empty() {
            self.variables.remove(variable);
        }
    }

    /// Returns true if no monitor is judged at every instant at which an event happens.
    pub fn ignore_steps(&self) -> bool {
        self.every_step.is_empty()
    }

    /// Finds the monitors that are judged at every instant at which an event happens.
    pub fn of_every_step(&self, found: &mut MonitorIds) {
        self.every_step.collect_into(found);
    }

    /// Returns true if no monitor must receive transitions of `task`.
    pub fn ignore_task(&self, task: TaskId) -> bool {
        self.any_task.is_empty() && !self.tasks.contains_key(&task)
    }
}

//! Messages that arrive while a repeating step is busy: its next repetitions answer them.

use crate::state::histories::history::Occurrence;
use crate::state::monitors::monitor::Interest;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Messages that one repeating step waits for, and those that it has received.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Listener {
    /// The first words of the messages; `None` for all messages.
    heads: Option<BTreeSet<Symbol>>,
    /// True if the step is busy: its `waitfor` is then not watched.
    busy: bool,
    /// Messages without an answer, in order of arrival.
    heard: VecDeque<Occurrence>,
    /// True if messages were dropped because there were more than the limit, and that was reported.
    overflowed: bool,
}

/// The repeating steps of an agent that are or were busy, with the messages that wait for them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Listening {
    tasks: BTreeMap<TaskId, Listener>,
}

impl Listening {
    /// Returns true if no task listens.
    pub fn is_empty(&self) -> bool {
        self.tasks.is_empty()
    }

    /// Returns true if the task listens or has listened.
    pub fn knows(&self, task: TaskId) -> bool {
        self.tasks.contains_key(&task)
    }

    /// Marks the task as busy. Messages up to `answered`, in order of time and arrival, are answered or skipped; `also` are messages of
    /// this instant that are not answered.
    pub fn begin<'a>(
        &mut self,
        task: TaskId,
        interests: impl Iterator<Item = Interest>,
        answered: Option<(Time, u64)>,
        also: impl Iterator<Item = &'a Occurrence>,
    ) {
        let listener = self.tasks.entry(task).or_insert_with(|| {
            let heads: Option<BTreeSet<Symbol>> = interests
                .map(|interest| match interest {
                    Interest::EventHead(head) => Some(head),
                    _ => None,
                })
                .collect();
            Listener { heads, ..Listener::default() }
        });
        listener.busy = true;
        if let Some(answered) = answered {
            listener.heard.retain(|message| (message.at, message.sequence) > answered);
        }
        let newest = listener.heard.back().map(|message| message.sequence);
        let unknown = also.filter(|message| newest.is_none_or(|newest| message.sequence > newest));
        let new: Vec<Occurrence> =
            unknown.filter(|message| concerns(&listener.heads, message.head())).cloned().collect();
        listener.heard.extend(new);
    }

    /// Ends the busy time: the task's `waitfor` is watched again, and its monitor receives messages from now on. Returns the messages
    /// without an answer.
    pub fn end(&mut self, task: TaskId) -> Vec<Occurrence> {
        let Some(listener) = self.tasks.get_mut(&task) else { return Vec::new() };
        listener.busy = false;
        let mut heard: Vec<Occurrence> = listener.heard.iter().cloned().collect();
        heard.sort_by_key(|message| message.at);
        heard
    }

    /// Removes a task that is no longer repeated.
    pub fn forget(&mut self, task: TaskId) {
        self.tasks.remove(&task);
    }

    /// Records that the message was evidence for the task itself or for a task below it: no repetition answers it.
    pub fn answered(&mut self, task: TaskId, sequence: u64) {
        if let Some(listener) = self.tasks.get_mut(&task) {
            listener.heard.retain(|message| message.sequence != sequence);
        }
    }

    /// Keeps a message; at most `most` are kept for one task. Returns the tasks that dropped a message for the first time.
    pub fn hear(&mut self, message: &Occurrence, most: usize) -> Vec<TaskId> {
        let mut dropping = Vec::new();
        let head = message.head();
        for (task, listener) in self.tasks.iter_mut().filter(|(_, each)| each.busy && concerns(&each.heads, head)) {
            listener.heard.push_back(message.clone());
            if listener.heard.len() > most {
                listener.heard.pop_front();
                if !std::mem::replace(&mut listener.overflowed, true) {
                    dropping.push(*task);
                }
            }
        }
        dropping
    }
}

fn concerns(heads: &Option<BTreeSet<Symbol>>, head: Option<&Symbol>) -> bool {
    heads.as_ref().is_none_or(|heads| head.is_some_and(|head| heads.contains(head)))
}

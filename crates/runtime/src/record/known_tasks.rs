//! The tasks of a record as rows, and in the form that a reader keeps.

use crate::method_detail::MethodDetail;
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::collections::BTreeMap;

/// A task with its method, end and outcome.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskRow {
    /// The task.
    pub id: TaskId,
    /// Its parent.
    pub parent: Option<TaskId>,
    /// The step's tag.
    pub tag: String,
    /// Its goal, as known last.
    pub goal: String,
    /// Instant of its creation.
    pub created: Time,
    /// Instant of its end, if it has ended.
    pub ended: Option<Time>,
    /// A word of `apex_model::task::OUTCOME_WORDS`, if it has ended.
    pub outcome: Option<String>,
    /// Its method, if one was selected.
    pub method: Option<MethodDetail>,
    /// `file:line:column` of its step.
    pub place: Option<String>,
}

/// The tasks up to an effect, kept with a reader and grown with the record.
#[derive(Default)]
pub(super) struct KnownTasks {
    /// Place after the last effect that was read.
    pub(super) read_to: usize,
    /// By number.
    pub(super) tasks: BTreeMap<u64, TaskRow>,
}

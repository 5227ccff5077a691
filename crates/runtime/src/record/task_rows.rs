//! The tasks of a record, with everything that became of them.

use super::effect_access::Effects;
use super::effects::EffectKind;
use super::reader::RecordReader;
use crate::error::RecordError;
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use std::collections::BTreeMap;

/// A task with everything that became of it.
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
    /// `success`, `failure` or `cut`, if it has ended.
    pub outcome: Option<String>,
    /// `procedure file.pdl:3:1`, if one was selected.
    pub method: Option<String>,
    /// `file:line:column` of its step.
    pub place: Option<String>,
}

impl TaskRow {
    /// Returns a task as it was created; `None` for another decision.
    fn created(id: u64, at: Time, decision: &Decision, effects: &Effects<'_>) -> Option<TaskRow> {
        let DecisionKind::Created { parent, tag, goal, .. } = &decision.kind else { return None };
        Some(TaskRow {
            id: TaskId(id),
            parent: *parent,
            tag: tag.to_string(),
            goal: goal.to_string(),
            created: at,
            ended: None,
            outcome: None,
            method: None,
            place: effects.place(decision),
        })
    }
}

impl RecordReader {
    /// Returns all tasks, oldest first.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn tasks(&self) -> Result<Vec<TaskRow>, RecordError> {
        let mut tasks: BTreeMap<u64, TaskRow> = BTreeMap::new();
        let effects = self.effects()?;
        effects.scan(0..effects.table.len(), EffectKind::wanted_of_tasks, |found| {
            let Some(id) = found.task else { return Ok(()) };
            match (&found.effect, tasks.get_mut(&id)) {
                (None, Some(task)) => {
                    task.ended = (found.kind.to == Some(TaskState::Terminated)).then_some(found.at);
                    task.outcome = found.kind.outcome.map(str::to_owned);
                }
                (Some(Effect::Decided(decision)), known) => match (&decision.kind, known) {
                    (DecisionKind::Created { .. }, _) => {
                        tasks.extend(TaskRow::created(id, found.at, decision, &effects).map(|task| (id, task)));
                    }
                    (DecisionKind::Selected { method, goal, .. }, Some(task)) => {
                        (task.goal, task.method) = (goal.to_string(), Some(effects.method(method)));
                    }
                    _ => {}
                },
                _ => {}
            }
            Ok(())
        })?;
        Ok(tasks.into_values().collect())
    }
}

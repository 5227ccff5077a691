//! The tasks of a record, with their methods, ends and outcomes.

use super::effect_access::Effects;
use super::effects::EffectKind;
use super::known_tasks::{KnownTasks, TaskRow};
use super::reader::RecordReader;
use crate::error::RecordError;
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use std::sync::PoisonError;

impl TaskRow {
    /// Returns a task as created by `decision`; `None` for another decision.
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

impl KnownTasks {
    /// Reads the effects that were written since the last call.
    fn refresh(&mut self, effects: &Effects<'_>) -> Result<(), RecordError> {
        let KnownTasks { read_to, tasks } = self;
        let end = effects.table.len();
        effects.scan(*read_to..end, EffectKind::wanted_of_tasks, |found| {
            let Some(id) = found.task else { return Ok(()) };
            match (&found.effect, tasks.get_mut(&id)) {
                (None, Some(task)) => {
                    task.ended = (found.kind.to == Some(TaskState::Terminated)).then_some(found.at);
                    task.outcome = found.kind.outcome.map(str::to_owned);
                }
                (Some(Effect::Decided(decision)), known) => match (&decision.kind, known) {
                    (DecisionKind::Created { .. }, _) => {
                        tasks.extend(TaskRow::created(id, found.at, decision, effects).map(|task| (id, task)));
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
        *read_to = end;
        Ok(())
    }
}

impl RecordReader {
    /// Returns all tasks, oldest first. Each effect is read only once, however often this is called.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn tasks(&self) -> Result<Vec<TaskRow>, RecordError> {
        let effects = self.effects()?;
        let mut known = self.known_tasks.lock().unwrap_or_else(PoisonError::into_inner);
        known.refresh(&effects).inspect_err(|_| *known = KnownTasks::default())?;
        Ok(known.tasks.values().cloned().collect())
    }
}

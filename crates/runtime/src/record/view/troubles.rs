//! Failures, interruptions and faults: the entries of the trouble rail. (english: allow)

use super::RecordView;
use super::trouble_index::{Trouble, TroubleIndex, TroubleKind}; // english: allow
use crate::error::RecordError;
use serde::Serialize;

/// Maximum number of entries of an answer; the latest are kept.
const TROUBLES_MAX: usize = 500;

/// Failures, interruptions and faults up to an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Troubles {
    /// By time.
    pub troubles: Vec<Trouble>,
    /// Number of older entries that the limit leaves out.
    pub left_out: usize,
}

impl RecordView {
    /// Returns the entries up to mission time `at_ns` (nanoseconds; none means the record's end).
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn troubles(&mut self, at_ns: Option<i64>) -> Result<Troubles, RecordError> {
        let mission = self.mission(at_ns)?;
        let targets = self.targets(at_ns)?.targets;
        let until = at_ns.unwrap_or(i64::MAX);
        let index = self.current(&self.indexes.faults, TroubleIndex::read_to, TroubleIndex::refresh)?;
        let mut troubles = index.until(until).to_vec();
        drop(index);
        self.name_handlers(&mut troubles, until)?;
        self.name_targets(&mut troubles)?;
        for target in targets {
            let mut before = None;
            for change in target.history {
                if change.state == "skipped" && before.as_deref() != Some("skipped") {
                    troubles.push(Trouble {
                        t_ns: change.t_ns,
                        kind: TroubleKind::LeftOut,
                        subject: target.name.clone(),
                        cause: change.detail.unwrap_or_default(),
                        task: None,
                        failed_child: None,
                        handler_task: None,
                        handler: None,
                        place: None,
                        target: Some(target.id.clone()),
                        targets: Vec::new(),
                        cause_kind: None,
                    });
                }
                before = Some(change.state);
            }
        }
        if let Some(ending) = mission.ending.filter(|ending| ending.failed) {
            let (subject, t_ns) = ("the flight".to_owned(), mission.growth.end_ns);
            troubles.push(Trouble {
                t_ns,
                kind: TroubleKind::Ended,
                subject,
                cause: ending.reason,
                task: None,
                failed_child: None,
                handler_task: None,
                handler: None,
                place: None,
                target: None,
                targets: Vec::new(),
                cause_kind: None,
            });
        }
        // A stable sort: entries of one instant keep the order of the effects.
        troubles.sort_by_key(|trouble| trouble.t_ns);
        let left_out = troubles.len().saturating_sub(TROUBLES_MAX);
        troubles.drain(..left_out);
        Ok(Troubles { troubles, left_out })
    }

    /// Sets the goals of the tasks that handle failures, as known at `until`.
    fn name_handlers(&mut self, entries: &mut [Trouble], until: i64) -> Result<(), RecordError> {
        if entries.iter().all(|entry| entry.handler_task.is_none()) {
            return Ok(());
        }
        let tasks = self.tasks_index()?;
        for entry in entries {
            let handler = entry.handler_task.and_then(|task| tasks.get(task));
            entry.handler = handler.map(|task| task.goal_at(until).to_owned());
        }
        Ok(())
    }
    /// Sets the targets that the goals of the tasks concerned name, as known at each entry's instant.
    fn name_targets(&self, entries: &mut [Trouble]) -> Result<(), RecordError> {
        let names = self.target_names()?;
        if names.is_empty() {
            return Ok(());
        }
        let tasks = self.tasks_index()?;
        for entry in entries {
            let goal = entry.task.and_then(|task| tasks.get(task)?.known_goal(entry.t_ns));
            entry.targets = goal.map(|goal| goal.targets(&names)).unwrap_or_default();
        }
        Ok(())
    }
}

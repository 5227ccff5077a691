//! The holders of resources over time, kept in memory and grown with the record.

use super::index::task_number;
use apex_model::cause::Cause;
use apex_model::effect::{DecisionKind, Effect};
use apex_model::task::TaskState;
use rusqlite::Connection;
use std::collections::BTreeMap;

/// All holdings, kept in memory and grown with the record. Bound: each transition is read once.
#[derive(Default)]
pub(super) struct HoldingIndex {
    seen_effect: i64,
    /// Number of the last effect that was read or skipped.
    read_to: i64,
    resources: Vec<(String, Vec<Held>)>,
    /// Places in `resources` of what a task holds.
    held: BTreeMap<u64, Vec<(usize, usize)>>,
}

/// A stretch of time in which a task holds a share of a resource; none while it still does.
#[derive(Clone)]
pub(super) struct Held {
    pub(super) task: u64,
    pub(super) amount: Option<String>,
    pub(super) from_ns: i64,
    pub(super) to_ns: Option<i64>,
}

impl HoldingIndex {
    /// The resources in the order of their first holding, each with its holdings by begin.
    pub(super) fn resources(&self) -> &[(String, Vec<Held>)] {
        &self.resources
    }

    /// Returns the number of the last effect that was read or skipped.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Reads the rows that were written since the last call, up to effect `last`.
    pub(super) fn refresh(&mut self, connection: &Connection, last: i64) -> rusqlite::Result<()> {
        let sql = "SELECT id, t_ns, task, to_state, body FROM effect WHERE id > ?1 AND id <= ?2 AND kind = 'transition' ORDER BY id";
        let mut statement = connection.prepare_cached(sql)?;
        let mut rows = statement.query([self.seen_effect.max(self.read_to), last])?;
        while let Some(row) = rows.next()? {
            self.seen_effect = row.get(0)?;
            let at_ns: i64 = row.get(1)?;
            let Some(task) = task_number(row, 2)? else { continue };
            // Leaving the state gives everything back.
            for (resource, place) in self.held.remove(&task).unwrap_or_default() {
                let slot = self.resources.get_mut(resource).and_then(|(_, list)| list.get_mut(place));
                if let Some(held) = slot {
                    held.to_ns = Some(at_ns);
                }
            }
            if row.get::<_, Option<String>>(3)?.as_deref() == Some("ongoing") {
                let body: Vec<u8> = row.get(4)?;
                self.grant(task, at_ns, &body);
            }
        }
        self.read_to = self.read_to.max(last);
        Ok(())
    }

    /// Keeps what a transition to `ongoing` granted. The row of another version says nothing.
    fn grant(&mut self, task: u64, at_ns: i64, body: &[u8]) {
        let Ok(Effect::Decided(decision)) = postcard::from_bytes(body) else { return };
        let DecisionKind::Transition { to: TaskState::Ongoing, .. } = decision.kind else { return };
        let Cause::ResourcesGranted { resources } = decision.because.cause else { return };
        for share in resources {
            let name = share.resource.to_string();
            let index = self.resources.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
                self.resources.push((name, Vec::new()));
                self.resources.len() - 1
            });
            let Some((_, list)) = self.resources.get_mut(index) else { continue };
            let amount = share.amount.map(|amount| amount.to_string());
            list.push(Held { task, amount, from_ns: at_ns, to_ns: None });
            self.held.entry(task).or_default().push((index, list.len() - 1));
        }
    }
}

//! Which task held which resource when, from the decisions that granted it.

use super::RecordView;
use super::index::task_number;
use crate::error::RecordError;
use apex_model::cause::Cause;
use apex_model::effect::{DecisionKind, Effect};
use apex_model::task::TaskState;
use rusqlite::Connection;
use serde::Serialize;
use std::collections::BTreeMap;

/// Holdings of one resource that one answer holds; the others are counted.
const HOLDINGS_MAX: usize = 500;

/// The resources of an agent, and who held them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Holdings {
    /// One row for each resource that any task has held by then, in the order of the first holding.
    pub resources: Vec<ResourceRow>,
}

/// A resource over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ResourceRow {
    /// The resource, as written in PDL.
    pub resource: String,
    /// Stretches of time in which a task held it, by begin.
    pub holdings: Vec<Holding>,
    /// Earlier stretches in the window that are left out.
    pub left_out: usize,
}

/// A stretch of time in which a task held a resource, or a share of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Holding {
    /// The task's number.
    pub task: u64,
    /// The share that it held; none is all of it.
    pub amount: Option<String>,
    /// Begin, nanoseconds of mission time.
    pub from_ns: i64,
    /// End, nanoseconds of mission time; that of the answer while it is held.
    pub to_ns: i64,
    /// True while it is held.
    pub open: bool,
}

/// All holdings, kept in memory and grown with the record. Bound: each transition is read once.
#[derive(Default)]
pub(super) struct HoldingIndex {
    seen_effect: i64,
    resources: Vec<(String, Vec<Held>)>,
    /// Places in `resources` of what a task holds.
    held: BTreeMap<u64, Vec<(usize, usize)>>,
}

#[derive(Clone)]
struct Held {
    task: u64,
    amount: Option<String>,
    from_ns: i64,
    to_ns: Option<i64>,
}

impl HoldingIndex {
    pub(super) fn refresh(&mut self, connection: &Connection) -> rusqlite::Result<()> {
        let sql = "SELECT id, t_ns, task, to_state, body FROM effect WHERE id > ?1 AND kind = 'transition' ORDER BY id";
        let mut statement = connection.prepare_cached(sql)?;
        let mut rows = statement.query([self.seen_effect])?;
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

impl RecordView {
    /// Who held which resource in the window `from_ns ..= to_ns`, as known at `at_ns` (nanoseconds of mission time; none means
    /// the record's end).
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn holdings(
        &mut self,
        (from_ns, to_ns): (Option<i64>, Option<i64>),
        at_ns: Option<i64>,
    ) -> Result<Holdings, RecordError> {
        let end_ns = self.reader.span()?.map_or(0, |(_, end)| end.0);
        let at_ns = at_ns.unwrap_or(i64::MAX).min(end_ns);
        let (from_ns, to_ns) = (from_ns.unwrap_or(i64::MIN), to_ns.unwrap_or(i64::MAX).min(at_ns));
        let refreshed = self.holdings.refresh(&self.reader.connection);
        refreshed.map_err(|error| self.reader.damaged("the holders of resources", error))?;
        let known = |list: &Vec<Held>| list.first().is_some_and(|first| first.from_ns <= at_ns);
        let row = |(resource, list): &(String, Vec<Held>)| {
            let shown = |held: &Held| {
                let ended = held.to_ns.filter(|to| *to <= at_ns);
                let (to_held_ns, open) = (ended.unwrap_or(at_ns), ended.is_none());
                (held.from_ns <= to_ns && to_held_ns >= from_ns).then(|| Holding {
                    task: held.task,
                    amount: held.amount.clone(),
                    from_ns: held.from_ns,
                    to_ns: to_held_ns,
                    open,
                })
            };
            let mut holdings: Vec<Holding> = list.iter().filter_map(shown).collect();
            let left_out = holdings.len().saturating_sub(HOLDINGS_MAX);
            holdings.drain(..left_out);
            ResourceRow { resource: resource.clone(), holdings, left_out }
        };
        let resources = self.holdings.resources.iter().filter(|(_, list)| known(list)).map(row).collect();
        Ok(Holdings { resources })
    }
}

//! Holders of resources over time, from the decisions that granted them.

use super::RecordView;
use super::holding_index::{Held, HoldingIndex};
use crate::error::RecordError;
use serde::Serialize;

/// Maximum number of holdings of one resource in one answer; the others are counted.
const HOLDINGS_MAX: usize = 500;

/// The resources of an agent with their holders.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Holdings {
    /// One row for each resource that any task has held by the instant, in the order of the first holding.
    pub resources: Vec<ResourceRow>,
}

/// A resource over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ResourceRow {
    /// The resource, as written in PDL.
    pub resource: String,
    /// Spans of time in which a task held the resource, by beginning.
    pub holdings: Vec<Holding>,
    /// Number of earlier holdings in the window that are left out.
    pub left_out: usize,
}

/// A span of time in which a task held a resource, or a share of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Holding {
    /// The task's number.
    pub task: u64,
    /// The share that it held; `None` for the whole resource.
    pub amount: Option<String>,
    /// Begin in nanoseconds of mission time.
    pub from_ns: i64,
    /// End in nanoseconds of mission time; that of the answer if it is still held.
    pub to_ns: i64,
    /// True while it is held.
    pub open: bool,
}

impl RecordView {
    /// Returns the holders of resources in the window `from_ns ..= to_ns`, as known at `at_ns` (nanoseconds of mission time; `None`:
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
        let index = self.current(&self.indexes.holdings, HoldingIndex::read_to, HoldingIndex::refresh)?;
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
        let resources = index.resources().iter().filter(|(_, list)| known(list)).map(row).collect();
        Ok(Holdings { resources })
    }
}

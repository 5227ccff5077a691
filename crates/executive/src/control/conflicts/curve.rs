//! Priorities as functions of time (TC)
//! What: splits a task's priority into constant parts, parts that rise with urgency, and other parts, for many evaluations.
//! Runs: contend phase, for claimants that were refused.  Reads: priority clauses, ancestors, workload.  Writes: nothing.
//! Bound: O(clauses) an evaluation; a constant clause is evaluated once.  PDL: `priority`, section 9.
//! Paper: section III, priority of competitors.

use crate::control::conflicts::priority::{self, PriorityChange};
use crate::control::conflicts::value_intervals::Bounds;
use crate::state::agent::Agent;
use crate::state::task::Task;
use apex_model::procedure::PriorityClause;
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::cell::Cell;

/// The priority of a task while nothing but time passes: the greatest of its parts.
pub(crate) struct Curve<'a> {
    agent: &'a Agent,
    /// The task.
    pub(crate) id: TaskId,
    /// Present value.
    pub(crate) value_now: f64,
    /// The greatest of the constant parts; 0 for a task without any clause, as in [`priority::priority`].
    steady: Option<f64>,
    rises: Vec<RisingTerm>,
    others: Vec<(&'a Task, &'a PriorityClause)>,
    /// The bounds of the last evaluated span: each span is evaluated for many contests.
    last: Cell<Option<(Time, Time, Bounds)>>,
}

/// A part that rises until `due` and is constant afterwards.
#[derive(Clone, Copy)]
pub(crate) struct RisingTerm {
    /// From 0 to 10.
    pub(crate) importance: f64,
    /// Instant of its greatest urgency.
    pub(crate) due: Time,
}

impl<'a> Curve<'a> {
    /// Returns the curve of `id` as seen now.
    pub(crate) fn new(agent: &'a Agent, id: TaskId, now: Time) -> Curve<'a> {
        let value_now = priority::priority(agent, id, now);
        let (steady, rises, others) = (None, Vec::new(), Vec::new());
        let mut curve = Curve { agent, id, value_now, steady, rises, others, last: Cell::new(None) };
        for (task, clause) in priority::clauses_that_count(agent, id) {
            match priority::kind(agent, task, clause, now) {
                PriorityChange::Absent => {}
                PriorityChange::Steady(value) => {
                    curve.steady = Some(curve.steady.map_or(value, |before| before.max(value)))
                }
                PriorityChange::Rising(rise) => curve.rises.push(rise),
                PriorityChange::Other => curve.others.push((task, clause)),
            }
        }
        if curve.rises.is_empty() && curve.others.is_empty() {
            curve.steady = curve.steady.or(Some(0.0));
        }
        curve
    }

    /// Returns true if the priority changes with time.
    pub(crate) fn moves(&self) -> bool {
        !self.rises.is_empty() || !self.others.is_empty()
    }

    /// Returns true if the priority is constant from `at` on.
    pub(crate) fn is_settled(&self, at: Time) -> bool {
        self.others.is_empty() && self.rises.iter().all(|rise| rise.due <= at)
    }

    /// Returns bounds of the value between `from` and `to`.
    pub(crate) fn bounds(&self, from: Time, to: Time) -> Bounds {
        if let Some((.., bounds)) = self.last.get().filter(|last| (last.0, last.1) == (from, to)) {
            return bounds;
        }
        let steady = self.steady.map(|value| Bounds { low: value, high: value });
        let at = |rise: &RisingTerm, at| priority::risen(self.agent, *rise, at);
        let rises = self.rises.iter().map(|rise| Bounds { low: at(rise, from), high: at(rise, to) });
        let others = self.others.iter();
        let others = others.filter_map(|(task, clause)| priority::clause_bounds(self.agent, task, clause, from, to));
        let all = steady.into_iter().chain(rises).chain(others).reduce(Bounds::greater);
        let bounds = all.unwrap_or(Bounds { low: 0.0, high: 0.0 });
        self.last.set(Some((from, to, bounds)));
        bounds
    }

    /// Returns true if this curve can never be above `other` from `now` on: each of its parts stays below a constant or rising part of
    /// `other`. Bounds alone cannot separate two steps of one kind with different creation times; this comparison can.
    pub(crate) fn never_exceeds(&self, other: &Curve<'_>, now: Time) -> bool {
        let kept = other.rises.iter().map(|rise| priority::risen(self.agent, *rise, now)).chain(other.steady);
        let Some(kept) = kept.reduce(f64::max) else { return false };
        let below = |rise: &RisingTerm| {
            let behind = |each: &RisingTerm| rise.importance <= each.importance && rise.due >= each.due;
            priority::risen(self.agent, *rise, rise.due) <= kept || other.rises.iter().any(behind)
        };
        self.others.is_empty() && self.steady.is_none_or(|value| value <= kept) && self.rises.iter().all(below)
    }
}

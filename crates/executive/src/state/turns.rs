//! Turns: claimants of a resource, taken from all its queues in the order of arbitration.

use crate::state::queue_place::{Among, FamilyOrder, QueueKey};
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::collections::{BTreeSet, btree_set};
use std::iter::Peekable;
use std::ops::Bound;

/// Claimants in the order of their turns.
pub struct InTurn<'a, F> {
    lines: Vec<QueuePrefix<'a>>,
    risen_to: F,
    now: Time,
    /// Claimants that had their turn, if a claimant can have several places: only the first place counts.
    taken: Option<BTreeSet<TaskId>>,
}

/// A queue, with the state of the pass through it.
pub(super) struct QueuePrefix<'a> {
    next: Option<QueueKey>,
    rest: Rest<'a>,
}

/// The remaining claimants of a queue.
pub(super) enum Rest<'a> {
    Steady {
        all: &'a BTreeSet<QueueKey>,
        rest: btree_set::Range<'a, QueueKey>,
    },
    Rising {
        importance: f64,
        risen: Peekable<btree_set::Iter<'a, Among>>,
        /// Claimants that reached the greatest urgency since the queue was last inspected.
        caught_up: Peekable<std::vec::IntoIter<(Time, Among)>>,
        rising: btree_set::Iter<'a, (Time, bool, FamilyOrder)>,
    },
}

impl<'a> Rest<'a> {
    /// Returns the claimants of a queue whose places do not change with time.
    pub(super) fn steady(all: &'a BTreeSet<QueueKey>) -> Rest<'a> {
        Rest::Steady { all, rest: all.range(..) }
    }
}

/// Claimants in the order of their turns, also while their priorities rise.
pub trait TurnSource {
    /// The next claimant.
    fn next(&mut self) -> Option<QueueKey>;
    /// Skips all claimants up to and including this place.
    fn skip_to(&mut self, position: QueueKey);
    /// The next claimant of each queue.
    fn heads(&self) -> Vec<QueueKey>;
    /// Skips claimants that do not count now, and returns the next claimant of each queue.
    fn heads_that(&mut self, counts: &dyn Fn(TaskId) -> bool) -> Vec<QueueKey>;
}

impl<F: Fn(f64, Time) -> f64> TurnSource for InTurn<'_, F> {
    fn next(&mut self) -> Option<QueueKey> {
        Iterator::next(self)
    }

    fn skip_to(&mut self, position: QueueKey) {
        for index in 0..self.lines.len() {
            if let Some(QueuePrefix { rest: Rest::Steady { all, rest }, next: Some(next) }) = self.lines.get_mut(index)
                && *next <= position
            {
                *rest = all.range((Bound::Excluded(position), Bound::Unbounded));
                self.advance(index);
            }
            while self.lines.get(index).is_some_and(|line| line.next.is_some_and(|next| next <= position)) {
                self.advance(index);
            }
        }
    }

    fn heads(&self) -> Vec<QueueKey> {
        InTurn::heads(self).collect()
    }

    fn heads_that(&mut self, counts: &dyn Fn(TaskId) -> bool) -> Vec<QueueKey> {
        for index in 0..self.lines.len() {
            while self.lines.get(index).is_some_and(|line| line.next.is_some_and(|next| !counts(next.task()))) {
                self.advance(index);
            }
        }
        InTurn::heads(self).collect()
    }
}

impl<'a, F: Fn(f64, Time) -> f64> InTurn<'a, F> {
    pub(super) fn new(lines: Vec<Rest<'a>>, several: bool, risen_to: F, now: Time) -> InTurn<'a, F> {
        let lines: Vec<QueuePrefix<'a>> = lines.into_iter().map(|rest| QueuePrefix { next: None, rest }).collect();
        let mut result = InTurn { lines, risen_to, now, taken: several.then(BTreeSet::new) };
        for index in 0..result.lines.len() {
            result.advance(index);
        }
        result
    }

    /// Returns the next claimant of each queue.
    pub fn heads(&self) -> impl Iterator<Item = QueueKey> + '_ {
        self.lines.iter().filter_map(|line| line.next)
    }

    fn advance(&mut self, index: usize) {
        let (now, risen_to) = (self.now, &self.risen_to);
        let Some(line) = self.lines.get_mut(index) else { return };
        line.next = match &mut line.rest {
            Rest::Steady { rest, .. } => rest.next().copied(),
            Rest::Rising { importance, risen, caught_up, rising } => {
                let key = |due, (waits, order): Among| {
                    let priority = risen_to(*importance, due);
                    QueueKey { priority, rank: None, within: 0.0, begun: !waits, order }
                };
                let older = match (risen.peek(), caught_up.peek()) {
                    (Some(first), Some((_, second))) => *first <= second,
                    (first, _) => first.is_some(),
                };
                // The greatest urgency is equal for all, however long ago it was reached.
                let next = if older { risen.next().map(|among| key(now, *among)) } else { None };
                let next = next.or_else(|| caught_up.next().map(|(due, among)| key(due, among)));
                next.or_else(|| rising.next().map(|(due, waits, order)| key(*due, (*waits, *order))))
            }
        };
    }
}

impl<F: Fn(f64, Time) -> f64> Iterator for InTurn<'_, F> {
    type Item = QueueKey;

    fn next(&mut self) -> Option<QueueKey> {
        loop {
            let heads = self.lines.iter().enumerate().filter_map(|(index, line)| Some((line.next?, index)));
            let (key, index) = heads.min()?;
            self.advance(index);
            if self.taken.as_mut().is_none_or(|taken| taken.insert(key.task())) {
                return Some(key);
            }
        }
    }
}

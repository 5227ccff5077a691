//! Turns: claimants of a resource, taken from all its queues in the order in which they come before the arbiter.

use crate::state::queue_place::{Among, FamilyOrder, QueueKey};
use apex_model::time::Time;
use std::collections::btree_set;
use std::iter::Peekable;

/// Claimants in the order of their turns.
pub struct InTurn<'a, F> {
    lines: Vec<QueuePrefix<'a>>,
    risen_to: F,
    now: Time,
}

/// A queue, as far as it was gone through.
pub(super) struct QueuePrefix<'a> {
    next: Option<QueueKey>,
    rest: Rest<'a>,
}

/// The remaining claimants of a queue.
pub(super) enum Rest<'a> {
    Steady(btree_set::Iter<'a, QueueKey>),
    Rising {
        importance: f64,
        risen: Peekable<btree_set::Iter<'a, Among>>,
        /// Those that reached the greatest urgency since the queue was last inspected.
        caught_up: Peekable<std::vec::IntoIter<(Time, Among)>>,
        rising: btree_set::Iter<'a, (Time, bool, FamilyOrder)>,
    },
}

impl<'a, F: Fn(f64, Time) -> f64> InTurn<'a, F> {
    pub(super) fn new(lines: Vec<Rest<'a>>, risen_to: F, now: Time) -> InTurn<'a, F> {
        let lines: Vec<QueuePrefix<'a>> = lines.into_iter().map(|rest| QueuePrefix { next: None, rest }).collect();
        let mut result = InTurn { lines, risen_to, now };
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
            Rest::Steady(rest) => rest.next().copied(),
            Rest::Rising { importance, risen, caught_up, rising } => {
                let key = |due, (waits, order): Among| {
                    let priority = risen_to(*importance, due);
                    QueueKey { priority, rank: None, begun: !waits, order }
                };
                let older = match (risen.peek(), caught_up.peek()) {
                    (Some(first), Some((_, second))) => *first <= second,
                    (first, _) => first.is_some(),
                };
                // The greatest urgency is the same, however long ago it was reached.
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
        let heads = self.lines.iter().enumerate().filter_map(|(index, line)| Some((line.next?, index)));
        let (key, index) = heads.min()?;
        self.advance(index);
        Some(key)
    }
}

//! A queue of claimants whose places depend on themselves alone: constant places, and places that rise with urgency.

use crate::state::queue_place::{Among, FamilyOrder, QueueKey, QueuePlace, RisingKey};
use crate::state::turns::{InTurn, Rest};
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Urgency is greatest from this long before a task is due.
const GREATEST_URGENCY_BEFORE: Duration = Duration(500_000_000);

/// Claimants of one importance, whose priorities rise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct RisingLine {
    /// Claimants whose urgency was below the greatest at the last inspection, the earliest due first.
    rising: BTreeSet<(Time, bool, FamilyOrder)>,
    /// Claimants with the greatest urgency.
    risen: BTreeSet<Among>,
}

/// Claimants in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Queue {
    steady: BTreeSet<QueueKey>,
    /// By the bits of the importance, which order as the importance does.
    lines: BTreeMap<u64, RisingLine>,
    len: usize,
    /// The number of claimants with several places.
    several: usize,
}

impl Queue {
    /// Adds a claimant.
    pub(super) fn enter(&mut self, place: &QueuePlace) {
        self.steady.extend(place.steady);
        for key in &place.rising {
            let line = self.lines.entry(key.importance.to_bits()).or_default();
            line.rising.insert((key.due, !key.begun, key.order));
        }
        self.len += 1;
        self.several += usize::from(place.len() > 1);
    }

    /// Takes a claimant out.
    pub(super) fn leave(&mut self, place: &QueuePlace) {
        if let Some(key) = &place.steady {
            self.steady.remove(key);
        }
        place.rising.iter().for_each(|key| self.leave_line(key));
        self.len -= 1;
        self.several -= usize::from(place.len() > 1);
    }

    fn leave_line(&mut self, key: &RisingKey) {
        let bits = key.importance.to_bits();
        let Some(line) = self.lines.get_mut(&bits) else { return };
        if !line.rising.remove(&(key.due, !key.begun, key.order)) {
            line.risen.remove(&(!key.begun, key.order));
        }
        if line.rising.is_empty() && line.risen.is_empty() {
            self.lines.remove(&bits);
        }
    }

    /// Notes which claimants have reached the greatest urgency.
    pub(super) fn settle(&mut self, now: Time) {
        for line in self.lines.values_mut() {
            while let Some((due, waits, order)) = line.rising.first().copied().filter(|first| has_risen(first.0, now)) {
                line.rising.remove(&(due, waits, order));
                line.risen.insert((waits, order));
            }
        }
    }

    /// The number of claimants.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// True if a priority rises.
    pub(super) fn has_rising(&self) -> bool {
        !self.lines.is_empty()
    }

    /// The first steady place from `key` on.
    pub(super) fn first_from(&self, key: QueueKey) -> Option<&QueueKey> {
        self.steady.range(key..).next()
    }

    /// Returns the claimants in the order of their turns; `risen_to` computes a priority from importance and due instant.
    pub(super) fn in_turn<F: Fn(f64, Time) -> f64>(&self, now: Time, risen_to: F) -> InTurn<'_, F> {
        let mut lines = vec![Rest::steady(&self.steady)];
        for (importance, line) in &self.lines {
            let fresh: Vec<_> = line.rising.iter().take_while(|each| has_risen(each.0, now)).collect();
            let mut rising = line.rising.iter();
            let mut caught_up: Vec<(Time, Among)> = fresh.into_iter().map(|(due, a, b)| (*due, (*a, *b))).collect();
            rising.by_ref().take(caught_up.len()).for_each(drop);
            caught_up.sort_by_key(|(_, among)| *among);
            let (risen, caught_up) = (line.risen.iter().peekable(), caught_up.into_iter().peekable());
            let importance = f64::from_bits(*importance);
            lines.push(Rest::Rising { importance, risen, caught_up, rising });
        }
        InTurn::new(lines, self.several > 0, risen_to, now)
    }
}

fn has_risen(due: Time, now: Time) -> bool {
    due - now <= GREATEST_URGENCY_BEFORE
}

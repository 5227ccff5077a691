//! Rising priorities before gaps (TC)
//! What: names the claimants between which the order of priorities may change first.
//! Runs: contend phase, for `gap_lines`.  Reads: priorities.  Writes: nothing.
//! Bound: O(f log f) for f claimants that take turns.
//! PDL: `priority`, section 9, conflict; decision 0206.  Paper: section III, priority of competitors.
//!
//! While the order by priority stays, each claimant is below the one in front of it. The first change of the order is therefore a crossing
//! of two that follow each other, and all others need not be compared.

use crate::control::conflicts::queues::risen_to;
use crate::control::cycle::Cycle;
use crate::state::queue_place::{QueueKey, QueuePlace, RisingKey};
use std::borrow::Cow;

/// Returns, for each place, the index of the place in front of it by present priority; `None` for the first one and for holders.
/// Returns `None` instead if a priority is not known.
pub(super) fn in_front(
    cycle: &Cycle<'_>,
    places: &[Option<Cow<'_, QueuePlace>>],
    holds: &[bool],
) -> Option<Vec<Option<usize>>> {
    let mut order: Vec<(QueueKey, usize)> = Vec::with_capacity(places.len());
    for (index, place) in places.iter().enumerate() {
        let key = place.as_deref()?.now(risen_to(cycle))?;
        if !holds.get(index).copied().unwrap_or(false) {
            order.push((key, index));
        }
    }
    order.sort_unstable();
    let mut front = vec![None; places.len()];
    for (before, behind) in order.iter().zip(order.iter().skip(1)) {
        if let Some(slot) = front.get_mut(behind.1) {
            *slot = Some(before.1);
        }
    }
    Some(front)
}

/// Returns true if the priorities of all these tasks rise in the same way, so that none of them overtakes another one.
pub(super) fn rise_alike(places: &[Option<Cow<'_, QueuePlace>>]) -> bool {
    let mut first = None;
    places.iter().all(|place| {
        let keys = place.as_deref().map_or(&[][..], |place| place.rising.as_slice());
        let mut alike = |key: &RisingKey| {
            let (importance, due) = *first.get_or_insert((key.importance, key.due));
            key.importance == importance && key.due == due
        };
        !keys.is_empty() && keys.iter().all(&mut alike)
    })
}

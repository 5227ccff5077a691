//! Move that relocates one to three visits to a position nearby.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

/// Greatest distance of a relocation, in visits of the tour.
const REACH: usize = 12;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let from = draw.place();
    let count = 1 + draw.random.below(3).min(draw.random.below(3));
    let steps = 1 + draw.random.below(REACH);
    let back = draw.random.below(2) == 0;
    // Forwards or backwards: some visits are exchanged with the `steps` visits next to them.
    let (left, right) = if back { (steps, count) } else { (count, steps) };
    let middle = from.checked_add(left)?;
    let until = middle + right;
    if until > draw.tour.len() {
        return None;
    }
    let change = Change::cut(from, until).with_all(draw.part(middle, until));
    Some(change.with_all(draw.part(from, middle)))
}

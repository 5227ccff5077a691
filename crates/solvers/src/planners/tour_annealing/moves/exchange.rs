//! Move that exchanges two visits close to each other in the tour.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

/// Greatest distance between the exchanged visits.
const REACH: usize = 12;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let from = draw.place();
    let other = from + 1 + draw.random.below(REACH);
    let (first, last) = (draw.at(from)?, draw.at(other)?);
    let change = Change::cut(from, other + 1).with(last).with_all(draw.part(from + 1, other));
    (first != last).then(|| change.with(first))
}

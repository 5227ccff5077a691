//! Move that removes one or two visits.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let place = draw.place();
    let count = 1 + usize::from(draw.random.below(4) == 0);
    Some(Change::cut(place, (place + count).min(draw.tour.len())))
}

//! Move that reverses a part of the tour.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

/// Longest part.
const LONGEST: usize = 12;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let from = draw.place();
    let until = from + 2 + draw.random.below(LONGEST - 1);
    if until > draw.tour.len() {
        return None;
    }
    Some(Change::cut(from, until).with_all(draw.part(from, until).rev()))
}

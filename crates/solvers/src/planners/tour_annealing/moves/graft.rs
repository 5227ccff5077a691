//! Move that replaces a part of the tour by a copy of another part: a good part of one lap is tried in the next.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

/// Longest part.
const LONGEST: usize = 12;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let (from, source) = (draw.place(), draw.place());
    let taken = 1 + draw.random.below(LONGEST);
    let given = 1 + draw.random.below(LONGEST);
    let until = (from + given).min(draw.tour.len());
    let change = Change::cut(from, until).with_all(draw.part(source, source + taken));
    let same = change.letters().eq(draw.part(from, until));
    (!same).then_some(change)
}

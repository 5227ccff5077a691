//! A part of the tour gives way to a copy of another part: what works in one lap is tried in the next.

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

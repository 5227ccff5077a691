//! Move that prolongs a stay: visits of the same target replace some of the following visits, or none.

use super::Draw;
use crate::planners::tour_annealing::change::{Change, LETTERS_MAX};

/// Maximum number of replaced visits.
const GIVEN_MAX: usize = 12;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let from = draw.place() + 1;
    let letter = draw.at(from - 1)?;
    let most = 1 + draw.random.below(LETTERS_MAX);
    let taken = 1 + draw.random.below(most);
    let given = draw.random.below(GIVEN_MAX + 1);
    let until = (from + given).min(draw.tour.len());
    let change = Change::cut(from, until).with_all(std::iter::repeat_n(letter, taken));
    let same = change.letters().eq(draw.part(from, until));
    (!same).then_some(change)
}

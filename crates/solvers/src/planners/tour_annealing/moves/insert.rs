//! Move that inserts a visit.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let place = draw.random.below(draw.flown + 1);
    let letter = draw.letter(place)?;
    let repeated =
        draw.at(place) == Some(letter) || place.checked_sub(1).and_then(|last| draw.at(last)) == Some(letter);
    (!repeated).then(|| Change::cut(place, place).with(letter))
}

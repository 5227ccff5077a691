//! Move that replaces one visit by a visit to another target.

use super::Draw;
use crate::planners::tour_annealing::change::Change;

pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let place = draw.place();
    let letter = draw.letter(place)?;
    (draw.at(place) != Some(letter)).then(|| Change::cut(place, place + 1).with(letter))
}

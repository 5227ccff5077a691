//! The moves of the search, one per file. Each proposes one change of a tour, or none if it finds no position.

mod exchange;
mod graft;
mod insert;
mod relocate;
mod remove;
mod replace;
mod stay;
mod turn;

use super::change::Change;
use apex_planning::random::Generator;

/// Inputs of a move.
pub(super) struct Draw<'a> {
    /// The tour, including visits beyond the flown ones.
    pub(super) tour: &'a [usize],
    /// Visits that are flown; more than 0.
    pub(super) flown: usize,
    /// Targets that can be observed.
    pub(super) usable: &'a [usize],
    /// By target: the targets nearest to it, itself left out.
    pub(super) near: &'a [Vec<usize>],
    /// Generator of random numbers.
    pub(super) random: &'a mut Generator,
}

impl Draw<'_> {
    /// Returns the index of a random flown visit.
    fn place(&mut self) -> usize {
        self.random.below(self.flown)
    }

    /// Returns the target of the visit at `place`.
    fn at(&self, place: usize) -> Option<usize> {
        self.tour.get(place).copied()
    }

    /// Returns a random target for `place`: with equal probability any target, or one near to the target of the preceding visit.
    fn letter(&mut self, place: usize) -> Option<usize> {
        let beside = place.checked_sub(1).and_then(|before| self.at(before)).or_else(|| self.at(place));
        let near = beside.and_then(|beside| self.near.get(beside)).filter(|near| !near.is_empty());
        match near {
            Some(near) if self.random.below(2) == 0 => near.get(self.random.below(near.len())).copied(),
            _ => self.usable.get(self.random.below(self.usable.len())).copied(),
        }
    }

    /// Returns the visits from `from` to `until`.
    fn part(&self, from: usize, until: usize) -> impl DoubleEndedIterator<Item = usize> + '_ {
        self.tour.get(from..until.min(self.tour.len())).unwrap_or(&[]).iter().copied()
    }
}

/// A move.
type Move = fn(&mut Draw<'_>) -> Option<Change>;

/// All moves; a move that is listed twice is drawn twice as often.
const MOVES: &[Move] = &[
    insert::propose,
    insert::propose,
    remove::propose,
    replace::propose,
    replace::propose,
    relocate::propose,
    exchange::propose,
    turn::propose,
    graft::propose,
    stay::propose,
];

/// Returns a change by one of the moves.
pub(super) fn propose(draw: &mut Draw<'_>) -> Option<Change> {
    let choice = draw.random.below(MOVES.len());
    MOVES.get(choice).and_then(|chosen| chosen(draw))
}

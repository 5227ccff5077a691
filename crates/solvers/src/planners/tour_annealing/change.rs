//! A change of a tour: the visits from one place to another are replaced.

/// Letters that one change may put in: more is a new tour.
pub(super) const LETTERS_MAX: usize = 24;

/// Visits `from..until` of a tour give way to `letters`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Change {
    /// First visit that goes.
    pub(super) from: usize,
    /// First visit that stays.
    pub(super) until: usize,
    letters: [u32; LETTERS_MAX],
    count: usize,
}

impl Change {
    /// A change that only takes away.
    pub(super) fn cut(from: usize, until: usize) -> Change {
        Change { from, until, letters: [0; LETTERS_MAX], count: 0 }
    }

    /// The same with one more letter; those beyond [`LETTERS_MAX`] are dropped.
    pub(super) fn with(mut self, letter: usize) -> Change {
        if let Some(slot) = self.letters.get_mut(self.count) {
            *slot = letter as u32;
            self.count += 1;
        }
        self
    }

    /// The same with more letters.
    pub(super) fn with_all(self, letters: impl IntoIterator<Item = usize>) -> Change {
        letters.into_iter().fold(self, Change::with)
    }

    /// Returns the inserted visits.
    pub(super) fn letters(&self) -> impl Iterator<Item = usize> + '_ {
        self.letters.iter().take(self.count).map(|letter| *letter as usize)
    }

    /// Carries it out.
    pub(super) fn apply(&self, tour: &mut Vec<usize>) {
        let from = self.from.min(tour.len());
        let until = self.until.clamp(from, tour.len());
        tour.splice(from..until, self.letters());
    }
}

//! A change of a tour: consecutive visits are replaced by others. A letter is the index of a visited target.

/// Maximum number of letters that one change inserts.
pub(super) const LETTERS_MAX: usize = 24;

/// Replaces visits `from..until` of a tour by `letters`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Change {
    /// Index of the first visit that is removed.
    pub(super) from: usize,
    /// Index of the first visit after the removed ones.
    pub(super) until: usize,
    letters: [u32; LETTERS_MAX],
    count: usize,
}

impl Change {
    /// Returns a change that removes visits and inserts none.
    pub(super) fn cut(from: usize, until: usize) -> Change {
        Change { from, until, letters: [0; LETTERS_MAX], count: 0 }
    }

    /// Returns the change with one more letter; letters beyond [`LETTERS_MAX`] are dropped.
    pub(super) fn with(mut self, letter: usize) -> Change {
        if let Some(slot) = self.letters.get_mut(self.count) {
            *slot = letter as u32;
            self.count += 1;
        }
        self
    }

    /// Returns the change with all `letters` added.
    pub(super) fn with_all(self, letters: impl IntoIterator<Item = usize>) -> Change {
        letters.into_iter().fold(self, Change::with)
    }

    /// Returns the inserted visits.
    pub(super) fn letters(&self) -> impl Iterator<Item = usize> + '_ {
        self.letters.iter().take(self.count).map(|letter| *letter as usize)
    }

    /// Applies the change to `tour`.
    pub(super) fn apply(&self, tour: &mut Vec<usize>) {
        let from = self.from.min(tour.len());
        let until = self.until.clamp(from, tour.len());
        tour.splice(from..until, self.letters());
    }
}

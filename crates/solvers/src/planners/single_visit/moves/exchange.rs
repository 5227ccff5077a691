//! Move that exchanges two visits.

use super::super::search::{Candidate, LocalSearch};

impl LocalSearch<'_, '_, '_> {
    /// Exchanges the visits `from` and `to`. Returns true if the plan improved.
    pub(super) fn exchange(&mut self, current: &mut Candidate, from: usize, to: usize) -> bool {
        let mut exchanged = current.order.clone();
        exchanged.swap(from, to);
        self.try_promising(current, from, to + 1, exchanged)
    }
}

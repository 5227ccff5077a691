//! Move that reverses a part of the order (2-opt).

use super::super::search::{Candidate, LocalSearch};

impl LocalSearch<'_, '_, '_> {
    /// Reverses the visits `from` to `to`. Returns true if the plan improved.
    pub(super) fn turn(&mut self, current: &mut Candidate, from: usize, to: usize) -> bool {
        let mut turned = current.order.clone();
        if let Some(part) = turned.get_mut(from..=to) {
            part.reverse();
        }
        self.try_promising(current, from, to + 1, turned)
    }
}

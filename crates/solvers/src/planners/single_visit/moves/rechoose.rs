//! Move that changes the manoeuvre or the time of a visit.

use super::super::search::{Candidate, LocalSearch};

impl LocalSearch<'_, '_, '_> {
    /// Replaces the manoeuvre or the time of one visit. Returns true if the plan improved.
    pub(super) fn rechoose(&mut self, current: &mut Candidate) -> bool {
        let mut better = false;
        for at in 0..current.order.len() {
            let Some(now) = current.order.get(at).copied() else { continue };
            for choice in self.choices(now.target).into_iter().filter(|choice| *choice != now) {
                let mut order = current.order.clone();
                if let Some(slot) = order.get_mut(at) {
                    *slot = choice;
                }
                better |= self.try_order(current, at, order);
            }
        }
        better
    }
}

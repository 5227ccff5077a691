//! Move that removes a visit.

use super::super::search::{Candidate, LocalSearch};

impl LocalSearch<'_, '_, '_> {
    /// Removes the first visit whose removal improves the plan. Returns false if there is none.
    pub(super) fn leave_out(&mut self, current: &mut Candidate) -> bool {
        (0..current.order.len()).any(|at| {
            let mut order = current.order.clone();
            order.remove(at);
            !order.is_empty() && self.try_order(current, at, order)
        })
    }
}

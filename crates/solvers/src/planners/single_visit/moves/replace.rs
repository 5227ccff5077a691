//! Move that replaces one target by another.

use super::super::search::{Candidate, LocalSearch, inserted};

/// Number of insertions evaluated in place of one removed visit.
const REPLACEMENTS_MAX: usize = 12;

impl LocalSearch<'_, '_, '_> {
    /// Replaces one visit by another target, or by the same target with another manoeuvre, at any position. Returns true if the plan
    /// improved.
    pub(super) fn replace(&mut self, current: &mut Candidate) -> bool {
        for out in 0..current.order.len() {
            let mut order = current.order.clone();
            order.remove(out);
            let Some(judged) = self.judge(current, out, &order) else { continue };
            let without = Candidate { order, judged };
            let mut offers = self.offers(&without, 0.0);
            for _ in 0..REPLACEMENTS_MAX {
                let Some(offer) = self.best_offer(&without, &mut offers) else { break };
                let order = inserted(&without.order, offer.at, offer.choice);
                if self.try_order(current, out.min(offer.at), order) {
                    return true;
                }
            }
        }
        false
    }
}

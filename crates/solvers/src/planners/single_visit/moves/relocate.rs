//! Move that relocates a visit or a short run of visits, also reversed.

use super::super::search::{Candidate, LocalSearch};
use crate::routing::schedule::Choice;

/// Longest run of visits that is moved to another place.
const RUN_MAX: usize = 3;

impl LocalSearch<'_, '_, '_> {
    /// Moves one visit or a short run of visits to another position, also reversed. Returns true if the plan improved.
    pub(super) fn relocate(&mut self, current: &mut Candidate) -> bool {
        let mut better = false;
        for length in 1..=RUN_MAX {
            for from in 0..current.order.len() {
                for to in 0..current.order.len() {
                    let count = current.order.len();
                    if to == from || from + length > count || to + length > count {
                        continue;
                    }
                    let mut order = current.order.clone();
                    let mut run: Vec<Choice> = order.drain(from..from + length).collect();
                    let (first, last) = (from.min(to), (from + length).max(to + length));
                    order.splice(to..to, run.iter().copied());
                    let moved = self.try_promising(current, first, last, order.clone());
                    better |= moved;
                    if length > 1 && !moved {
                        run.reverse();
                        order.splice(to..to + length, run);
                        better |= self.try_promising(current, first, last, order);
                    }
                }
            }
        }
        better
    }
}

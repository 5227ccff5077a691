//! Move that inserts several targets at once: those that have no value, or cannot be reached, unless another target is visited, too.

use super::super::companions::before;
use super::super::search::{Candidate, LocalSearch};
use crate::routing::schedule::Choice;

/// Maximum number of visits that one move inserts.
const TOGETHER_MAX: usize = 6;

impl LocalSearch<'_, '_, '_> {
    /// Inserts one missing companion together with the targets that must precede it, and possibly one more missing target, at the
    /// first position that improves the plan. Returns false if none does.
    pub(super) fn insert_together(&mut self, current: &mut Candidate) -> bool {
        let missing = self.missing(&current.order);
        for target in self.companions.clone() {
            if !missing.contains(&target) {
                continue;
            }
            let before = before(self.schedule, target, &current.order);
            if before.iter().any(|earlier| !missing.contains(earlier)) || before.len() >= TOGETHER_MAX {
                continue;
            }
            let leads = missing.iter().copied().filter(|lead| *lead != target && !before.contains(lead));
            let leads: Vec<Option<usize>> = [None].into_iter().chain(leads.map(Some)).collect();
            for lead in leads {
                let block: Vec<usize> = before.iter().copied().chain(lead).chain([target]).collect();
                if block.len() > 1 && self.insert_block(current, &block) {
                    return true;
                }
            }
        }
        false
    }

    /// Inserts the targets of `block` in sequence at the first position that improves the plan. All use their best manoeuvre,
    /// except for the last, whose manoeuvres are tried in order. Returns false if no position improves it.
    fn insert_block(&mut self, current: &mut Candidate, block: &[usize]) -> bool {
        let Some((last, leads)) = block.split_last() else { return false };
        let leads: Vec<Choice> = leads.iter().filter_map(|target| self.choices(*target).first().copied()).collect();
        for at in 0..=current.order.len() {
            for choice in self.choices(*last) {
                if self.budget.exhausted() {
                    return false;
                }
                let (before, after) = current.order.split_at(at);
                let order: Vec<Choice> =
                    before.iter().chain(&leads).copied().chain([choice]).chain(after.iter().copied()).collect();
                if self.try_order(current, at, order) {
                    return true;
                }
            }
        }
        false
    }
}

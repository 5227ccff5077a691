//! Targets in at one stroke that cannot come in one by one: what is worth nothing, or out of reach, until another one is visited.

use super::super::explain::Troubles;
use super::super::search::{Candidate, LocalSearch};
use crate::routing::schedule::{Choice, Schedule};

/// Visits that are put in at one stroke, at most.
const TOGETHER_MAX: usize = 6;

/// Targets that are reached only after others: those that cannot be visited alone, and those that must follow what is worth nothing, at once
/// or through others.
pub(in super::super) fn companions(schedule: &Schedule<'_>, troubles: &Troubles) -> Vec<usize> {
    let mut led = troubles.with_others();
    let worthless = |target: usize| {
        let data = schedule.problem.targets.get(target);
        data.is_some_and(|data| {
            data.value * data.manoeuvres.iter().map(|it| it.quality.product()).fold(0.0, f64::max) <= 0.0
        })
    };
    for target in troubles.possible() {
        let before = before(schedule, target, &[]);
        if !led.contains(&target) && before.iter().any(|earlier| worthless(*earlier) || led.contains(earlier)) {
            led.push(target);
        }
    }
    led
}

/// What must come before `target` and is not among `visited`, in an order that is allowed.
fn before(schedule: &Schedule<'_>, target: usize, visited: &[Choice]) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let mut open = vec![(target, false)];
    while let Some((next, is_left)) = open.pop() {
        if is_left {
            if next != target && !found.contains(&next) {
                found.push(next);
            }
            continue;
        }
        open.push((next, true));
        let missing = |earlier: &&usize| !visited.iter().any(|choice| choice.target == **earlier);
        open.extend(schedule.earlier(next).iter().filter(missing).map(|earlier| (*earlier, false)));
    }
    found
}

impl LocalSearch<'_, '_, '_> {
    /// One missing companion with what must come before it, or behind another missing target, at the first place where that is
    /// better. Says whether there was one.
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

    /// The targets of `block` in sequence, at the first place where that is better, each in its best manoeuvre first.
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

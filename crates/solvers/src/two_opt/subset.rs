//! Which targets the cycle should hold: drop, add and exchange around shortest tours, judged by expected cost.

use super::tour;
use crate::surveillance::scenario::Scenario;
use apex_model::solver::Budget;

/// The best cycle so far.
pub(super) struct Search<'s, 'p> {
    pub(super) scenario: &'s Scenario<'p>,
    pub(super) best: Vec<usize>,
    pub(super) best_cost: f64,
}

type Report<'r> = &'r mut dyn FnMut(&[usize]);

impl<'s, 'p> Search<'s, 'p> {
    pub(super) fn new(scenario: &'s Scenario<'p>) -> Search<'s, 'p> {
        Search { scenario, best: Vec::new(), best_cost: f64::INFINITY }
    }

    pub(super) fn into_best(self) -> Vec<usize> {
        self.best
    }

    /// Takes `cycle`, begun where it costs least, if it is better than the best. The first one is always taken.
    pub(super) fn offer(&mut self, cycle: Vec<usize>, budget: &mut dyn Budget, report: Report<'_>) -> bool {
        let (cost, cycle) = best_beginning(self.scenario, cycle, budget);
        let better = self.best.is_empty() || cost < self.best_cost * (1.0 - 1e-12);
        if better {
            self.best = cycle;
            self.best_cost = cost;
            report(&self.best);
        }
        better
    }

    /// Drops, adds and exchanges targets of the best cycle until nothing helps.
    pub(super) fn descend(&mut self, budget: &mut dyn Budget, report: Report<'_>) {
        while !budget.exhausted() && self.step(budget, report) {}
    }

    fn step(&mut self, budget: &mut dyn Budget, report: Report<'_>) -> bool {
        let mut neighbours = Vec::new();
        for at in 0..self.best.len() {
            let mut without = self.best.clone();
            let dropped = without.remove(at);
            if !without.is_empty() {
                neighbours.push(without.clone());
            }
            let added = self.missing().into_iter().filter(|target| *target != dropped);
            neighbours.extend(added.map(|target| self.inserted(&without, target)));
        }
        neighbours.extend(self.missing().into_iter().map(|target| self.inserted(&self.best, target)));
        for neighbour in neighbours {
            if budget.exhausted() {
                return false;
            }
            let cycle = self.straightened(neighbour, budget);
            if self.offer(cycle, budget, report) {
                return true;
            }
        }
        false
    }

    /// Begins anew with the single best target and adds as long as it helps: reaches small cycles that dropping from
    /// the full set cannot.
    pub(super) fn grow_from_one(&mut self, budget: &mut dyn Budget, report: Report<'_>) {
        let mut grown = Search::new(self.scenario);
        for target in self.scenario.usable() {
            grown.offer(vec![*target], budget, &mut |_| {});
        }
        grown.descend(budget, &mut |_| {});
        self.offer(grown.into_best(), budget, report);
    }

    fn missing(&self) -> Vec<usize> {
        self.scenario.usable().iter().copied().filter(|target| !self.best.contains(target)).collect()
    }

    /// `cycle` with `target` where it lengthens the tour least.
    fn inserted(&self, cycle: &[usize], target: usize) -> Vec<usize> {
        let travel = self.scenario.typical();
        let detour = |at: usize| {
            let after = cycle.get(at % cycle.len().max(1)).copied().unwrap_or(target);
            let before = cycle.get((at + cycle.len().max(1) - 1) % cycle.len().max(1)).copied().unwrap_or(target);
            travel.between(before, target) + travel.between(target, after) - travel.between(before, after)
        };
        let at = (0..=cycle.len()).min_by(|a, b| detour(*a).total_cmp(&detour(*b))).unwrap_or(0);
        let mut longer = cycle.to_vec();
        longer.insert(at, target);
        longer
    }

    fn straightened(&self, mut cycle: Vec<usize>, budget: &mut dyn Budget) -> Vec<usize> {
        if cycle.len() <= tour::EXACT_MAX {
            return tour::shortest(self.scenario, &cycle, budget);
        }
        let travel = self.scenario.typical();
        tour::improve(&mut cycle, &|from, to| travel.between(from, to), budget);
        cycle
    }
}

/// The rotation of `cycle` that costs least when flown from the start.
pub(super) fn best_beginning(
    scenario: &Scenario<'_>,
    mut cycle: Vec<usize>,
    budget: &mut dyn Budget,
) -> (f64, Vec<usize>) {
    let mut best = (scenario.cycle_cost(&cycle, budget), cycle.clone());
    for _ in 1..cycle.len() {
        if budget.exhausted() {
            break;
        }
        cycle.rotate_left(1);
        let cost = scenario.cycle_cost(&cycle, budget);
        if cost < best.0 {
            best = (cost, cycle.clone());
        }
    }
    best
}

//! Choice of targets for the cycle: drops, adds and exchanges targets, each with the shortest tour, evaluated by expected cost.

use super::report::CycleObserver;
use apex_planning::solver::Budget;
use apex_planning::surveillance::scenario::Scenario;
use apex_planning::tour;

/// Work per examined position for another target, in nanoseconds.
const DETOUR_NS: u64 = 20;

/// The best cycle so far.
pub(super) struct SubsetSearch<'s, 'p> {
    pub(super) scenario: &'s Scenario<'p>,
    pub(super) best: Vec<usize>,
    pub(super) best_cost: f64,
}

impl<'s, 'p> SubsetSearch<'s, 'p> {
    pub(super) fn new(scenario: &'s Scenario<'p>) -> SubsetSearch<'s, 'p> {
        SubsetSearch { scenario, best: Vec::new(), best_cost: f64::INFINITY }
    }

    pub(super) fn into_best(self) -> Vec<usize> {
        self.best
    }

    /// Adopts `cycle`, with its cheapest first target, if it is better than the best. The first cycle is always adopted.
    pub(super) fn offer(&mut self, cycle: Vec<usize>, budget: &mut dyn Budget, report: CycleObserver<'_>) -> bool {
        let (cost, cycle) = best_beginning(self.scenario, cycle, budget);
        let better = self.best.is_empty() || cost < self.best_cost * (1.0 - 1e-12);
        if better {
            self.best = cycle;
            self.best_cost = cost;
            report(cost, &self.best);
        }
        better
    }

    /// Drops, adds and exchanges targets of the best cycle until no change lowers its cost.
    pub(super) fn descend(&mut self, budget: &mut dyn Budget, report: CycleObserver<'_>) {
        while !budget.exhausted() && self.step(budget, report) {}
    }

    fn step(&mut self, budget: &mut dyn Budget, report: CycleObserver<'_>) -> bool {
        let missing = self.missing();
        // For each target: drop it, or replace it; finally add one. Candidates are made one by one, because there are many.
        for at in 0..=self.best.len() {
            let dropped = self.best.get(at).copied();
            let mut without = self.best.clone();
            if dropped.is_some() {
                without.remove(at);
            }
            let alone = dropped.is_some().then_some(None);
            for added in alone.into_iter().chain(missing.iter().copied().map(Some)) {
                if budget.exhausted() {
                    return false;
                }
                let neighbour = added.map_or_else(|| without.clone(), |target| self.inserted(&without, target));
                if neighbour.is_empty() {
                    continue;
                }
                let cycle = self.straightened(neighbour, budget);
                if self.offer(cycle, budget, report) {
                    return true;
                }
            }
        }
        false
    }

    /// Starts again with the single best target and adds targets while that helps: reaches small cycles that dropping from the full set
    /// cannot.
    pub(super) fn grow_from_one(&mut self, budget: &mut dyn Budget, report: CycleObserver<'_>) {
        let mut grown = SubsetSearch::new(self.scenario);
        for target in self.scenario.usable() {
            if budget.exhausted() && !grown.best.is_empty() {
                return;
            }
            grown.offer(vec![*target], budget, &mut |_, _| {});
        }
        grown.descend(budget, &mut |_, _| {});
        self.offer(grown.into_best(), budget, report);
    }

    fn missing(&self) -> Vec<usize> {
        let mut there = vec![false; self.scenario.problem().targets.len()];
        for target in &self.best {
            if let Some(flag) = there.get_mut(*target) {
                *flag = true;
            }
        }
        let missing = |target: &usize| there.get(*target) == Some(&false);
        self.scenario.usable().iter().copied().filter(missing).collect()
    }

    /// Returns `cycle` with `target` inserted where it lengthens the tour least.
    fn inserted(&self, cycle: &[usize], target: usize) -> Vec<usize> {
        self.scenario.spend(cycle.len() as u64 * DETOUR_NS);
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
        tour::improve(self.scenario, &mut cycle, &|from, to| travel.between(from, to), budget);
        cycle
    }
}

/// Returns the rotation of `cycle` that costs least when flown from the start.
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

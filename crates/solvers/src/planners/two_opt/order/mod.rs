//! Improves the order of a cycle by its expected cost: if the horizon covers few laps, the shortest tour is not the cheapest. Moves:
//! relocate one target, exchange two, reverse a part; one file for each.

mod exchange;
mod relocate;
mod turn;

use super::report::CycleObserver;
use super::subset::SubsetSearch;
use apex_planning::solver::Budget;

/// Applies the first move that lowers the cost until none does or the budget is exhausted.
pub(super) fn refine(search: &mut SubsetSearch<'_, '_>, budget: &mut dyn Budget, report: CycleObserver<'_>) {
    while !budget.exhausted() && step(search, budget, report) {}
}

fn step(search: &mut SubsetSearch<'_, '_>, budget: &mut dyn Budget, report: CycleObserver<'_>) -> bool {
    let count = search.best.len();
    for from in 0..count {
        for to in 0..count {
            search.scenario.spend(count as u64);
            for neighbour in neighbours(&search.best, from, to) {
                if budget.exhausted() {
                    return false;
                }
                let cost = search.scenario.cycle_cost(&neighbour, budget);
                if cost < search.best_cost * (1.0 - 1e-12) {
                    search.best = neighbour;
                    search.best_cost = cost;
                    report(cost, &search.best);
                    return true;
                }
            }
        }
    }
    false
}

fn neighbours(cycle: &[usize], from: usize, to: usize) -> Vec<Vec<usize>> {
    let mut all = Vec::new();
    if from != to {
        all.push(relocate::relocated(cycle, from, to));
    }
    if from < to {
        all.push(exchange::exchanged(cycle, from, to));
        all.push(turn::turned(cycle, from, to));
    }
    all
}

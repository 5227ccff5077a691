//! The shortest directed tour over a set: Held-Karp for few targets, 2-opt and Or-opt from several starts for more.
//!
//! Travel is asymmetric: reversing a part of a tour changes its length, so sums in both directions are kept. Bound: O(2^n n^2) up to
//! [`EXACT_MAX`] targets, O(n^2) per pass above, at most [`STARTS_MAX`] starts.

mod exact;
pub mod nearest;
mod or_opt;
mod turn;

use crate::solver::Budget;
use crate::surveillance::scenario::Scenario;

/// Sets up to this size are solved exactly: 9 * 9 * 512 steps.
pub const EXACT_MAX: usize = 9;
/// Maximum number of nearest-neighbour starts of the search for larger sets.
pub const STARTS_MAX: usize = 8;
/// Maximum number of improvements of one descent: far more than any tour needs; the limit prevents a loop through rounding errors.
const IMPROVEMENTS_MAX: usize = 100_000;
/// Fixed work of a row of reversals or moves, in nanoseconds.
const ROW_NS: u64 = 100;

/// Returns the factor by which an access to the travel times of `count` targets costs more when they do not fit into the processor's cache.
fn memory(count: usize) -> u64 {
    1 + count as u64 / 400
}

/// Returns the length of the closed tour.
pub fn length(tour: &[usize], distance: impl Fn(usize, usize) -> f64) -> f64 {
    let next = tour.iter().skip(1).chain(tour.first());
    tour.iter().zip(next).map(|(from, to)| distance(*from, *to)).sum()
}

/// Returns the shortest tour over `targets`, as a cycle of indices.
pub fn shortest(scenario: &Scenario<'_>, targets: &[usize], budget: &mut dyn Budget) -> Vec<usize> {
    let distance = |from: usize, to: usize| scenario.typical().between(from, to);
    if targets.len() <= 2 {
        return targets.to_vec();
    }
    if targets.len() <= EXACT_MAX {
        return exact::shortest(scenario, targets, &distance, budget);
    }
    let stride = targets.len().div_ceil(STARTS_MAX);
    let mut best: Option<(f64, Vec<usize>)> = None;
    for start in targets.iter().step_by(stride) {
        let mut tour = nearest::cycle_from(scenario, Some(*start), targets, budget);
        improve(scenario, &mut tour, &distance, budget);
        let total = length(&tour, distance);
        if best.as_ref().is_none_or(|(least, _)| total < *least) {
            best = Some((total, tour));
        }
        if budget.exhausted() {
            break;
        }
    }
    best.map_or_else(|| targets.to_vec(), |(_, tour)| tour)
}

/// Applies 2-opt and Or-opt moves until none shortens the tour or the budget is exhausted.
pub fn improve(
    scenario: &Scenario<'_>,
    tour: &mut Vec<usize>,
    distance: &dyn Fn(usize, usize) -> f64,
    budget: &mut dyn Budget,
) {
    for _ in 0..IMPROVEMENTS_MAX {
        if budget.exhausted()
            || !(turn::improve(scenario, tour, distance, budget) || or_opt::improve(scenario, tour, distance, budget))
        {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::surveillance as examples;
    use crate::solver::WorkBudget;

    #[test]
    fn exact_and_improved_tours_agree_on_most_small_sets() {
        let mut equal = 0;
        for seed in 0..40 {
            let problem = examples::random(8, seed);
            let scenario = Scenario::new(&problem).unwrap();
            let distance = |from: usize, to: usize| problem.travel.between(from, to);
            let mut budget = WorkBudget::new(u64::MAX);
            let best = length(&exact::shortest(&scenario, scenario.usable(), &distance, &mut budget), distance);
            let mut tour = nearest::cycle_from(&scenario, None, scenario.usable(), &mut budget);
            improve(&scenario, &mut tour, &distance, &mut budget);
            let found = length(&tour, distance);
            assert!(found >= best - 1e-9);
            equal += u32::from(found < best + 1e-9);
        }
        assert!(equal >= 30, "{equal} of 40");
    }

    #[test]
    fn directed_lengths_count() {
        // The tour is short in one direction and long in the other.
        let distance = |from: usize, to: usize| if (from + 1) % 5 == to { 1.0 } else { 10.0 };
        let mut tour = vec![4, 3, 2, 1, 0];
        let problem = examples::random(5, 1);
        let scenario = Scenario::new(&problem).unwrap();
        improve(&scenario, &mut tour, &distance, &mut WorkBudget::new(u64::MAX));
        assert_eq!(length(&tour, distance), 5.0);
    }
}

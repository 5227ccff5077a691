//! 2-opt: reversal of a part of the tour. Bound: O(n^2).

use super::{ROW_NS, memory};
use crate::solver::Budget;
use crate::surveillance::scenario::Scenario;

/// Work of trying a reversal, in nanoseconds.
const TURN_NS: u64 = 8;

/// Reverses the part whose reversal shortens the tour most. Returns false if none does.
pub(super) fn improve(
    scenario: &Scenario<'_>,
    tour: &mut [usize],
    distance: &dyn Fn(usize, usize) -> f64,
    budget: &mut dyn Budget,
) -> bool {
    let count = tour.len();
    let place = |index: usize| tour.get(index % count.max(1)).copied().unwrap_or(0);
    // Sums along the tour forwards and backwards up to each place.
    let (mut forward, mut backward) = (vec![0.0], vec![0.0]);
    let (mut ahead, mut behind) = (0.0, 0.0);
    for index in 1..count {
        ahead += distance(place(index - 1), place(index));
        behind += distance(place(index), place(index - 1));
        forward.push(ahead);
        backward.push(behind);
    }
    let sum = |sums: &[f64], from: usize, to: usize| {
        sums.get(to).copied().unwrap_or(0.0) - sums.get(from).copied().unwrap_or(0.0)
    };
    let mut best = (-1e-9, 0, 0);
    for from in 1..count {
        for to in from + 1..count {
            let (before, after) = (place(from - 1), place(to + 1));
            let old = distance(before, place(from)) + sum(&forward, from, to) + distance(place(to), after);
            let new = distance(before, place(to)) + sum(&backward, from, to) + distance(place(from), after);
            if new - old < best.0 {
                best = (new - old, from, to);
            }
        }
        scenario.charge((count - from) as u64 * TURN_NS * memory(count) + ROW_NS, budget);
        if budget.exhausted() {
            break;
        }
    }
    let Some(part) = tour.get_mut(best.1..=best.2).filter(|_| best.0 < -1e-9) else { return false };
    part.reverse();
    true
}

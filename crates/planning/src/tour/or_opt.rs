//! Or-opt: moves a short part of the tour to another place. Bound: O(n^2).

use super::{ROW_NS, length, memory};
use crate::solver::Budget;
use crate::surveillance::scenario::Scenario;

/// Work of trying a move, in nanoseconds.
const MOVE_NS: u64 = 12;

/// Moves the part of up to three targets whose move, perhaps reversed, shortens the tour most. Returns false if no move shortens it.
pub(super) fn improve(
    scenario: &Scenario<'_>,
    tour: &mut Vec<usize>,
    distance: &dyn Fn(usize, usize) -> f64,
    budget: &mut dyn Budget,
) -> bool {
    let count = tour.len();
    let mut best: (f64, Vec<usize>) = (length(tour, distance) - 1e-9, Vec::new());
    for size in 1..=3.min(count.saturating_sub(2)) {
        for from in 0..count {
            scenario.charge(count as u64 * MOVE_NS * memory(count) + ROW_NS, budget);
            if budget.exhausted() {
                break;
            }
            let mut turned = tour.clone();
            turned.rotate_left(from);
            let rest = turned.split_off(size);
            let part_forward = path_length(&turned, distance);
            let reversed: Vec<usize> = turned.iter().rev().copied().collect();
            let part_backward = path_length(&reversed, distance);
            let base = length(&rest, distance);
            for at in 0..rest.len() {
                let left = rest.get(at).copied().unwrap_or(0);
                let right = rest.get((at + 1) % rest.len()).copied().unwrap_or(0);
                let gap = base - distance(left, right);
                for (part, inner) in [(&turned, part_forward), (&reversed, part_backward)] {
                    let (Some(head), Some(tail)) = (part.first(), part.last()) else { continue };
                    let total = gap + distance(left, *head) + inner + distance(*tail, right);
                    if total < best.0 {
                        let (before, after) = rest.split_at_checked(at + 1).unwrap_or((&rest, &[]));
                        best = (total, [before, part, after].concat());
                    }
                }
            }
        }
    }
    if best.1.is_empty() {
        return false;
    }
    *tour = best.1;
    true
}

fn path_length(path: &[usize], distance: &dyn Fn(usize, usize) -> f64) -> f64 {
    path.iter().zip(path.iter().skip(1)).map(|(from, to)| distance(*from, *to)).sum()
}

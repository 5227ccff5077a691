//! The shortest tour over few targets, by dynamic programming over all subsets. Bound: O(2^n n^2).

use crate::solver::Budget;
use crate::surveillance::scenario::Scenario;

/// Work of a step of the recursion, in quarters of a nanosecond.
const STEP_QUARTER_NS: u64 = 6;

/// Applies Held and Karp's recursion over sets; the tour begins with the first target.
pub(super) fn shortest(
    scenario: &Scenario<'_>,
    targets: &[usize],
    distance: &dyn Fn(usize, usize) -> f64,
    budget: &mut dyn Budget,
) -> Vec<usize> {
    let Some((first, rest)) = targets.split_first() else { return Vec::new() };
    let (count, sets) = (rest.len(), 1_usize << rest.len());
    scenario.charge((sets * count * count) as u64 * STEP_QUARTER_NS / 4, budget);
    // Least length of a path from `first` through the subset that ends at a member, and the preceding member.
    let mut table: Vec<(f64, usize)> = vec![(f64::INFINITY, 0); sets * count];
    let slot = |set: usize, last: usize| set * count + last;
    for (index, target) in rest.iter().enumerate() {
        if let Some(entry) = table.get_mut(slot(1 << index, index)) {
            *entry = (distance(*first, *target), index);
        }
    }
    for set in 1..sets {
        for (last, from) in rest.iter().enumerate().filter(|(last, _)| set >> last & 1 == 1) {
            let here = table.get(slot(set, last)).map_or(f64::INFINITY, |(length, _)| *length);
            for (next, to) in rest.iter().enumerate().filter(|(next, _)| set >> next & 1 == 0) {
                let total = here + distance(*from, *to);
                if let Some(entry) = table.get_mut(slot(set | 1 << next, next)).filter(|entry| total < entry.0) {
                    *entry = (total, last);
                }
            }
        }
    }
    let full = sets - 1;
    let closed = |last: usize, target: usize| {
        table.get(slot(full, last)).map_or(f64::INFINITY, |(length, _)| *length) + distance(target, *first)
    };
    let ends = rest.iter().enumerate();
    let best = ends.min_by(|(a, from), (b, to)| closed(*a, **from).total_cmp(&closed(*b, **to)));
    let (mut set, mut last) = (full, best.map_or(0, |(last, _)| last));
    let mut tour = Vec::with_capacity(targets.len());
    while set != 0 {
        tour.extend(rest.get(last).copied());
        let before = table.get(slot(set, last)).map_or(0, |(_, before)| *before);
        set &= !(1 << last);
        last = before;
    }
    tour.push(*first);
    tour.reverse();
    tour
}

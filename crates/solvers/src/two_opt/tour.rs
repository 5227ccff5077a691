//! The shortest directed tour over a set: Held-Karp for few targets, 2-opt and Or-opt from several starts for more.
//!
//! Travel is not symmetric: turning a part of a tour round changes the length of that part, so sums in both directions are
//! kept. Bound: O(2^n n^2) up to [`EXACT_MAX`] targets, O(n^2) per pass beyond, at most [`STARTS_MAX`] starts.

use crate::nearest_neighbour;
use crate::surveillance::scenario::Scenario;
use apex_model::solver::Budget;

/// Sets up to this size are solved exactly: 9 * 9 * 512 steps.
pub const EXACT_MAX: usize = 9;
/// Nearest-neighbour starts of the search beyond that.
pub const STARTS_MAX: usize = 8;
/// Improvements of one descent: far more than any tour needs, so that rounding cannot loop.
const IMPROVEMENTS_MAX: usize = 100_000;
/// What is tried takes in nanoseconds: a step of the recursion (a quarter of this), a turn, a move, and a row of them besides.
const STEP_NS: u64 = 6;
const TURN_NS: u64 = 8;
const MOVE_NS: u64 = 12;
const ROW_NS: u64 = 100;

/// How many times as long a look at the travel times takes where they do not lie in the processor's own memory any more.
fn memory(count: usize) -> u64 {
    1 + count as u64 / 400
}

/// Length of the closed tour.
pub fn length(tour: &[usize], distance: impl Fn(usize, usize) -> f64) -> f64 {
    let next = tour.iter().skip(1).chain(tour.first());
    tour.iter().zip(next).map(|(from, to)| distance(*from, *to)).sum()
}

/// The shortest tour over `targets`, as a cycle of indices.
pub fn shortest(scenario: &Scenario<'_>, targets: &[usize], budget: &mut dyn Budget) -> Vec<usize> {
    let distance = |from: usize, to: usize| scenario.typical().between(from, to);
    if targets.len() <= 2 {
        return targets.to_vec();
    }
    if targets.len() <= EXACT_MAX {
        return exact(scenario, targets, &distance, budget);
    }
    let stride = targets.len().div_ceil(STARTS_MAX);
    let mut best: Option<(f64, Vec<usize>)> = None;
    for start in targets.iter().step_by(stride) {
        let mut tour = nearest_neighbour::cycle_from(scenario, Some(*start), targets, budget);
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

/// Held and Karp's recursion over sets; the tour begins with the first target.
fn exact(
    scenario: &Scenario<'_>,
    targets: &[usize],
    distance: &dyn Fn(usize, usize) -> f64,
    budget: &mut dyn Budget,
) -> Vec<usize> {
    let Some((first, rest)) = targets.split_first() else { return Vec::new() };
    let (count, sets) = (rest.len(), 1_usize << rest.len());
    scenario.charge((sets * count * count) as u64 * STEP_NS / 4, budget);
    // Least length of a path from `first` through the set that ends at a member, and the member before it.
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

/// Applies 2-opt and Or-opt moves until none shortens the tour or the budget is exhausted.
pub fn improve(
    scenario: &Scenario<'_>,
    tour: &mut Vec<usize>,
    distance: &dyn Fn(usize, usize) -> f64,
    budget: &mut dyn Budget,
) {
    for _ in 0..IMPROVEMENTS_MAX {
        if budget.exhausted()
            || !(two_opt(scenario, tour, distance, budget) || or_opt(scenario, tour, distance, budget))
        {
            return;
        }
    }
}

/// Turns round the part whose turning shortens the tour most; false where none does.
fn two_opt(
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

/// Moves the part of up to three targets whose moving (as it is or turned round) shortens the tour most.
fn or_opt(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surveillance::examples;
    use apex_model::solver::WorkBudget;

    #[test]
    fn exact_and_improved_tours_agree_on_most_small_sets() {
        let mut equal = 0;
        for seed in 0..40 {
            let problem = examples::random(8, seed);
            let scenario = Scenario::new(&problem).unwrap();
            let distance = |from: usize, to: usize| problem.travel.between(from, to);
            let mut budget = WorkBudget::new(u64::MAX);
            let best = length(&exact(&scenario, scenario.usable(), &distance, &mut budget), distance);
            let mut tour = nearest_neighbour::cycle_from(&scenario, None, scenario.usable(), &mut budget);
            improve(&scenario, &mut tour, &distance, &mut budget);
            let found = length(&tour, distance);
            assert!(found >= best - 1e-9);
            equal += u32::from(found < best + 1e-9);
        }
        assert!(equal >= 30, "{equal} of 40");
    }

    #[test]
    fn directed_lengths_count() {
        // One way round is free, the other is dear.
        let distance = |from: usize, to: usize| if (from + 1) % 5 == to { 1.0 } else { 10.0 };
        let mut tour = vec![4, 3, 2, 1, 0];
        let problem = examples::random(5, 1);
        let scenario = Scenario::new(&problem).unwrap();
        improve(&scenario, &mut tour, &distance, &mut WorkBudget::new(u64::MAX));
        assert_eq!(length(&tour, distance), 5.0);
    }
}

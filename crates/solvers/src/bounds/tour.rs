//! A bound on the length of a tour: 1-trees, with multipliers that drive every node towards two neighbours (Held and Karp 1970).
//!
//! A tour is a tree over all nodes but the depot, plus two edges at the depot. Multipliers on nodes, added at each edge of the tree and
//! subtracted twice per node, do not change the length of a tour, but raise that of trees that avoid nodes. For any multipliers the
//! shortest such tree bounds every tour. Of two directions the faster counts, so the bound is weak if they differ much.
//! Bound: O(rounds x nodes squared).

use apex_model::problem::{TravelTimes, UNREACHABLE_S};
use apex_planning::meter::Meter;

/// Maximum number of examined edges in all, which take about a second, and the least and greatest number of rounds.
const LOOKS_MAX: usize = 200_000_000;
const ROUNDS: (usize, usize) = (20, 1_000);
/// Work per examined edge, in nanoseconds: measured were 4 among 400 places.
const LOOK_NS: f64 = 5.0;
/// Rounds without a better bound after which steps are halved.
const PATIENCE: u32 = 8;
/// Relative amount by which the bound is lowered, so that rounding cannot lift it above the true value.
const ROUNDING: f64 = 1e-9;

/// Returns a lower bound on the time of a tour from the start through all targets and back to the base, as far as the budget suffices;
/// `reached` is the time of a known tour.
pub fn shortest(travel: &TravelTimes, reached: f64, meter: &mut Meter<'_>) -> f64 {
    let count = travel.from_start_s.len() + 1;
    let leg = |from: usize, to: usize| match (from.checked_sub(1), to.checked_sub(1)) {
        (Some(from), Some(to)) => travel.between_s_min(from, to),
        (None, Some(to)) => travel.start_to_s_min(to),
        (Some(from), None) => travel.to_base_s_min(from),
        (None, None) => UNREACHABLE_S,
    };
    let legs: Vec<Vec<f64>> = (0..count)
        .map(|from| (0..count).map(|to| leg(from, to).min(leg(to, from)).min(UNREACHABLE_S)).collect())
        .collect();
    if count <= 2 {
        let there_and_back = travel.start_to_s_min(0) + travel.to_base_s_min(0);
        return if count == 2 { there_and_back } else { 0.0 };
    }
    let whole = legs.iter().flatten().all(|leg| *leg >= UNREACHABLE_S || *leg == libm::floor(*leg));
    let mut prices = vec![0.0; count];
    let (mut best, mut share, mut stale) = (0.0_f64, 1.0, 0);
    for round in 0..(LOOKS_MAX / (count * count)).clamp(ROUNDS.0, ROUNDS.1) {
        // A single tree is fast.
        if round > 0 && meter.left_ns() <= 0.0 {
            meter.cut();
            break;
        }
        meter.spend((count * count) as f64 * LOOK_NS);
        let (length, degrees) = tree(&legs, &prices);
        if length > best + 1e-7 * reached.abs() {
            (best, stale) = (length, 0);
        } else {
            stale += 1;
            if stale >= PATIENCE {
                (share, stale) = (0.5 * share, 0);
            }
        }
        let norm: f64 = degrees.iter().map(|degree| (degree - 2.0) * (degree - 2.0)).sum();
        if norm == 0.0 || share < 1e-4 {
            break;
        }
        let step = share * (reached - length).max(1e-6 * reached.abs()) / norm;
        for (price, degree) in prices.iter_mut().zip(&degrees) {
            *price += step * (degree - 2.0);
        }
    }
    let proven = best * (1.0 - ROUNDING);
    if whole { libm::ceil(proven - 1e-6) } else { proven }
}

/// Returns the length of the shortest tree with two edges at the depot under the multipliers, less twice their sum, and each node's
/// degree.
fn tree(legs: &[Vec<f64>], prices: &[f64]) -> (f64, Vec<f64>) {
    let count = legs.len();
    let price = |node: usize| prices.get(node).copied().unwrap_or(0.0);
    let leg = |from: usize, to: usize| {
        let leg = legs.get(from).and_then(|row| row.get(to)).copied().unwrap_or(UNREACHABLE_S);
        leg + price(from) + price(to)
    };
    let mut degrees = vec![0.0; count];
    let mut count_edge = |from: usize, to: usize| {
        for node in [from, to] {
            if let Some(degree) = degrees.get_mut(node) {
                *degree += 1.0;
            }
        }
    };
    // Prim over all nodes but the depot.
    let mut nearest: Vec<(f64, usize)> = (0..count).map(|node| (leg(1, node), 1)).collect();
    let mut open: Vec<usize> = (2..count).collect();
    let mut length = 0.0;
    while let Some(slot) = (0..open.len()).min_by(|a, b| at(&nearest, &open, *a).total_cmp(&at(&nearest, &open, *b))) {
        let node = open.swap_remove(slot);
        let (near, from) = nearest.get(node).copied().unwrap_or((UNREACHABLE_S, 1));
        length += near;
        count_edge(from, node);
        for other in &open {
            let through = leg(node, *other);
            if let Some(known) = nearest.get_mut(*other).filter(|known| through < known.0) {
                *known = (through, node);
            }
        }
    }
    let mut ends: Vec<(f64, usize)> = (1..count).map(|node| (leg(0, node), node)).collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (leg, node) in ends.into_iter().take(2) {
        length += leg;
        count_edge(0, node);
    }
    (length - 2.0 * prices.iter().sum::<f64>(), degrees)
}

fn at(nearest: &[(f64, usize)], open: &[usize], slot: usize) -> f64 {
    open.get(slot).and_then(|node| nearest.get(*node)).map_or(f64::INFINITY, |(near, _)| *near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;
    use proptest::prelude::*;

    fn exhaustive(travel: &TravelTimes, path: &mut Vec<usize>, length: f64, best: &mut f64) {
        let count = travel.from_start_s.len();
        if path.len() == count {
            *best = best.min(length + travel.to_base(path[count - 1]));
            return;
        }
        for next in 0..count {
            if !path.contains(&next) {
                let leg = path.last().map_or(travel.start_to(next), |last| travel.between(*last, next));
                path.push(next);
                exhaustive(travel, path, length + leg, best);
                path.pop();
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn no_tour_is_shorter(count in 1..8usize, seed in 0..10_000u64, whole: bool, slack in 1.0..1.5f64) {
            let mut travel = examples::random(count, seed).travel;
            if whole {
                let round = |times: &mut Vec<f64>| times.iter_mut().for_each(|time_s| *time_s = time_s.round());
                round(&mut travel.from_start_s);
                round(&mut travel.to_base_s);
                travel.between_s.iter_mut().for_each(round);
            }
            let mut best = f64::INFINITY;
            exhaustive(&travel, &mut Vec::new(), 0.0, &mut best);
            let bound = shortest(&travel, slack * best, &mut Meter::new(&mut WorkBudget::new(u64::MAX)));
            prop_assert!(bound <= best * (1.0 + 1e-9), "{bound} {best}");
            prop_assert!(bound >= 0.5 * best, "{bound} {best}");
        }
    }
}

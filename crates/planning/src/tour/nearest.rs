//! Nearest-neighbour tour: each visit is followed by the nearest target that is not in the tour yet. Bound: O(n^2).

use crate::solver::Budget;
use crate::surveillance::scenario::Scenario;

/// Work per examined target, in nanoseconds.
const LOOK_NS: u64 = 3;

/// Returns all `targets` in nearest-neighbour order, beginning with the one nearest to `from` (`None`: the start).
pub fn cycle_from(
    scenario: &Scenario<'_>,
    from: Option<usize>,
    targets: &[usize],
    budget: &mut dyn Budget,
) -> Vec<usize> {
    let travel = &scenario.problem().travel;
    let mut open = targets.to_vec();
    let mut cycle = Vec::with_capacity(open.len());
    let (mut place, mut now_s) = (from, 0.0);
    while !open.is_empty() {
        scenario.charge(open.len() as u64 * (LOOK_NS + scenario.departure_ns()), budget);
        let time_s = |target: usize| {
            place.map_or_else(|| travel.start_to_at(target, now_s), |place| travel.between_at(place, target, now_s))
        };
        let nearest = open.iter().enumerate().min_by(|(_, a), (_, b)| time_s(**a).total_cmp(&time_s(**b)));
        let Some((slot, target)) = nearest.map(|(slot, target)| (slot, *target)) else { break };
        now_s += time_s(target) + scenario.problem().targets.get(target).map_or(0.0, |target| target.dwell_s);
        open.remove(slot);
        cycle.push(target);
        place = Some(target);
    }
    cycle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::surveillance as examples;
    use crate::solver::WorkBudget;

    #[test]
    fn the_nearest_comes_next() {
        let problem = examples::random(6, 3);
        let scenario = Scenario::new(&problem).unwrap();
        let cycle = cycle_from(&scenario, None, scenario.usable(), &mut WorkBudget::new(1000));
        let mut sorted = cycle.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, vec![0, 1, 2, 3, 4, 5]);
        let first = problem.travel.from_start_s[cycle[0]];
        assert!(problem.travel.from_start_s.iter().all(|time_s| *time_s >= first));
    }
}

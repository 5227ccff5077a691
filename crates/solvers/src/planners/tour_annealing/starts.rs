//! Starting tours of the search: first those of the other planners with little work, later with more work, and the best cycles of groups
//! of near targets.
//!
//! If the next group of targets is far away, annealing does not leave the group of its first tour. Tours that start elsewhere are
//! therefore tried, each once it costs only a small share of the work done so far.
//! Bound: what the other planners take, and O(targets) for the groups.

use super::annealing::{Annealing, CostedTour};
use super::{Share, TEMPERATURES, round};
use crate::planners::{two_opt, wam};
use apex_model::problem::Plan;
use apex_planning::solver::Budget;
use apex_planning::surveillance::previous;
use apex_planning::surveillance::scenario::Scenario;
use std::collections::VecDeque;

/// Work of each of the planners for the first tour: little for both.
const QUICK_UNITS: u64 = 2_000;
/// Starts may take one part in this many of the work after the first tour.
const START_SHARE: u64 = 4;
/// Work of the search from the first tour before other starts are tried.
const ALONE_UNITS: u64 = 20_000;
/// Least allowed work before a start.
const START_UNITS_MIN: u64 = 4_000;
/// Moves of the first round from a start.
const TRIAL_MOVES: u64 = 8_000;
/// A start is improved by a longer round if its cost is below this multiple of the least known cost.
const NEAR: f64 = 1.01;
/// Groups with fewer targets are not halved.
const GROUP_MIN: usize = 3;
/// Number of halvings of groups.
const HALVINGS: usize = 2;

/// Returns the best of the previous plan, the best cycle and WAM's tour, the latter two found with little work.
pub(super) fn first(scenario: &Scenario<'_>, previous: Option<&Plan>, budget: &mut dyn Budget) -> Vec<usize> {
    let cycle = best_cycle(scenario, QUICK_UNITS, budget);
    let until = budget.used().saturating_add(QUICK_UNITS);
    let tour = wam::best_word(scenario, &mut Share { whole: &mut *budget, until }, &mut |_| {});
    let cost = |tour: &[usize], budget: &mut dyn Budget| scenario.cost(tour.iter().copied(), budget);
    let quick = if cost(&cycle, budget) <= cost(&tour, budget) { cycle } else { tour };
    let quick_cost = cost(&quick, budget);
    previous::better(scenario, previous, quick_cost, budget).map_or(quick, |(_, tour)| tour)
}

/// Returns the tour that flies the best cycle found with `units` of work.
fn best_cycle(scenario: &Scenario<'_>, units: u64, budget: &mut dyn Budget) -> Vec<usize> {
    let until = budget.used().saturating_add(units);
    let cycle = two_opt::best_cycle(scenario, None, &mut Share { whole: budget, until }, &mut |_, _| {}).1;
    scenario.flown(cycle.iter().copied().cycle())
}

/// One heuristic for a starting tour.
#[derive(Clone, Debug)]
enum StartHeuristic {
    /// 2-Opt with more work.
    TwoOpt,
    /// The best beginning of the shortest tour of a group.
    Group(Vec<usize>),
    /// A pass of WAM.
    Wam(usize),
}

/// The starts that have not been tried yet.
#[derive(Debug)]
pub(super) struct Starts {
    ways: VecDeque<StartHeuristic>,
    /// Least allowed work for which a start is tried.
    least_units: u64,
    /// Work of a pass of WAM per unit of its weight, as far as is known; zero before the first.
    wam_units: f64,
    /// Work that starts have taken.
    taken: u64,
}

impl Starts {
    /// Returns all start heuristics. The first tour took `first_units`, which with many targets is more than its limit.
    pub(super) fn new(scenario: &Scenario<'_>, first_units: u64) -> Starts {
        let mut ways: VecDeque<StartHeuristic> = VecDeque::from([StartHeuristic::TwoOpt]);
        ways.extend(groups(scenario).into_iter().map(StartHeuristic::Group));
        ways.extend((1..wam::passes()).map(StartHeuristic::Wam));
        Starts { ways, least_units: first_units.max(START_UNITS_MIN), wam_units: 0.0, taken: 0 }
    }

    /// Tries the next tours for which there is time: each with a short round and, if that comes near to `cost`, with a longer one.
    /// Returns a tour that costs less.
    pub(super) fn try_next(
        &mut self,
        annealing: &mut Annealing<'_, '_>,
        moves: u64,
        cost: f64,
        budget: &mut dyn Budget,
    ) -> Option<CostedTour> {
        let mut best: Option<CostedTour> = None;
        loop {
            let before = budget.used();
            let allowed = (before.saturating_sub(ALONE_UNITS) / START_SHARE).saturating_sub(self.taken);
            let Some(tour) = self.next(annealing.scenario, allowed, budget) else {
                self.taken += budget.used() - before;
                return best;
            };
            let least = best.as_ref().map_or(cost, |best| best.0);
            let mut found = annealing.round(&tour, round(&tour, TRIAL_MOVES, TEMPERATURES), budget);
            if found.0 < least * NEAR {
                let longer = round(&found.1, (moves / 4).max(TRIAL_MOVES), TEMPERATURES);
                found = annealing.round(&found.1, longer, budget);
            }
            if found.0 < least {
                best = Some(found);
            }
            self.taken += budget.used() - before;
        }
    }

    /// Returns the next tour, if there is one and its work is permitted.
    fn next(&mut self, scenario: &Scenario<'_>, allowed: u64, budget: &mut dyn Budget) -> Option<Vec<usize>> {
        let known = match self.ways.front()? {
            StartHeuristic::Wam(number) => (self.wam_units * wam::weight(*number)) as u64,
            _ => 0,
        };
        if allowed < known.max(self.least_units) || budget.exhausted() {
            return None;
        }
        let before = budget.used();
        let until = before.saturating_add(allowed);
        match self.ways.pop_front()? {
            StartHeuristic::TwoOpt => Some(best_cycle(scenario, allowed, budget)),
            StartHeuristic::Group(group) => {
                let cycle = two_opt::cycle_of(scenario, &group, &mut Share { whole: budget, until });
                Some(scenario.flown(cycle.iter().copied().cycle()))
            }
            StartHeuristic::Wam(number) => {
                let tour = wam::pass(scenario, number, &mut Share { whole: &mut *budget, until });
                self.wam_units = (budget.used() - before) as f64 / wam::weight(number);
                if tour.is_none() {
                    // The start needs more work than permitted: it is tried again when twice as much is available.
                    self.wam_units *= 2.0;
                    self.ways.push_front(StartHeuristic::Wam(number));
                }
                tour
            }
        }
    }
}

/// Returns groups of near targets: all targets divided in two, and each of these groups in two.
fn groups(scenario: &Scenario<'_>) -> Vec<Vec<usize>> {
    let mut groups = Vec::new();
    let mut last = vec![scenario.usable().to_vec()];
    for _ in 0..HALVINGS {
        last = last.iter().filter(|group| group.len() >= GROUP_MIN).flat_map(|group| halves(scenario, group)).collect();
        groups.extend(last.iter().cloned());
    }
    groups
}

/// Divides a group in two by two places that are far apart: each target joins the nearer one.
fn halves(scenario: &Scenario<'_>, group: &[usize]) -> [Vec<usize>; 2] {
    let travel = scenario.typical();
    let way_s = |from: usize, to: usize| travel.between(from, to) + travel.between(to, from);
    let furthest = |from: usize| {
        let furthest = group.iter().copied().max_by(|a, b| way_s(from, *a).total_cmp(&way_s(from, *b)));
        furthest.unwrap_or(from)
    };
    let one = group.first().map_or(0, |first| furthest(*first));
    let other = furthest(one);
    let (near, far) = group.iter().partition(|target| way_s(one, **target) <= way_s(other, **target));
    [near, far]
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;
    use apex_portfolio::cell::Cell;
    use proptest::prelude::*;

    #[test]
    fn two_clusters_are_the_first_two_groups() {
        let cell: Cell = "large-fixed-fixed-16-two-cluster".parse().unwrap();
        let problem = cell.mission(0);
        let scenario = Scenario::new(&problem).unwrap();
        let groups = groups(&scenario);
        let (within, across): (Vec<f64>, Vec<f64>) =
            groups[..2].iter().fold((vec![], vec![]), |(mut near, mut far), group| {
                for from in group {
                    for to in scenario.usable().iter().filter(|to| *to != from) {
                        let way_s = scenario.typical().between(*from, *to);
                        if group.contains(to) { near.push(way_s) } else { far.push(way_s) }
                    }
                }
                (near, far)
            });
        let longest = within.iter().copied().fold(0.0, f64::max);
        assert!(across.iter().all(|way_s| *way_s > longest), "{groups:?}");
    }

    #[test]
    fn what_other_planners_find_with_time_is_not_missed() {
        // In this problem 2-Opt with little work starts in the worse cluster, and annealing never leaves it.
        let cell: Cell = "large-fixed-fixed-16-two-cluster".parse().unwrap();
        let problem = cell.mission(0);
        let scenario = Scenario::new(&problem).unwrap();
        let cycle = two_opt::best_cycle(&scenario, None, &mut WorkBudget::new(50_000), &mut |_, _| {}).0;
        let mut budget = WorkBudget::new(200_000);
        let start = first(&scenario, None, &mut budget);
        let quick = scenario.cost(start.iter().copied(), &mut budget);
        let found = super::super::search(&scenario, start, 1, &mut budget, &mut |_| {});
        assert!(scenario.cost(found, &mut budget) < cycle && cycle < quick);
    }

    proptest! {
        #[test]
        fn halves_hold_every_target_once(seed in 0_u64..500, count in 3_usize..30) {
            let problem = examples::random(count, seed);
            let scenario = Scenario::new(&problem).unwrap();
            let mut both = halves(&scenario, scenario.usable()).concat();
            both.sort_unstable();
            prop_assert_eq!(both, scenario.usable());
        }
    }

    #[test]
    fn with_many_targets_a_pass_that_takes_too_much_waits() {
        let problem = examples::random(300, 1);
        let scenario = Scenario::new(&problem).unwrap();
        let mut annealing = Annealing::new(&scenario, 1);
        let mut starts = Starts::new(&scenario, 0);
        starts.ways = VecDeque::from([StartHeuristic::Wam(4)]);
        let mut budget = WorkBudget::new(u64::MAX);
        budget.charge(ALONE_UNITS + START_SHARE * 50_000);
        assert!(starts.try_next(&mut annealing, 2_000, f64::INFINITY, &mut budget).is_none());
        assert_eq!(starts.ways.len(), 1, "not abandoned");
        // A pass checks the budget once a visit.
        assert!((50_000..60_000).contains(&starts.taken), "{}", starts.taken);
        let before = budget.used();
        assert!(starts.try_next(&mut annealing, 2_000, f64::INFINITY, &mut budget).is_none());
        assert_eq!(budget.used(), before, "waits");
    }

    #[test]
    fn starts_end_and_keep_their_share() {
        let problem = examples::random(5, 1);
        let scenario = Scenario::new(&problem).unwrap();
        let mut annealing = Annealing::new(&scenario, 1);
        let mut starts = Starts::new(&scenario, 0);
        let mut budget = WorkBudget::new(u64::MAX);
        budget.charge(10_000_000);
        starts.try_next(&mut annealing, 2_000, 0.0, &mut budget);
        assert!(starts.ways.is_empty());
        assert!(starts.taken < 10_000_000 / START_SHARE);
    }
}

//! Modified 2-Opt (paper, section V.C): the best repeatable cycle over a set or subset of targets.
//!
//! For a given set the cycle is the shortest directed tour: exact for up to nine targets, otherwise by 2-opt and Or-opt from several
//! starts. Targets are then dropped, added and exchanged, and the first target of the cycle is changed, as long as the expected cost of
//! ignorance over the horizon falls. At last the order itself is improved by the cost if targets differ: with equal targets and linear
//! cost the shortest tour is the best in the long run, and is kept.
//! Bound: none but the budget.

mod order;
mod report;
mod subset;

use self::report::CycleObserver;
use apex_model::problem::{CostFunction, Plan, Problem, SurveillanceProblem};
use apex_planning::solver::{Budget, Environment, Solver};
use apex_planning::surveillance::previous;
use apex_planning::surveillance::scenario::Scenario;
use apex_planning::tour;

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct TwoOpt;

impl Solver for TwoOpt {
    fn name(&self) -> &'static str {
        "two-opt"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else {
            return Err("the solver `two-opt` accepts surveillance problems only".to_string());
        };
        let scenario = Scenario::new(problem)?;
        let report = &mut *environment.report;
        let left = previous::better(&scenario, environment.previous, f64::INFINITY, environment.budget);
        let least = left.as_ref().map_or(f64::INFINITY, |(cost, word)| {
            report(&Plan::Surveillance(scenario.plan("two-opt", word.iter().copied())));
            *cost
        });
        let start = previous::cycle(&scenario, environment.previous);
        let (cost, cycle) = best_cycle(&scenario, start, environment.budget, &mut |cost, cycle| {
            if cost < least {
                report(&Plan::Surveillance(scenario.cycle_plan("two-opt", cycle)));
            }
        });
        // The plan in execution may be better than any cycle.
        let plan = match left {
            Some((least, word)) if least < cost => scenario.plan(self.name(), word),
            _ => scenario.cycle_plan(self.name(), &cycle),
        };
        Ok(Plan::Surveillance(plan))
    }
}

/// Returns the best repeatable cycle found within the budget, with its cost, starting from the cycle `start` if there is one; `report`
/// receives each better one.
pub fn best_cycle(
    scenario: &Scenario<'_>,
    start: Option<Vec<usize>>,
    budget: &mut dyn Budget,
    report: CycleObserver<'_>,
) -> (f64, Vec<usize>) {
    let mut search = subset::SubsetSearch::new(scenario);
    if let Some(start) = start {
        search.offer(start, budget, report);
    }
    let all = tour::shortest(scenario, scenario.usable(), budget);
    search.offer(all, budget, report);
    search.descend(budget, report);
    search.grow_from_one(budget, report);
    if !targets_are_equal(scenario.problem()) {
        // Where the horizon ends within a lap, even the nearest-neighbour order may do better than the shortest tour.
        let nearest = tour::nearest::cycle_from(scenario, None, scenario.usable(), budget);
        search.offer(nearest, budget, report);
        order::refine(&mut search, budget, report);
    }
    (search.best_cost, search.into_best())
}

/// Returns the shortest tour of `targets` found within the budget, starting at the target for which repeated flying costs least.
pub fn cycle_of(scenario: &Scenario<'_>, targets: &[usize], budget: &mut dyn Budget) -> Vec<usize> {
    let tour = tour::shortest(scenario, targets, budget);
    subset::best_beginning(scenario, tour, budget).1
}

/// Returns true if all targets are equal with linear cost: the best cycle in the long run is then the shortest tour.
fn targets_are_equal(problem: &SurveillanceProblem) -> bool {
    let Some(first) = problem.targets.first() else { return true };
    matches!(first.cost, CostFunction::Linear { .. })
        && problem
            .targets
            .iter()
            .all(|target| target.cost == first.cost && target.rate == first.rate && target.dwell_s == first.dwell_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planners::nearest_neighbour::NearestNeighbour;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;
    use proptest::prelude::*;

    fn solve(solver: &dyn Solver, problem: &SurveillanceProblem, units: u64) -> apex_model::problem::SurveillancePlan {
        let mut budget = WorkBudget::new(units);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        match solver.solve(&Problem::Surveillance(problem.clone()), &mut environment).unwrap() {
            Plan::Surveillance(plan) => plan,
            Plan::SingleVisit(_) => panic!("a surveillance problem has a surveillance plan"),
        }
    }

    /// Returns the length of the shortest directed tour, by trying all.
    fn exhaustive(problem: &SurveillanceProblem) -> f64 {
        fn extend(problem: &SurveillanceProblem, path: &mut Vec<usize>, length: f64, best: &mut f64) {
            let (count, last) = (problem.targets.len(), *path.last().unwrap());
            if path.len() == count {
                *best = best.min(length + problem.travel.between(last, 0));
                return;
            }
            for next in 1..count {
                if !path.contains(&next) {
                    path.push(next);
                    extend(problem, path, length + problem.travel.between(last, next), best);
                    path.pop();
                }
            }
        }
        let mut best = f64::INFINITY;
        extend(problem, &mut vec![0], 0.0, &mut best);
        best
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn equal_targets_get_the_optimal_tour(count in 3..8usize, seed in 0..1_000_000u64) {
            let problem = examples::equal(count, seed);
            let plan = solve(&TwoOpt, &problem, 40_000);
            prop_assert_eq!(plan.cycle.len(), count);
            let index = |name: &String| problem.targets.iter().position(|target| target.name == *name).unwrap();
            let cycle: Vec<usize> = plan.cycle.iter().map(index).collect();
            let length = tour::length(&cycle, |from, to| problem.travel.between(from, to));
            prop_assert!((length - exhaustive(&problem)).abs() < 1e-6, "{length} {}", exhaustive(&problem));
        }

        #[test]
        fn never_worse_than_nearest_neighbour(count in 2..17usize, seed in 0..1_000_000u64) {
            let problem = examples::random(count, seed);
            let simple = solve(&NearestNeighbour, &problem, 100_000);
            let better = solve(&TwoOpt, &problem, 100_000);
            prop_assert!(better.expected_cost <= simple.expected_cost * (1.0 + 1e-9));
        }
    }

    #[test]
    fn equal_seed_and_budget_give_an_equal_plan() {
        let problem = examples::random(12, 4);
        assert_eq!(solve(&TwoOpt, &problem, 5_000), solve(&TwoOpt, &problem, 5_000));
    }

    #[test]
    fn a_target_not_worth_the_way_is_left_out() {
        let mut problem = examples::random(5, 8);
        for other in 0..4 {
            problem.travel.between_s[4][other] += 1500.0;
            problem.travel.between_s[other][4] += 1500.0;
        }
        problem.targets[4].cost = CostFunction::Saturating { maximum: 0.001, rate_per_s: 1e-3 };
        let plan = solve(&TwoOpt, &problem, 100_000);
        let left_out = plan.left_out.iter().find(|left_out| left_out.target == "T4").unwrap();
        assert!(left_out.reason.contains("raise the expected cost"), "{left_out:?}");
    }
}

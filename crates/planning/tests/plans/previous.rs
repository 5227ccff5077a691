//! Plans computed again from the remaining part of an earlier one.

use apex_model::problem::{Plan, Problem, SurveillancePlan, SurveillanceProblem};
use apex_planning::examples::surveillance as examples;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_planning::surveillance::previous;
use apex_planning::surveillance::scenario::Scenario;
use apex_solvers::planners::{tour_annealing::TourAnnealing, two_opt::TwoOpt, wam::Wam};
use proptest::prelude::*;

fn plan(solver: &dyn Solver, problem: &SurveillanceProblem, units: u64, previous: Option<&Plan>) -> SurveillancePlan {
    let problem = Problem::Surveillance(problem.clone());
    let mut reported = f64::INFINITY;
    let mut report = |plan: &Plan| match plan {
        Plan::Surveillance(plan) => reported = reported.min(plan.expected_cost),
        Plan::SingleVisit(_) => panic!("of another kind"),
    };
    let mut budget = WorkBudget::new(units);
    let mut environment = Environment { seed: 7, budget: &mut budget, report: &mut report, previous };
    let plan = solver.solve(&problem, &mut environment).unwrap();
    assert_eq!(apex_planning::checker::violations(&problem, &plan), Vec::<String>::new());
    match plan {
        Plan::Surveillance(plan) => {
            assert!(plan.expected_cost <= reported * (1.0 + 1e-9), "a better plan was reported before");
            plan
        }
        Plan::SingleVisit(_) => panic!("of another kind"),
    }
}

/// Returns the problem some time later: one target is gone, another is more expensive, the vehicle is elsewhere, less time remains.
fn changed(problem: &SurveillanceProblem, seed: u64) -> SurveillanceProblem {
    let mut changed = examples::random(problem.targets.len(), seed);
    changed.targets = problem.targets.clone();
    changed.travel.between_s = problem.travel.between_s.clone();
    changed.horizon_s = 0.8 * problem.horizon_s;
    changed.targets[0].name = "another".into();
    changed.targets[1].rate = apex_model::problem::EventRate::constant(3.0);
    changed
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn a_new_plan_is_never_worse_than_what_is_left_of_the_old_one(count in 3..14usize, seed in 0..1_000_000u64) {
        let problem = examples::random(count, seed);
        let planners: [&dyn Solver; 3] = [&TwoOpt, &Wam, &TourAnnealing];
        for old in planners {
            let old = Plan::Surveillance(plan(old, &problem, 20_000, None));
            let changed = changed(&problem, seed + 1);
            let scenario = Scenario::new(&changed).unwrap();
            let left = previous::word(&scenario, Some(&old)).unwrap();
            let cost = scenario.cost(left, &mut WorkBudget::new(u64::MAX));
            for new in planners {
                // With so little work, a planner without the previous plan would often be worse.
                let with = plan(new, &changed, 1, Some(&old)).expected_cost;
                prop_assert!(with <= cost * (1.0 + 1e-9), "{}: {with} {cost}", new.name());
            }
        }
    }
}

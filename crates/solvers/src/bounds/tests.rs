//! Bounds hold for every plan of small problems, are tight where they must be, and equal the values of their certificates.

use super::*;
use crate::planners::tour_annealing::TourAnnealing;
use apex_model::problem::{CostFunction, EventRate, Plan, Problem};
use apex_planning::examples::surveillance as examples;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_planning::surveillance::scenario::Scenario;
use proptest::prelude::*;

fn families() -> impl Strategy<Value = CostFunction> {
    prop_oneof![
        (0.1..2.0f64).prop_map(|cost_per_s| CostFunction::Linear { cost_per_s }),
        (0.1..2.0f64, 1e-4..1e-1f64).prop_map(|(maximum, rate_per_s)| CostFunction::Saturating { maximum, rate_per_s }),
        (10.0..400.0f64, 0.1..2.0f64).prop_map(|(deadline_s, maximum)| CostFunction::Step { deadline_s, maximum }),
        (0.1..2.0f64, 1e-3..0.1f64, 0.0..400.0f64)
            .prop_map(|(maximum, rate_per_s, midpoint_s)| CostFunction::Logistic { maximum, rate_per_s, midpoint_s }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn no_tour_costs_less(
        seed in 0..1000_u64, cost in families(), other in families(), home: bool, age in 0.0..300.0f64,
        later in 0.1..3.0f64, horizon in 200.0..900.0f64, turn in prop::option::of(0.2..0.9f64),
    ) {
        // All sequences of up to seven visits to three targets, one of which has a rate that changes. The wind may change on the way.
        let mut problem = match turn {
            Some(share) => examples::turning(3, seed, 3_000.0, share * horizon),
            None => examples::sized(3, seed, 3_000.0),
        };
        problem.horizon_s = horizon;
        problem.return_to_base = home;
        problem.targets[0].cost = cost;
        problem.targets[1].cost = other;
        problem.targets[1].initial_age_s = age;
        problem.targets[2].rate = EventRate { steps: vec![(0.0, 1.0), (0.5 * horizon, later)] };
        prop_assume!(Scenario::new(&problem).is_ok());
        let scenario = Scenario::new(&problem).unwrap();
        let quick = simplified(&problem);
        let of_price = price::expected_cost(&quick);
        prop_assert_eq!(price::at_price(&quick, of_price.price_per_s), of_price.expected_cost);
        let (of_absences, multipliers) = revisit_gaps::expected_cost(&quick, &mut Meter::new(&mut WorkBudget::new(u64::MAX))).unwrap();
        prop_assert!((revisit_gaps::verified(&quick, &multipliers) - of_absences.max(0.0)).abs() <= 1e-12 * of_absences.abs());
        let mut least = f64::INFINITY;
        for number in 0..3_usize.pow(7) {
            let word = (0..7).map(|place| number / 3_usize.pow(place) % 3);
            for length in [0, 1, 2, 3, 4, 5, 6, 7] {
                least = least.min(scenario.cost(word.clone().take(length), &mut WorkBudget::new(1)));
            }
        }
        prop_assert!(of_price.expected_cost <= least * (1.0 + 1e-9), "{of_price:?} {least}");
        prop_assert!(of_absences <= least * (1.0 + 1e-9), "{of_absences} {least}");
        let best = expected_cost(&problem);
        prop_assert!(best.expected_cost >= 0.0 && best.expected_cost <= least * (1.0 + 1e-9));
        prop_assert!((verified(&problem, &best.proof) - best.expected_cost).abs() <= 1e-9 * best.expected_cost.abs());
    }
}

#[test]
fn one_target_that_is_watched_all_the_time_costs_next_to_nothing() {
    let mut problem = examples::equal(1, 3);
    problem.targets[0].cost = CostFunction::Linear { cost_per_s: 1.0 };
    problem.travel.from_start_s[0] = 0.0;
    problem.horizon_s = 1_000.0;
    let bound = expected_cost(&problem);
    // 100 observations of 10 s each leave 100 intervals of 10 s; the bound does not count intervals within a stay.
    assert!(bound.expected_cost >= 0.0 && bound.expected_cost <= 5_000.0, "{bound:?}");
}

#[test]
fn bounds_of_test_missions_are_below_good_plans_and_not_far() {
    let mut ratios = Vec::new();
    for cell in apex_portfolio::cell::Cell::subset() {
        let problem = cell.mission(0);
        let mut budget = WorkBudget::new(6_000);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        let plan = TourAnnealing.solve(&Problem::Surveillance(problem.clone()), &mut environment).unwrap();
        let Plan::Surveillance(plan) = plan else { panic!("{plan:?}") };
        let bound = expected_cost(&problem).expected_cost;
        assert!(bound <= plan.expected_cost, "{cell}: {bound} {}", plan.expected_cost);
        ratios.push(bound / plan.expected_cost);
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!("{mean} {ratios:?}");
    assert!(mean > 0.9, "{mean} {ratios:?}");
}

/// Returns the bound without waiting that `units` of work prove, checked to be valid, with the work used, and true if the proof is
/// complete.
fn within(problem: &SurveillanceProblem, units: u64) -> (f64, u64, bool) {
    let mut budget = WorkBudget::new(units);
    let mut meter = Meter::new(&mut budget);
    let found = expected_cost_without_waiting_within(problem, &mut meter);
    let again = verified(problem, &found.proof);
    assert!((again - found.expected_cost).abs() <= 1e-9 * found.expected_cost.abs(), "{again} {found:?}");
    (found.expected_cost, meter.used(), meter.is_complete())
}

#[test]
fn a_small_budget_proves_less_reports_it_and_is_kept() {
    for count in [3, 4, 12] {
        let problem = examples::random(count, 5);
        let mut environment =
            Environment { seed: 1, budget: &mut WorkBudget::new(20_000), report: &mut |_| {}, previous: None };
        let plan = TourAnnealing.solve(&Problem::Surveillance(problem.clone()), &mut environment).unwrap();
        let Plan::Surveillance(plan) = plan else { panic!("{plan:?}") };
        let (all, needed, complete) = within(&problem, u64::MAX);
        assert!(complete && all <= plan.expected_cost, "{count}: {all} {}", plan.expected_cost);
        assert_eq!(within(&problem, 2 * needed + 1), (all, needed, true), "half is for cycles");
        let mut before = 0.0;
        for share in [1_000, 30, 4] {
            let (proven, used, complete) = within(&problem, needed / share);
            // The fast bound and the smallest program are computed whatever the budget is.
            assert!(used <= needed / share * 5 / 4 + 3_000, "{count}: {used} of {needed} / {share}");
            assert!(!complete && proven <= all * (1.0 + 1e-9), "{count}: {proven} {all}");
            assert!(proven >= 0.9 * before, "{count}: {proven} after {before} with less");
            before = proven;
        }
    }
}

#[test]
fn nothing_to_spend_leaves_the_fast_bound() {
    let problem = examples::random(6, 5);
    let (proven, _, complete) = within(&problem, 0);
    assert_eq!((proven, complete), (price::expected_cost(&problem).expected_cost, false));
}

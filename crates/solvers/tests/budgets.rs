//! Single-visit plans by budget: the smallest budget gives a complete plan, and a larger one never a worse plan, with few and with many
//! targets.
#![allow(clippy::expect_used, clippy::panic, reason = "a test")]

use apex_model::problem::{Light, Plan, Position, Problem, SingleVisitPlan, SingleVisitProblem, WindField};
use apex_planning::examples::single_visit as examples;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_portfolio::formats::{self, generate};
use apex_solvers::planners::single_visit::SingleVisit;

fn solved(problem: &Problem, units: u64, seed: u64) -> SingleVisitPlan {
    let mut budget = WorkBudget::new(units);
    let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
    let plan = SingleVisit.solve(problem, &mut environment).expect("a plan");
    assert_eq!(apex_planning::checker::violations(problem, &plan), Vec::<String>::new());
    let Plan::SingleVisit(plan) = plan else { panic!("the plan is of another kind") };
    plan
}

/// Returns a flight through wind and around zones in which each target can be observed from several altitudes: the number of choices must
/// not delay the first plan.
fn with_altitudes(count: usize, seed: u64) -> SingleVisitProblem {
    let mut problem = examples::random(count, seed);
    for target in &mut problem.targets {
        let given = target.manoeuvres.clone();
        for step in 1..4 {
            target.manoeuvres.extend(given.iter().cloned().map(|mut manoeuvre| {
                manoeuvre.altitude_m -= 300.0 * f64::from(step);
                manoeuvre.quality.resolution.factor = 1.0 - 0.02 * f64::from(step);
                manoeuvre
            }));
        }
    }
    problem
}

#[test]
fn the_smallest_budget_has_a_whole_plan() {
    for seed in 1..6 {
        let problem = Problem::SingleVisit(with_altitudes(25, seed));
        let (first, later) = (solved(&problem, 1, seed), solved(&problem, 1_000_000, seed));
        assert!(first.benefits >= 0.5 * later.benefits, "seed {seed}: {} of {}", first.summary, later.summary);
    }
}

#[test]
fn more_budget_is_never_worse_through_wind_and_around_zones() {
    for seed in 1..4 {
        for count in [6, 25] {
            let problem = Problem::SingleVisit(with_altitudes(count, seed));
            let budgets = [1, 10_000, 30_000, 100_000, 200_000, 400_000];
            let scores: Vec<f64> = budgets.iter().map(|units| solved(&problem, *units, seed).score).collect();
            assert!(scores.is_sorted(), "{count} targets, seed {seed}: {scores:?}");
        }
    }
}

/// In calm air without zones, the paths between all targets are computed before the search. Their work was underestimated, so that a
/// planner with a budget of a few seconds continued far beyond it and was stopped without a plan.
#[test]
fn hundreds_of_near_targets_are_planned_within_the_budget() {
    let mut problem = examples::random(260, 1);
    (problem.zones, problem.wind, problem.landing_places) = (Vec::new(), WindField::default(), Vec::new());
    problem.landing_distance_m_max = None;
    problem.vehicle.turn_radius_m = 3_400.0;
    for target in &mut problem.targets {
        (target.windows, target.light, target.timing) = (Vec::new(), Light::Any, Vec::new());
        let Position { latitude_deg, longitude_deg, .. } = target.position;
        target.position = Position::new(35.0 + 0.2 * (latitude_deg - 34.0), -118.0 + 0.2 * (longitude_deg + 118.0));
        target.manoeuvres = examples::manoeuvres(target.position);
        target.manoeuvres.truncate(1);
    }
    problem.precedence = Vec::new();
    let problem = Problem::SingleVisit(problem);
    let mut scores = Vec::new();
    for units in [1, 100_000, 600_000, 1_500_000, 3_000_000] {
        let mut budget = WorkBudget::new(units);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        let plan = SingleVisit.solve(&problem, &mut environment).expect("a plan");
        assert!(budget.used <= units + 700_000, "{units}: {}", budget.used);
        let Plan::SingleVisit(plan) = plan else { panic!("the plan is of another kind") };
        scores.push(plan.score);
    }
    assert!(scores.is_sorted(), "{scores:?}");
}

#[test]
fn more_budget_is_never_worse_between_few_places() {
    for (name, text) in generate::windows_suite() {
        if !["c104", "r107", "r203", "pr05"].contains(&name.as_str()) {
            continue;
        }
        let whole = formats::read(&name, &text).expect("the project's own problem").problem;
        for count in [8, 20, 40] {
            let mut problem = whole.clone();
            problem.targets.truncate(count);
            if let Some(travel) = &mut problem.travel {
                travel.from_start_s.truncate(count);
                travel.to_base_s.truncate(count);
                travel.between_s.truncate(count);
                travel.between_s.iter_mut().for_each(|row| row.truncate(count));
            }
            let problem = Problem::SingleVisit(problem);
            for seed in 1..4 {
                let budgets = [300, 1_000, 2_000, 3_000, 5_000, 10_000, 20_000, 40_000, 100_000, 300_000, 1_000_000];
                let scores: Vec<f64> = budgets.iter().map(|units| solved(&problem, *units, seed).score).collect();
                assert!(scores.is_sorted(), "{name} with {count} targets, seed {seed}: {scores:?}");
            }
        }
    }
}

//! The checker accepts plans of solvers and rejects modified ones.

use apex_model::problem::{AirspaceZone, Plan, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan};
use apex_planning::checker::{accept, violations};
use apex_planning::examples::single_visit as fires;
use apex_planning::examples::surveillance as examples;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_solvers::planners::single_visit::SingleVisit;
use apex_solvers::{planners::two_opt::TwoOpt, solvers};
use proptest::prelude::*;

fn solve(solver: &dyn Solver, problem: &Problem, seed: u64, units: u64) -> Result<Plan, String> {
    let mut budget = WorkBudget::new(units);
    solver.solve(problem, &mut Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None })
}

fn surveillance() -> (Problem, SurveillancePlan) {
    let problem = Problem::Surveillance(examples::random(6, 2));
    let Ok(Plan::Surveillance(plan)) = solve(&TwoOpt, &problem, 1, 50_000) else { panic!("there is a plan") };
    (problem, plan)
}

fn fire() -> (SingleVisitProblem, SingleVisitPlan) {
    let problem = fires::western_states(40_000.0);
    let asked = Problem::SingleVisit(problem.clone());
    let Ok(Plan::SingleVisit(plan)) = solve(&SingleVisit, &asked, 1, 300_000) else { panic!("there is a plan") };
    (problem, plan)
}

fn complaints(problem: &SingleVisitProblem, plan: SingleVisitPlan) -> String {
    violations(&Problem::SingleVisit(problem.clone()), &Plan::SingleVisit(plan)).join("; ")
}

#[test]
fn tampered_surveillance_plans_are_refused() {
    let (problem, plan) = surveillance();
    assert_eq!(violations(&problem, &Plan::Surveillance(plan.clone())), Vec::<String>::new());
    let changed = |change: &dyn Fn(&mut SurveillancePlan)| {
        let mut plan = plan.clone();
        change(&mut plan);
        violations(&problem, &Plan::Surveillance(plan)).join("; ")
    };
    assert!(changed(&|plan| plan.visits[2].arrive_s -= 1.0).contains("before it can be there"));
    assert!(changed(&|plan| plan.visits[2].end_s -= 1.0).contains("too briefly"));
    assert!(changed(&|plan| plan.expected_cost *= 0.999).contains("claims an expected cost"));
    let boast = |plan: &mut SurveillancePlan| plan.expected_cost_bound = Some(1.01 * plan.expected_cost);
    assert!(changed(&boast).contains("claims that no plan costs less than"));
    assert!(changed(&|plan| plan.visits[0].target = "nowhere".into()).contains("not a target"));
    assert!(changed(&|plan| plan.visits.last_mut().unwrap().end_s = 4000.0).contains("after the horizon"));
    assert!(changed(&|plan| plan.visits.swap(1, 2)).contains("where its cycle has"));
}

#[test]
fn tampered_fire_plans_are_refused() {
    let (problem, plan) = fire();
    assert_eq!(complaints(&problem, plan.clone()), "");
    let changed = |change: &dyn Fn(&mut SingleVisitPlan)| {
        let mut plan = plan.clone();
        change(&mut plan);
        complaints(&problem, plan)
    };
    assert!(changed(&|plan| plan.visits[1].arrive_s -= 200.0).contains("allows"));
    assert!(changed(&|plan| plan.visits[1].worth += 1.0).contains("worth"));
    assert!(changed(&|plan| plan.visits[1].route = vec![]).contains("does not lead"));
    assert!(changed(&|plan| plan.visits[1].target = plan.visits[0].target.clone()).contains("twice"));
    assert!(changed(&|plan| plan.end_s += 40_000.0).contains("endurance reserve"));
    assert!(changed(&|plan| plan.fuel_used_kg = 1.0).contains("claims to burn"));
    assert!(changed(&|plan| plan.left_out.clear()).contains("no reason is given") || plan.left_out.is_empty());
    let message = accept(&Problem::Surveillance(examples::random(2, 1)), &Plan::SingleVisit(plan.clone())).unwrap_err();
    assert_eq!(message, "the plan of single-visit is not valid: it answers another kind of problem");
}

#[test]
fn a_zone_that_appears_on_the_way_is_noticed() {
    let (mut problem, plan) = fire();
    let first = apex_geo::geodesy::midpoint(problem.start, plan.visits[0].route[1]);
    let (latitude, longitude) = (first.latitude_deg, first.longitude_deg);
    let zone: AirspaceZone =
        fires::restricted("TFR-1", latitude - 0.2, latitude + 0.2, longitude - 0.2, longitude + 0.2);
    problem.zones.push(zone);
    assert!(complaints(&problem, plan).contains("enters restricted area TFR-1"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn every_solver_passes_on_random_surveillance(
        count in 1..14usize, seed in 0..100_000u64, home in any::<bool>(), side in 500.0..20_000.0f64,
    ) {
        let mut problem = examples::sized(count, seed, side);
        problem.return_to_base = home;
        problem.endurance_s = home.then_some(3000.0);
        let problem = Problem::Surveillance(problem);
        for solver in solvers().iter().filter(|solver| solver.serves(&problem)) {
            match solve(solver.as_ref(), &problem, seed, 20_000) {
                Ok(plan) => prop_assert_eq!(violations(&problem, &plan), Vec::<String>::new(), "{}", solver.name()),
                Err(reason) => prop_assert!(reason.starts_with("No target"), "{reason}"),
            }
        }
    }

    #[test]
    fn the_single_visit_planner_passes_on_random_missions(count in 1..12usize, seed in 0..100_000u64) {
        let problem = Problem::SingleVisit(fires::random(count, seed));
        match solve(&SingleVisit, &problem, seed, 30_000) {
            Ok(plan) => prop_assert_eq!(violations(&problem, &plan), Vec::<String>::new()),
            Err(reason) => prop_assert!(reason.starts_with("No target") || reason.starts_with("the start"), "{reason}"),
        }
    }
}

/// Returns a mission whose vehicle has a wide turn radius, with its plan.
fn turning(seed: u64, turn_radius_m: f64) -> (Problem, Result<Plan, String>) {
    turning_over(fires::random(5, seed), seed, turn_radius_m)
}

fn turning_over(mut problem: SingleVisitProblem, seed: u64, turn_radius_m: f64) -> (Problem, Result<Plan, String>) {
    problem.vehicle.turn_radius_m = turn_radius_m;
    let problem = Problem::SingleVisit(problem);
    let mut budget = WorkBudget::new(60_000);
    let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
    let plan = SingleVisit.solve(&problem, &mut environment);
    (problem, plan)
}

#[test]
fn plans_with_wide_turns_pass_and_without_their_turns_do_not() {
    let mut refused = 0;
    for seed in 0..12 {
        let (problem, plan) = turning(seed, 3_400.0);
        let Ok(plan) = plan else { continue };
        assert_eq!(violations(&problem, &plan), Vec::<String>::new(), "seed {seed}");
        let Plan::SingleVisit(mut straight) = plan else { panic!("of another kind") };
        assert!(straight.visits.iter().all(|visit| visit.path.len() > visit.route.len()), "seed {seed}");
        for visit in &mut straight.visits {
            visit.path.clear();
        }
        let found = violations(&problem, &Plan::SingleVisit(straight));
        refused += usize::from(found.iter().any(|what| what.contains("turns more tightly than 3400 m")));
    }
    assert!(refused >= 8, "{refused}");
}

#[test]
fn a_turn_back_over_a_place_that_is_looked_at_from_overhead_takes_its_time() {
    let (mut planned, mut slower_s) = (0, 0.0);
    for seed in 0..12 {
        let mut problem = fires::random(5, seed);
        problem.targets.iter_mut().flat_map(|target| &mut target.manoeuvres).for_each(|way| way.lines.clear());
        // The base is the start, and the vehicle crosses the target in the direction of its arrival.
        problem.targets.truncate(1);
        problem.precedence.clear();
        let (quick, slow) = (turning_over(problem.clone(), seed, 0.0), turning_over(problem, seed, 3_400.0));
        let (Ok(Plan::SingleVisit(quick)), Ok(Plan::SingleVisit(mut plan))) = (quick.1, slow.1) else { continue };
        assert_eq!(violations(&slow.0, &Plan::SingleVisit(plan.clone())), Vec::<String>::new(), "seed {seed}");
        planned += 1;
        if quick.visits[0].manoeuvre == plan.visits[0].manoeuvre && plan.return_route.len() == 2 {
            slower_s = f64::max(slower_s, plan.end_s - quick.end_s);
        }
        // The same plan without the turn is rejected.
        plan.return_path = plan.return_route.clone();
        let found = violations(&slow.0, &Plan::SingleVisit(plan));
        assert!(found.iter().any(|what| what.contains("turns more tightly than 3400 m")), "{found:?}");
    }
    // Half a circle of 3.4 km radius at some 95 m/s, plus a little to return to the line.
    assert!(planned >= 6 && slower_s > 100.0, "{planned} {slower_s}");
}

#[test]
fn a_plan_with_instant_turns_is_too_fast_for_a_vehicle_with_a_turn_radius() {
    let mut hasty = 0;
    for seed in 0..12 {
        let (_, plan) = turning(seed, 0.0);
        let (problem, _) = turning(seed, 3_400.0);
        hasty += usize::from(plan.is_ok_and(|plan| !violations(&problem, &plan).is_empty()));
    }
    assert!(hasty >= 8, "{hasty}");
}

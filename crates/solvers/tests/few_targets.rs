//! Missions of few targets: plans are the best ones, also where detours are shorter than direct ways, and reasons hold.
#![allow(clippy::expect_used, clippy::panic, clippy::indexing_slicing, reason = "a test")]

use apex_model::problem::{
    CostFunction, EventRate, LaterTimes, Manoeuvre, Plan, Position, Problem, SingleVisitPlan, SingleVisitProblem,
    SingleVisitTarget, SingleVisitVehicle, SurveillanceProblem, SurveillanceTarget, TimeWindow, TravelTimes,
};
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_solvers::planners::human::Human;
use apex_solvers::planners::single_visit::SingleVisit;

fn target(name: &str, value: f64, window: Option<(f64, f64)>, duration_s: f64) -> SingleVisitTarget {
    SingleVisitTarget {
        name: name.into(),
        value,
        manoeuvres: vec![Manoeuvre { name: "look".into(), duration_s, ..Manoeuvre::default() }],
        windows: window.into_iter().map(|(from_s, until_s)| TimeWindow { from_s, until_s }).collect(),
        ..SingleVisitTarget::default()
    }
}

fn problem(targets: Vec<SingleVisitTarget>, endurance_s: f64, travel: TravelTimes) -> SingleVisitProblem {
    SingleVisitProblem {
        targets,
        vehicle: SingleVisitVehicle { true_airspeed_mps: 20.0, endurance_s, ..SingleVisitVehicle::default() },
        base: Some(Position::new(0.0, 0.0)),
        travel: Some(travel),
        ..SingleVisitProblem::default()
    }
}

fn times(from_start_s: &[f64], between_s: &[&[f64]], to_base_s: &[f64]) -> TravelTimes {
    TravelTimes {
        from_start_s: from_start_s.to_vec(),
        between_s: between_s.iter().map(|row| row.to_vec()).collect(),
        to_base_s: to_base_s.to_vec(),
        later: Vec::new(),
    }
}

fn solved(solver: &dyn Solver, problem: &Problem) -> Plan {
    let mut budget = WorkBudget::new(200_000);
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
    solver.solve(problem, &mut environment).expect("a plan")
}

fn visited(solver: &dyn Solver, problem: &SingleVisitProblem) -> SingleVisitPlan {
    match solved(solver, &Problem::SingleVisit(problem.clone())) {
        Plan::SingleVisit(plan) => plan,
        Plan::Surveillance(_) => panic!("another kind of plan"),
    }
}

fn names(plan: &SingleVisitPlan) -> Vec<&str> {
    plan.visits.iter().map(|visit| visit.target.as_str()).collect()
}

/// The second target is in time for its window only by way of the first one.
#[test]
fn three_targets_are_visited_in_the_only_order_that_meets_all_windows() {
    let targets = vec![
        target("t0", 0.8, None, 0.0),
        target("t1", 1.6, Some((77.0, 177.0)), 0.0),
        target("t2", 1.0, Some((320.0, 420.0)), 0.0),
    ];
    let between_s: [&[f64]; 3] = [&[0.0, 7.0, 11.0], &[200.0, 0.0, 61.0], &[84.0, 131.0, 0.0]];
    let plan = visited(
        &SingleVisit,
        &problem(targets, 10_000.0, times(&[39.0, 180.0, 27.0], &between_s, &[14.0, 152.0, 292.0])),
    );
    assert_eq!(names(&plan), ["t0", "t1", "t2"]);
    assert_eq!(plan.benefits_bound, Some(plan.benefits), "all orders were compared");
}

/// From `a` the way home by way of `b` takes 40 s, the direct one 90 s.
#[test]
fn an_operators_order_goes_home_by_way_of_its_next_visit() {
    let targets = vec![target("a", 10.0, None, 0.0), target("b", 1.0, None, 0.0)];
    let between_s: [&[f64]; 2] = [&[50.0, 10.0], &[60.0, 50.0]];
    let posed = problem(targets, 100.0, times(&[40.0, 70.0], &between_s, &[90.0, 30.0]));
    let brought = Human { visits: vec!["a".into(), "b".into()], repeat: false };
    assert_eq!(names(&visited(&brought, &posed)), ["a", "b"]);
    assert_eq!(names(&visited(&SingleVisit, &posed)), ["a", "b"]);
}

/// 790 s until the window opens, 60 s of observation, 28 s home: 78 s more than 800 s.
#[test]
fn the_time_that_a_visit_lacks_includes_its_wait_and_the_way_home() {
    let targets = vec![target("late", 5.0, Some((790.0, 900.0)), 60.0), target("near", 1.0, None, 0.0)];
    let between_s: [&[f64]; 2] = [&[0.0, 40.0], &[40.0, 0.0]];
    let travel = times(&[35.0, 20.0], &between_s, &[28.0, 20.0]);
    let reason = |endurance_s: f64| {
        let plan = visited(&SingleVisit, &problem(targets.clone(), endurance_s, travel.clone()));
        plan.left_out.iter().find(|left_out| left_out.target == "late").map(|left_out| left_out.reason.clone())
    };
    assert_eq!(reason(800.0).as_deref(), Some("needs 2 min more than endurance leaves, even alone"));
    assert_eq!(reason(850.0).as_deref(), Some("needs 28 s more than endurance leaves, even alone"));
    assert_eq!(reason(877.0).as_deref(), Some("needs 1 s more than endurance leaves, even alone"));
    assert_eq!(reason(878.0), None);
}

#[test]
fn a_target_whose_timing_is_zero_in_its_windows_is_worth_nothing() {
    let mut idle = target("idle", 5.0, Some((0.0, 50.0)), 0.0);
    idle.timing = vec![(0.0, 0.0), (60.0, 0.0), (70.0, 1.0)];
    let targets = vec![idle, target("near", 1.0, None, 0.0)];
    let between_s: [&[f64]; 2] = [&[0.0, 10.0], &[10.0, 0.0]];
    let plan = visited(&SingleVisit, &problem(targets, 100.0, times(&[10.0, 10.0], &between_s, &[10.0, 10.0])));
    assert_eq!(names(&plan), ["near"]);
    assert!(plan.left_out[0].reason.starts_with("is worth nothing"), "{:?}", plan.left_out);
}

/// The direct way home is the shorter one for a departure at 0, the detour over `b` for a departure at 40 s.
#[test]
fn surveillance_goes_home_by_a_detour_that_is_faster_only_later() {
    let site = |name: &str, rate: f64| SurveillanceTarget {
        name: name.into(),
        rate: EventRate { steps: vec![(0.0, rate)] },
        cost: CostFunction::Linear { cost_per_s: 1.0 },
        position: Position::new(37.0, -122.0),
        dwell_s: 0.0,
        initial_age_s: 0.0,
    };
    let between_s: [&[f64]; 2] = [&[50.0, 10.0], &[60.0, 50.0]];
    let mut travel = times(&[40.0, 70.0], &between_s, &[20.0, 60.0]);
    travel.later = vec![LaterTimes {
        depart_s: 40.0,
        from_start_s: travel.from_start_s.clone(),
        between_s: travel.between_s.clone(),
        to_base_s: vec![70.0, 30.0],
    }];
    let posed = SurveillanceProblem {
        targets: vec![site("a", 10.0), site("b", 1.0)],
        travel,
        horizon_s: 100.0,
        return_to_base: true,
        endurance_s: None,
    };
    let brought = Human { visits: vec!["a".into(), "b".into()], repeat: false };
    assert_eq!(solved(&brought, &Problem::Surveillance(posed)).targets(), ["a", "b"]);
}

#[test]
fn windows_that_end_before_they_begin_and_unsorted_timings_are_refused() {
    let travel = times(&[10.0], &[&[0.0]], &[10.0]);
    let refused = |target: SingleVisitTarget| {
        apex_planning::validate::single_visit(&problem(vec![target], 100.0, travel.clone())).unwrap_err()
    };
    let why = refused(target("t", 1.0, Some((50.0, 10.0)), 0.0));
    assert_eq!(why, "a window of target t ends at 10 s, before it begins at 50 s");
    let unsorted = SingleVisitTarget { timing: vec![(100.0, 1.0), (50.0, 0.5)], ..target("t", 1.0, None, 0.0) };
    assert_eq!(refused(unsorted), "the timing of target t is not in the order of its times");
}

/// The timing still rises where the flight, or the window, ends: by hand 10 x 0.3 x 3 / 8 and 10 x 14 / 23.
#[test]
fn an_observation_begins_as_late_as_a_rising_timing_and_the_limits_permit() {
    let rising = |timing: Vec<(f64, f64)>, window| SingleVisitTarget { timing, ..target("t", 10.0, window, 0.0) };
    let cases = [
        (rising(vec![(24.0, 0.0), (32.0, 0.3)], None), 31.0, 27.0, 1.125),
        (rising(vec![(12.0, 0.0), (35.0, 1.0)], Some((0.0, 26.0))), 100.0, 26.0, 140.0 / 23.0),
    ];
    for (timed, endurance_s, begin_s, worth) in cases {
        let plan = visited(&SingleVisit, &problem(vec![timed], endurance_s, times(&[11.0], &[&[0.0]], &[4.0])));
        assert_eq!(names(&plan), ["t"], "{:?}", plan.left_out);
        assert!((plan.visits[0].begin_s - begin_s).abs() < 1e-6 && (plan.benefits - worth).abs() < 1e-9, "{plan:?}");
    }
}

/// The first target is in time only by way of the second, which must come after it.
#[test]
fn reasons_of_a_plan_without_visits_name_no_others() {
    let early = target("early", 10.0, Some((0.0, 15.0)), 0.0);
    let mut posed = problem(
        vec![early, target("later", 10.0, None, 0.0)],
        100.0,
        times(&[18.0, 10.0], &[&[0.0, 2.0], &[2.0, 0.0]], &[1.0, 1.0]),
    );
    posed.precedence = vec![("early".into(), "later".into())];
    let plan = visited(&SingleVisit, &posed);
    assert_eq!(names(&plan), [] as [&str; 0]);
    let reasons: Vec<&str> = plan.left_out.iter().map(|left_out| left_out.reason.as_str()).collect();
    assert!(!reasons.is_empty() && reasons.iter().all(|reason| !reason.contains("others")), "{reasons:?}");
}

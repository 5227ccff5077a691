//! Tests of the single-visit planner.

use super::*;
use apex_model::problem::{
    CrewMember, LandingPlace, Light, Obstacle, PlannedVisit, Position, SingleVisitPlan, SingleVisitProblem, TimeLimit,
    TimeWindow,
};
use apex_planning::examples::single_visit as examples;
use apex_planning::solver::WorkBudget;
use proptest::prelude::*;

fn solve(problem: &SingleVisitProblem, legs: u64) -> Result<SingleVisitPlan, String> {
    let mut budget = WorkBudget::new(legs * schedule::UNITS_PER_LEG);
    let mut environment = Environment { seed: 7, budget: &mut budget, report: &mut |_| {}, previous: None };
    match SingleVisit.solve(&Problem::SingleVisit(problem.clone()), &mut environment)? {
        Plan::SingleVisit(plan) => Ok(plan),
        Plan::Surveillance(_) => panic!("a single-visit problem has a single-visit plan"),
    }
}

fn few(count: usize, endurance_s: f64) -> SingleVisitProblem {
    let mut problem = examples::western_states(endurance_s);
    problem.targets.truncate(count);
    problem
}

fn reason<'a>(plan: &'a SingleVisitPlan, name: &str) -> &'a str {
    &plan.left_out.iter().find(|left_out| left_out.target == name).unwrap().reason
}

fn obstacle(plan: &SingleVisitPlan, name: &str) -> Option<Obstacle> {
    plan.left_out.iter().find(|left_out| left_out.target == name).unwrap().obstacle.clone()
}

#[test]
fn a_day_of_flight_sees_every_fire_and_an_afternoon_the_best() {
    let long = solve(&examples::western_states(86_400.0), 200_000).unwrap();
    assert_eq!(long.left_out, Vec::new());
    assert_eq!(long.visits.len(), 20);
    let short = solve(&examples::western_states(20_000.0), 100_000).unwrap();
    assert!(!short.visits.is_empty() && short.visits.len() < 12);
    assert!(reason(&short, "WH Complex").contains("more than endurance leaves"), "{}", reason(&short, "WH Complex"));
    assert!(short.benefits <= short.benefits_bound.unwrap());
}

#[test]
fn fuel_binds_where_it_is_shorter_than_endurance() {
    let mut problem = examples::western_states(86_400.0);
    problem.vehicle.fuel_kg = 500.0;
    let plan = solve(&problem, 50_000).unwrap();
    assert!(plan.fuel_used_kg <= 350.0);
    assert!(reason(&plan, "Domke Lake").contains("fuel"), "{}", reason(&plan, "Domke Lake"));
    let fuel = |limit: &TimeLimit| matches!(limit, TimeLimit::Flight { name, is_energy: true, .. } if name == "fuel");
    assert!(matches!(obstacle(&plan, "Domke Lake"), Some(Obstacle::Late { limit, .. }) if fuel(&limit)));
    // The end of the mission is not a limit of energy.
    let mut problem = examples::western_states(86_400.0);
    problem.end_s = Some(problem.start_s + 3_000.0);
    let plan = solve(&problem, 50_000).unwrap();
    let is_end = |limit: &TimeLimit| matches!(limit, TimeLimit::Flight { is_energy: false, .. });
    assert!(matches!(obstacle(&plan, "Domke Lake"), Some(Obstacle::Late { limit, .. }) if is_end(&limit)));
}

#[test]
fn a_target_inside_restricted_airspace_is_named_and_others_are_flown_around() {
    let mut problem = few(3, 40_000.0);
    problem.zones = vec![
        examples::restricted("R-2515", 34.2, 35.2, -120.3, -119.3),
        examples::restricted("R-WALL", 36.0, 36.4, -121.0, -118.5),
    ];
    problem.zone_margin_m = 3000.0;
    let plan = solve(&problem, 20_000).unwrap();
    assert_eq!(reason(&plan, "Zaca"), "inside restricted area R-2515");
    assert!(plan.visits.iter().any(|visit| visit.route.len() > 2), "a detour is flown");
    let asked = Problem::SingleVisit(problem);
    assert_eq!(apex_planning::checker::violations(&asked, &Plan::SingleVisit(plan)), Vec::<String>::new());
}

/// The word window in a name was taken for a closed time window, and the reason ended in "by daylight".
#[test]
fn a_zone_called_window_is_not_a_time_window() {
    let mut problem = few(3, 40_000.0);
    problem.zones = vec![examples::restricted("window rock", 34.2, 35.2, -120.3, -119.3)];
    problem.targets[0].light = Light::Day;
    let plan = solve(&problem, 20_000).unwrap();
    assert_eq!(reason(&plan, "Zaca"), "inside restricted area window rock");
    assert_eq!(obstacle(&plan, "Zaca"), None);
}

#[test]
fn more_time_is_named_only_where_it_would_help() {
    let mut problem = few(4, 60_000.0);
    let long = solve(&problem, 50_000).unwrap();
    let begin_s = long.visits.iter().find(|visit| visit.target == "Zaca").unwrap().begin_s;
    // Its window closes before the aircraft can be there, and the flight is too short for it as well.
    problem.targets[0].windows = vec![TimeWindow { from_s: 0.0, until_s: 60.0 }];
    problem.vehicle.endurance_s = problem.vehicle.endurance_reserve_s + 600.0;
    let short = solve(&problem, 50_000).unwrap();
    assert_eq!(reason(&short, "Zaca"), "its last time window closes before the vehicle can be there");
    assert_eq!(obstacle(&short, "Zaca"), Some(Obstacle::Window));
    // A window after the end of the flight: with the time named, and a minute for the way home, it is visited.
    problem.vehicle.endurance_s = problem.vehicle.endurance_reserve_s + 2.0 * begin_s + 9_000.0;
    let opens_s = 4.0 * begin_s + 30_000.0;
    problem.targets[0].windows = vec![TimeWindow { from_s: opens_s, until_s: opens_s + 9_000.0 }];
    let short = solve(&problem, 50_000).unwrap();
    let why = reason(&short, "Zaca");
    assert!(why.starts_with("needs ") && why.ends_with("endurance leaves, even alone"), "{why}");
}

/// The missing time was measured at the first visit that ended too late; the visits after it and the way home were not counted.
#[test]
fn the_time_that_is_named_suffices_in_the_order_of_the_plan() {
    let mut claims = 0;
    for seed in 0..40 {
        let problem = examples::random(9, seed);
        let plan = solve(&problem, 20_000).unwrap();
        for left_out in &plan.left_out {
            let Some(Obstacle::Late { over_s, alone: false, .. }) = left_out.obstacle else { continue };
            claims += 1;
            let target = problem.targets.iter().position(|target| target.name == left_out.target).unwrap();
            let mut longer = problem.clone();
            longer.end_s = longer.end_s.map(|end_s| end_s + over_s);
            longer.vehicle.endurance_s += over_s;
            longer.vehicle.fuel_kg += over_s * longer.vehicle.fuel_flow_kg_per_s;
            let mut schedule = schedule::Schedule::new(&longer).unwrap();
            let order: Vec<schedule::Choice> = plan.visits.iter().map(|visit| choice(&problem, visit)).collect();
            let mut free = WorkBudget::new(u64::MAX);
            let fits = (0..=order.len()).any(|at| {
                (0..problem.targets[target].manoeuvres.len()).any(|manoeuvre| {
                    let added = schedule::Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY };
                    schedule.judge(&search::inserted(&order, at, added), &mut free).is_ok()
                })
            });
            assert!(fits, "seed {seed}: {} {}", left_out.target, left_out.reason);
        }
    }
    assert!(claims > 20, "{claims}");
}

/// Returns a visit of a plan as the search chose it.
fn choice(problem: &SingleVisitProblem, visit: &PlannedVisit) -> schedule::Choice {
    let target = problem.targets.iter().position(|target| target.name == visit.target).unwrap();
    let corners = problem.targets[target].timing.iter().map(|(time_s, _)| *time_s);
    let not_before_s = corners.filter(|time_s| (time_s - visit.begin_s).abs() < 1e-6).fold(f64::NEG_INFINITY, f64::max);
    schedule::Choice { target, manoeuvre: visit.manoeuvre, not_before_s }
}

#[test]
fn windows_order_light_and_timing_are_obeyed() {
    let mut problem = few(4, 60_000.0);
    problem.precedence = vec![("Moonlight".into(), "Lick".into())];
    problem.targets[0].windows = vec![TimeWindow { from_s: 20_000.0, until_s: 22_000.0 }];
    problem.targets[3].light = Light::Night;
    problem.targets[2].timing = vec![(0.0, 0.1), (15_000.0, 1.0), (16_000.0, 1.0), (30_000.0, 0.1)];
    let plan = solve(&problem, 100_000).unwrap();
    let visit = |name: &str| plan.visits.iter().find(|visit| visit.target == name).unwrap();
    assert!((20_000.0..22_000.0).contains(&visit("Zaca").begin_s));
    assert!(visit("Moonlight").begin_s < visit("Lick").begin_s);
    assert!(visit("Moonlight").timing > 0.9, "waits for the best time: {:?}", visit("Moonlight"));
    let asked = Problem::SingleVisit(problem);
    assert_eq!(apex_planning::checker::violations(&asked, &Plan::SingleVisit(plan)), Vec::<String>::new());
}

#[test]
fn nothing_feasible_names_what_binds() {
    // A plan without visits is valid; its summary states the reason.
    let message = solve(&few(3, 3_000.0), 1000).unwrap().summary;
    assert!(message.starts_with("No target can be visited.") && message.contains("endurance"), "{message}");
    let mut far = few(2, 40_000.0);
    far.landing_distance_m_max = Some(100_000.0);
    far.landing_places = vec![LandingPlace { name: "Edwards".into(), position: far.start }];
    let message = solve(&far, 1000).unwrap().summary;
    assert!(message.contains("emergency landing place"), "{message}");
    let mut closed = few(2, 40_000.0);
    closed.zones = vec![examples::restricted("R-2515", 34.0, 36.0, -119.0, -117.0)];
    assert_eq!(solve(&closed, 1000).unwrap_err(), "the start cannot be used: inside restricted area R-2515");
    let mut wrong = few(2, 40_000.0);
    wrong.targets[1].position = Position::new(f64::NAN, 0.0);
    assert!(solve(&wrong, 1000).unwrap_err().contains("not on the map"));
}

#[test]
fn where_every_visit_costs_more_than_it_brings_no_visit_is_flown() {
    let mut problem = few(4, 86_400.0);
    problem.base = Some(problem.start);
    problem.crew = vec![CrewMember { role: "pilot".into(), wage_per_hour: 1e6, fixed_hours: 1.0, flight_share: 1.0 }];
    let plan = solve(&problem, 50_000).unwrap();
    assert_eq!((plan.visits.len(), plan.benefits, plan.costs, plan.left_out.len()), (0, 0.0, 1e6, 4));
    assert!(plan.summary.starts_with("No visit improves the plan. "), "{}", plan.summary);
    let asked = Problem::SingleVisit(problem);
    assert_eq!(apex_planning::checker::violations(&asked, &Plan::SingleVisit(plan)), Vec::<String>::new());
}

#[test]
fn time_that_costs_more_than_it_brings_is_not_flown() {
    let mut problem = examples::western_states(86_400.0);
    problem.crew = vec![CrewMember { role: "pilot".into(), wage_per_hour: 6.0, fixed_hours: 1.0, flight_share: 2.0 }];
    let plan = solve(&problem, 50_000).unwrap();
    assert!(plan.visits.len() < 20);
    assert!(plan.left_out.iter().any(|left_out| left_out.reason.contains("costs more than it is worth")));
}

#[test]
fn time_for_quality_is_taken_where_there_is_time() {
    let rich = solve(&few(3, 86_400.0), 30_000).unwrap();
    assert!(rich.visits.iter().all(|visit| visit.manoeuvre == 1), "the finer manoeuvre everywhere");
}

#[test]
fn equal_seed_and_budget_give_an_equal_plan() {
    let problem = examples::random(9, 3);
    assert_eq!(solve(&problem, 4_000), solve(&problem, 4_000));
}

#[test]
fn even_a_budget_of_nothing_gives_a_whole_plan() {
    assert_eq!(solve(&few(5, 60_000.0), 0).unwrap().visits.len(), 5);
}

/// Returns the best score by trying every subset in every order with every manoeuvre.
fn exhaustive(problem: &SingleVisitProblem) -> f64 {
    fn extend(schedule: &mut schedule::Schedule<'_>, order: &mut Vec<schedule::Choice>, best: &mut f64) {
        match schedule.judge(order, &mut WorkBudget::new(u64::MAX)) {
            Ok(judged) if !order.is_empty() => *best = best.max(judged.score),
            _ => {}
        }
        for target in 0..schedule.problem.targets.len() {
            if order.iter().any(|choice| choice.target == target) {
                continue;
            }
            for manoeuvre in 0..schedule.problem.targets[target].manoeuvres.len() {
                order.push(schedule::Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY });
                extend(schedule, order, best);
                order.pop();
            }
        }
    }
    let mut best = f64::NEG_INFINITY;
    extend(&mut schedule::Schedule::new(problem).unwrap(), &mut Vec::new(), &mut best);
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn small_missions_are_solved_to_the_optimum(seed in 0..10_000u64, hours in 2.0..9.0f64) {
        let mut problem = examples::random(4, seed);
        problem.vehicle.endurance_s = hours * 3600.0;
        for target in &mut problem.targets {
            target.timing.clear();
        }
        if let Ok(plan) = solve(&problem, 40_000) {
            let best = exhaustive(&problem);
            prop_assert!(plan.score >= best - 1e-6, "{} of {best}", plan.score);
        }
    }
}

#[test]
fn where_even_the_way_home_is_too_late_there_is_no_plan_and_no_price() {
    let mut problem = few(3, 40_000.0);
    problem.base = Some(problem.start);
    problem.start = Position { latitude_deg: 47.0, longitude_deg: -113.0 };
    problem.end_s = Some(problem.start_s + 600.0);
    let refused = solve(&problem, 20_000).unwrap_err();
    assert!(
        refused.contains("the flight back to the base alone") && refused.contains("the end of the mission"),
        "{refused}"
    );
    let (mut budget, mut reported) = (WorkBudget::new(100_000), 0);
    let mut report = |_: &Plan| reported += 1;
    let mut environment = Environment { seed: 7, budget: &mut budget, report: &mut report, previous: None };
    assert!(SingleVisit.solve(&Problem::SingleVisit(problem.clone()), &mut environment).is_err());
    assert_eq!(reported, 0, "an infeasible order is not offered for the case that the time runs out");
    let visit = OrderedVisit { target: 0, manoeuvre: 0, not_before_s: f64::NEG_INFINITY };
    assert_eq!(order_value(&problem, &[visit]), Err(refused));
    // With enough time for it, the flight home alone is a plan.
    problem.end_s = Some(problem.start_s + 39_000.0);
    let plan = solve(&problem, 20_000).unwrap();
    assert_eq!(apex_planning::checker::violations(&Problem::SingleVisit(problem), &Plan::SingleVisit(plan)), [""; 0]);
}

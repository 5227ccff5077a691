//! Travel times that depend on the departure: all planners and the checker use them, and a later departure never arrives earlier.

use apex_model::problem::{Plan, Position, Problem, UNREACHABLE_S, WindField, WindLayer};
use apex_planning::checker;
use apex_planning::examples::surveillance as examples;
use apex_planning::solver::{Environment, WorkBudget};
use apex_planning::surveillance::travel::{SurveillanceTravel, Transit};
use apex_solvers::solvers;
use proptest::prelude::*;

fn layer(from_s: f64, until_s: f64, east: f64, north: f64) -> WindLayer {
    WindLayer {
        area: None,
        altitude_m_min: 0.0,
        altitude_m_max: 1000.0,
        from_s,
        until_s,
        wind_east_mps: east,
        wind_north_mps: north,
        edr: 0.0,
    }
}

fn ways(wind: &WindField, begin_s: f64) -> (SurveillanceTravel, usize) {
    let home = Position::new(37.39, -121.12);
    let targets = [(37.41, -121.12), (37.43, -121.02), (37.35, -121.10), (37.39, -121.20)];
    let targets = targets.map(|(latitude, longitude)| Position::new(latitude, longitude));
    let transit = Transit {
        true_airspeed_mps: 15.0,
        turn_radius_m: 0.0,
        altitude_m: 100.0,
        wind,
        time_s: begin_s,
        until_s: begin_s + 7200.0,
        zones: &[],
        margin_m: 0.0,
        altitudes_m: (100.0, 100.0),
    };
    (SurveillanceTravel::new(home, &targets, home, &transit).unwrap(), targets.len())
}

/// Returns layers of wind that follow each other, then 3 m/s from the west.
fn following(winds: &[(f64, f64, f64)]) -> WindField {
    let mut layers = Vec::new();
    let mut from_s = 0.0;
    for (lasts_s, east, north) in winds {
        layers.push(layer(from_s, from_s + lasts_s, *east, *north));
        from_s += lasts_s;
    }
    layers.push(layer(from_s, 1e9, 3.0, 0.0));
    WindField { layers, blend: false }
}

/// The wind turns 1,071 s after the end of the plan, while a vehicle is on a way of 1,900 s that it began before the end.
#[test]
fn a_change_after_the_end_of_the_plan_counts_for_a_way_that_began_before_it() {
    let wind = following(&[(3969.38, 0.0, 0.0), (2287.04, 0.0, 0.0), (2256.25, -6.445, 0.0)]);
    let (begin_s, depart_s) = (241.856, 6467.03);
    let (table, count) = ways(&wind, begin_s);
    let exact = ways(&wind, begin_s + depart_s).0;
    let longest_s = table.times.mean(7200.0).between_s.iter().flatten().copied().fold(0.0, f64::max);
    for from in 0..count {
        for to in 0..count {
            let (time_s, exact_s) = (table.times.between_at(from, to, depart_s), exact.times.between(from, to));
            assert!((time_s - exact_s).abs() <= 0.005 * longest_s, "{from} to {to}: {time_s} s, exactly {exact_s} s");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn a_later_departure_does_not_arrive_earlier_and_the_table_holds_the_times(
        winds in prop::collection::vec((100.0..4000.0f64, -8.0..8.0f64, -8.0..8.0f64), 1..4), begin_s in 0.0..1000.0f64,
        departures in prop::collection::vec(0.0..7000.0f64, 8),
    ) {
        let wind = following(&winds);
        let (ways, count) = ways(&wind, begin_s);
        let longest_s = ways.times.mean(7200.0).between_s.iter().flatten().copied().fold(0.0, f64::max);
        let mut departures = departures;
        departures.sort_by(f64::total_cmp);
        for from in 0..count {
            for to in 0..count {
                let mut before_s = 0.0;
                for depart_s in &departures {
                    let time_s = ways.times.between_at(from, to, *depart_s);
                    prop_assert!(depart_s + time_s >= before_s - 1e-6);
                    prop_assert!(ways.times.between_s_min(from, to) <= time_s);
                    before_s = depart_s + time_s;
                    // The travel times of a plan that begins at the departure must be equal in the same wind.
                    let exact_s = self::ways(&wind, begin_s + depart_s).0.times.between(from, to);
                    prop_assert!((time_s - exact_s).abs() <= 4.0 * (0.005 * longest_s).max(1.0), "{time_s} {exact_s}");
                }
            }
        }
    }

    #[test]
    fn every_planner_sees_that_times_change(count in 3..7usize, seed in 0..10_000u64, home: bool, turn_s in 300.0..2000.0f64) {
        let mut problem = examples::turning(count, seed, 4000.0, turn_s);
        problem.return_to_base = home;
        apex_planning::validate::surveillance(&problem).unwrap();
        let problem = Problem::Surveillance(problem);
        let mut blind = problem.clone();
        if let Problem::Surveillance(blind) = &mut blind {
            blind.travel = blind.travel.least();
        }
        for solver in solvers().iter().filter(|solver| solver.serves(&problem)) {
            let mut budget = WorkBudget::new(5_000);
            let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
            let mut plan = solver.solve(&problem, &mut environment).unwrap();
            apex_solvers::bounds::state(&problem, &mut plan).unwrap();
            prop_assert_eq!(checker::violations(&problem, &plan), Vec::<String>::new());
            // A plan that assumes the shortest time of each leg over all departures arrives late.
            let mut budget = WorkBudget::new(5_000);
            let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
            let hasty = solver.solve(&blind, &mut environment).unwrap();
            prop_assert!(!checker::violations(&problem, &hasty).is_empty());
        }
    }
}

#[test]
fn times_that_let_another_task_overtake_are_refused() {
    let refused = |change: &dyn Fn(&mut apex_model::problem::TravelTimes)| {
        let mut problem = examples::turning(3, 1, 4000.0, 1000.0);
        change(&mut problem.travel);
        apex_planning::validate::surveillance(&problem).unwrap_err()
    };
    let why = refused(&|travel| travel.later[3].between_s[0][1] += 500.0);
    assert!(why.contains("would arrive earlier"), "{why}");
    let why = refused(&|travel| travel.later[3].depart_s = 1.0);
    assert!(why.contains("by rising time"), "{why}");
    let why = refused(&|travel| travel.later[3].depart_s = f64::NAN);
    assert!(why.contains("by rising time"), "{why}");
    let why = refused(&|travel| travel.later[3].from_start_s.truncate(1));
    assert!(why.contains("do not fit 3 targets"), "{why}");
    let mut problem = examples::turning(3, 1, 4000.0, 1000.0);
    problem.travel.later[19].between_s[0][1] = UNREACHABLE_S;
    assert!(apex_planning::validate::surveillance(&problem).is_ok(), "a way may shut");
}

#[test]
fn a_problem_with_equal_times_at_every_departure_is_planned_as_one_with_constant_times() {
    let constant = examples::random(6, 3);
    let mut timed = constant.clone();
    let travel = constant.travel.clone();
    timed.travel.later = vec![apex_model::problem::LaterTimes {
        depart_s: 500.0,
        from_start_s: travel.from_start_s,
        between_s: travel.between_s,
        to_base_s: travel.to_base_s,
    }];
    for solver in solvers().iter().filter(|solver| ["nearest-neighbour", "two-opt", "wam"].contains(&solver.name())) {
        let plan = |problem: &apex_model::problem::SurveillanceProblem| {
            let mut budget = WorkBudget::new(10_000);
            let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
            match solver.solve(&Problem::Surveillance(problem.clone()), &mut environment).unwrap() {
                Plan::Surveillance(plan) => plan.visits.into_iter().map(|visit| visit.target).collect::<Vec<_>>(),
                Plan::SingleVisit(_) => panic!("of another kind"),
            }
        };
        assert_eq!(plan(&constant), plan(&timed), "{}", solver.name());
    }
}

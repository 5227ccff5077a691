//! Surveillance by a vehicle that cannot stop: times against computed values, and plans flown in small steps.

use apex_geo::geodesy;
use apex_geo::travel::Circling;
use apex_model::problem::AirspaceZone;
use apex_model::problem::{Plan, Position, Problem, TimeWindow, UNREACHABLE_S, WindField, WindLayer, ZoneKind};
use apex_planning::checker;
use apex_planning::examples::surveillance as examples;
use apex_planning::solver::{Environment, WorkBudget};
use apex_planning::surveillance::travel::{SurveillanceTravel, Transit};
use apex_solvers::solvers;
use std::f64::consts::PI;

const AIRSPEED_MPS: f64 = 95.2;

fn places() -> (Position, Vec<Position>) {
    let targets = [(39.9, -120.2), (39.6, -119.8), (39.4, -119.3), (39.2, -119.9), (39.0, -120.5)];
    (Position::new(39.45, -120.1), targets.map(|(latitude, longitude)| Position::new(latitude, longitude)).to_vec())
}

fn transit<'a>(turn_radius_m: f64, wind: &'a WindField, zones: &'a [AirspaceZone]) -> Transit<'a> {
    Transit {
        true_airspeed_mps: AIRSPEED_MPS,
        turn_radius_m,
        altitude_m: 3_000.0,
        wind,
        time_s: 0.0,
        until_s: 18_000.0,
        zones,
        margin_m: 100.0,
        altitudes_m: (3_000.0, 3_000.0),
    }
}

fn ways(turn_radius_m: f64, wind: &WindField) -> SurveillanceTravel {
    let (start, targets) = places();
    SurveillanceTravel::new(start, &targets, start, &transit(turn_radius_m, wind, &[])).unwrap()
}

fn blowing(east: f64, north: f64) -> WindField {
    let layer = WindLayer {
        area: None,
        altitude_m_min: 0.0,
        altitude_m_max: 9_000.0,
        from_s: 0.0,
        until_s: 1e9,
        wind_east_mps: east,
        wind_north_mps: north,
        edr: 0.0,
    };
    WindField { layers: vec![layer], blend: false }
}

#[test]
fn in_calm_air_a_way_takes_half_a_circle_more() {
    let calm = WindField::default();
    let (at_once, wide) = (ways(0.0, &calm), ways(4_000.0, &calm));
    let half_s = PI * 4_000.0 / AIRSPEED_MPS;
    for (from, rows) in at_once.times.between_s.iter().zip(&wide.times.between_s).enumerate() {
        for (to, (straight_s, time_s)) in rows.0.iter().zip(rows.1).enumerate().filter(|(to, _)| *to != from) {
            let more_s = time_s - straight_s;
            // The distance between points of the circles equals that of the places; a turn in the opposite direction adds a little.
            assert!(more_s > half_s && more_s < 1.04 * half_s, "{from} to {to}: {more_s} of {half_s}");
        }
        assert_eq!(wide.times.between_s[from][from], 0.0);
    }
    assert!(wide.times.is_constant() && wide.circle_radius_m() == 4_000.0);
    assert_eq!((at_once.circle_radius_m(), at_once.times.clone()), (0.0, ways(0.0, &calm).times));
    // The vehicle flies over the base, which is off the line along the circles, and therefore turns a little further.
    let home_s = wide.times.to_base_s[0] - at_once.times.to_base_s[0];
    assert!(home_s > half_s && home_s < 1.1 * half_s, "{home_s} of {half_s}");
    let strong = ways(4_000.0, &blowing(0.0, 20.0)).circle_radius_m();
    assert!((strong - 4_000.0 * (115.2 / AIRSPEED_MPS) * (115.2 / AIRSPEED_MPS)).abs() < 1e-6, "{strong}");
}

/// Flies over `points` at the airspeed in `wind`; the heading is such that air velocity and wind add up to the chord.
fn flown_s(points: &[Position], wind: (f64, f64)) -> f64 {
    let one = |pair: &[Position]| {
        let (length_m, azimuth_deg) = geodesy::inverse(pair[0], pair[1]);
        let (east, north) = (libm::sin(azimuth_deg.to_radians()), libm::cos(azimuth_deg.to_radians()));
        let (with, across) = (east * wind.0 + north * wind.1, east * wind.1 - north * wind.0);
        length_m / (libm::sqrt(AIRSPEED_MPS * AIRSPEED_MPS - across * across) + with)
    };
    points.windows(2).map(one).sum()
}

#[test]
fn plans_of_every_planner_are_flown_in_time_from_wherever_on_the_circle_one_begins() {
    for (number, wind) in [(0.0, 0.0), (12.0, -9.0), (-3.0, 22.0)].into_iter().enumerate() {
        let field = blowing(wind.0, wind.1);
        let mut ways = ways(4_400.0, &field);
        let mut problem = examples::random(5, 3);
        (problem.travel, problem.horizon_s) = (ways.times.clone(), 18_000.0);
        problem.targets.iter_mut().for_each(|target| target.dwell_s = 70.0);
        let problem = Problem::Surveillance(problem);
        for solver in solvers().iter().filter(|solver| solver.serves(&problem)) {
            let mut budget = WorkBudget::new(3_000);
            let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
            let plan = solver.solve(&problem, &mut environment).unwrap();
            assert_eq!(checker::violations(&problem, &plan), Vec::<String>::new());
            let (Plan::Surveillance(plan), Problem::Surveillance(problem)) = (plan, &problem) else { continue };
            let index = |name: &str| problem.targets.iter().position(|target| target.name == name).unwrap();
            let (mut from, mut planned_s) = (None, 0.0);
            let mut left = Some(Circling { bearing_rad: 1.3 * number as f64, clockwise: number == 1 });
            for visit in plan.visits.iter().take(12) {
                let to = index(&visit.target);
                let (path, there) = ways.flown((from, Some(to)), left, planned_s);
                if from == Some(to) {
                    assert!(path.len() <= 1 || flown_s(&path, wind) < 1.0, "there already");
                }
                let needs_s = flown_s(&path, wind);
                let has_s = visit.arrive_s - planned_s;
                // The plane of a leg is not quite the ellipsoid.
                assert!(needs_s <= has_s * 1.004 + 0.5, "{from:?} to {to}: {needs_s} of {has_s}");
                let (look, after) = ways.look(to, there.unwrap(), (visit.arrive_s, visit.end_s));
                assert!((flown_s(&look, wind) - 70.0).abs() < 0.7, "{}", flown_s(&look, wind));
                (from, planned_s, left) = (Some(to), visit.end_s, Some(after));
            }
        }
    }
}

#[test]
fn a_vehicle_without_space_to_circle_or_with_too_wide_turns_gets_the_reason() {
    let (start, targets) = places();
    let beside = |south: f64| AirspaceZone {
        name: "range".to_string(),
        kind: ZoneKind::Restricted,
        corners: [(south, -119.9), (south, -119.7), (south + 0.05, -119.7), (south + 0.05, -119.9)]
            .map(|(latitude, longitude)| Position::new(latitude, longitude))
            .to_vec(),
        altitude_m_min: 0.0,
        altitude_m_max: 9_000.0,
        active: TimeWindow::ALWAYS,
    };
    let calm = WindField::default();
    // 3.3 km north of the saddle: space for a vehicle that hovers, and for circles of 3 km.
    let zones = [beside(39.63)];
    let reach = |turn_radius_m: f64| {
        let ways = SurveillanceTravel::new(start, &targets, start, &transit(turn_radius_m, &calm, &zones)).unwrap();
        (ways.trouble(1).map(ToString::to_string), ways.times.from_start_s[1] < UNREACHABLE_S)
    };
    assert_eq!((reach(0.0), reach(3_000.0)), ((None, true), (None, true)));
    let trouble = "restricted areas leave too little space for turns of the vehicle";
    assert_eq!(reach(4_000.0), (Some(trouble.to_string()), false));
    for radius_m in [-1.0, f64::NAN, 1e7] {
        let told = SurveillanceTravel::new(start, &targets, start, &transit(radius_m, &calm, &[])).unwrap_err();
        let why = if radius_m > 0.0 { "wider than the 200000 m" } else { "must not be negative" };
        assert!(told.contains("the turn radius is") && told.contains(why), "{told}");
    }
}

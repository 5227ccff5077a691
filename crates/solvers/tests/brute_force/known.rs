//! Problems for which a false bound or plan was once computed.

use crate::chance::Chance;
use crate::{visits, watches};
use apex_model::problem::{
    CostFunction, EventRate, Manoeuvre, Position, SingleVisitProblem, SingleVisitTarget, SingleVisitVehicle,
    SurveillanceProblem, SurveillanceTarget, TimeWindow, TravelTimes, UNREACHABLE_S,
};

/// For these, the bound by ages on a grid once exceeded the cost of staying, or that of the only flight.
#[test]
fn grids_of_ages_bound_problems_in_which_little_can_be_flown() {
    for seed in [1_000_035, 1_000_366, 1_001_288, 1_001_950, 1_002_282, 1_002_799] {
        assert_eq!(watches::differences(seed), Vec::<String>::new(), "seed {seed}");
    }
}

/// Returns a problem of targets by name and value, each with one manoeuvre without duration, 10 s apart, with an hour of endurance.
fn visits_of(targets: &[(&str, f64)]) -> SingleVisitProblem {
    let count = targets.len();
    let target = |(name, value): &(&str, f64)| SingleVisitTarget {
        name: (*name).to_string(),
        value: *value,
        manoeuvres: vec![Manoeuvre { name: "look".into(), ..Manoeuvre::default() }],
        ..SingleVisitTarget::default()
    };
    SingleVisitProblem {
        targets: targets.iter().map(target).collect(),
        vehicle: SingleVisitVehicle { true_airspeed_mps: 10.0, endurance_s: 3600.0, ..SingleVisitVehicle::default() },
        travel: Some(TravelTimes {
            from_start_s: vec![10.0; count],
            between_s: vec![vec![10.0; count]; count],
            to_base_s: vec![10.0; count],
            later: Vec::new(),
        }),
        ..SingleVisitProblem::default()
    }
}

#[test]
fn a_target_of_no_value_that_comes_first_is_kept() {
    let mut problem = visits_of(&[("gate", 0.0), ("fire", 10.0), ("hill", 1.0)]);
    problem.precedence = vec![("gate".into(), "fire".into())];
    assert_eq!(visits::of_problem(&mut Chance::new(1), &problem), Vec::<String>::new());
}

/// Returns a problem in which the fire is 100 s from the start, but only 25 s by way of the gate; its window closes after 60 s.
fn short_cut(gate: f64) -> SingleVisitProblem {
    let mut problem = visits_of(&[("gate", gate), ("fire", 10.0), ("hill", 1.0)]);
    problem.targets[1].windows = vec![TimeWindow { from_s: 0.0, until_s: 60.0 }];
    let travel = problem.travel.as_mut().expect("given times");
    travel.from_start_s = vec![10.0, 100.0, 10.0];
    travel.between_s = vec![vec![0.0, 15.0, 10.0], vec![10.0, 0.0, 10.0], vec![10.0, 100.0, 0.0]];
    problem
}

#[test]
fn a_target_that_only_another_one_leads_to_in_time_is_kept() {
    for gate in [0.0, 0.5] {
        let problem = short_cut(gate);
        assert_eq!(visits::of_problem(&mut Chance::new(1), &problem), Vec::<String>::new(), "gate {gate}");
    }
}

#[test]
fn surveillance_reaches_targets_by_way_of_others() {
    let target = |name: &str| SurveillanceTarget {
        name: name.to_string(),
        position: Position::default(),
        dwell_s: 10.0,
        rate: EventRate::constant(1.0),
        cost: CostFunction::Saturating { maximum: 1.0, rate_per_s: 0.01 },
        initial_age_s: 0.0,
    };
    let problem = SurveillanceProblem {
        targets: vec![target("gate"), target("fire")],
        travel: TravelTimes {
            from_start_s: vec![20.0, UNREACHABLE_S],
            between_s: vec![vec![0.0, 20.0], vec![20.0, 0.0]],
            to_base_s: vec![20.0, 20.0],
            later: Vec::new(),
        },
        horizon_s: 200.0,
        return_to_base: false,
        endurance_s: None,
    };
    assert_eq!(watches::of_problem(&mut Chance::new(1), &problem), Vec::<String>::new());
    for solver in apex_solvers::solvers() {
        let posed = apex_model::problem::Problem::Surveillance(problem.clone());
        if !solver.serves(&posed) {
            continue;
        }
        let mut budget = apex_planning::solver::WorkBudget::new(20_000);
        let mut environment =
            apex_planning::solver::Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        let plan = solver.solve(&posed, &mut environment).expect("a plan");
        assert!(plan.targets().contains(&"fire"), "{} never sees the fire", solver.name());
    }
}

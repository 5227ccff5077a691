//! Seeded surveillance problems for tests.

use crate::random::Generator;
use apex_model::problem::{
    CostFunction, EventRate, LaterTimes, Position, SurveillanceProblem, SurveillanceTarget, TravelTimes,
};

/// Returns `count` random targets within 4 km, with unequal rates and costs; wind makes the travel times asymmetric.
pub fn random(count: usize, seed: u64) -> SurveillanceProblem {
    sized(count, seed, 4000.0)
}

/// Like [`random`], on a map of another side.
pub fn sized(count: usize, seed: u64, side_m: f64) -> SurveillanceProblem {
    let mut generator = Generator::new(seed);
    let places: Vec<(f64, f64)> =
        (0..count).map(|_| (side_m * (generator.unit() - 0.5), side_m * (generator.unit() - 0.5))).collect();
    let leg = |from: (f64, f64), to: (f64, f64)| {
        let (east, north) = (to.0 - from.0, to.1 - from.1);
        let length = libm::hypot(east, north);
        if length == 0.0 { 0.0 } else { length / (20.0 + 6.0 * east / length) }
    };
    let targets = places.iter().enumerate().map(|(index, place)| SurveillanceTarget {
        name: format!("T{index}"),
        position: Position::new(37.0 + place.1 / 111_000.0, -122.0 + place.0 / 88_700.0),
        dwell_s: 10.0,
        rate: EventRate::constant(1.0),
        cost: CostFunction::Saturating {
            maximum: 0.1 + 1.8 * generator.unit(),
            rate_per_s: (0.1 + 1.8 * generator.unit()) / 600.0,
        },
        initial_age_s: 0.0,
    });
    SurveillanceProblem {
        targets: targets.collect(),
        travel: TravelTimes {
            from_start_s: places.iter().map(|place| leg((0.0, 0.0), *place)).collect(),
            between_s: places.iter().map(|from| places.iter().map(|to| leg(*from, *to)).collect()).collect(),
            to_base_s: places.iter().map(|place| leg(*place, (0.0, 0.0))).collect(),
            later: Vec::new(),
        },
        horizon_s: 3600.0,
        return_to_base: false,
        endurance_s: None,
    }
}

/// Like [`sized`], with a wind that changes at `turn_s`: a vehicle on the way then meets both winds.
pub fn turning(count: usize, seed: u64, side_m: f64, turn_s: f64) -> SurveillanceProblem {
    let mut problem = sized(count, seed, side_m);
    let mut generator = Generator::new(seed ^ 0x5EED);
    // The travel time of each leg after the change.
    let mut after_s = |time_s: f64| time_s * (0.5 + generator.unit());
    let constant = problem.travel.clone();
    let after = LaterTimes {
        depart_s: turn_s,
        from_start_s: constant.from_start_s.iter().map(|time_s| after_s(*time_s)).collect(),
        between_s: constant.between_s.iter().map(|row| row.iter().map(|time_s| after_s(*time_s)).collect()).collect(),
        to_base_s: constant.to_base_s.iter().map(|time_s| after_s(*time_s)).collect(),
    };
    let at = |depart_s: f64, before_s: f64, after_s: f64| {
        let left_s = turn_s - depart_s;
        if before_s <= left_s { before_s } else { left_s + (1.0 - left_s / before_s) * after_s }
    };
    let row = |depart_s: f64, before: &[f64], after: &[f64]| -> Vec<f64> {
        before.iter().zip(after).map(|(before_s, after_s)| at(depart_s, *before_s, *after_s)).collect()
    };
    for step in 1..20 {
        let depart_s = turn_s * f64::from(step) / 20.0;
        let between = constant.between_s.iter().zip(&after.between_s);
        problem.travel.later.push(LaterTimes {
            depart_s,
            from_start_s: row(depart_s, &constant.from_start_s, &after.from_start_s),
            between_s: between.map(|(before, after)| row(depart_s, before, after)).collect(),
            to_base_s: row(depart_s, &constant.to_base_s, &after.to_base_s),
        });
    }
    problem.travel.later.push(after);
    problem
}

/// Returns `count` equal targets with linear cost and a horizon of very many laps.
pub fn equal(count: usize, seed: u64) -> SurveillanceProblem {
    let mut problem = random(count, seed);
    for target in &mut problem.targets {
        target.cost = CostFunction::Linear { cost_per_s: 1.0 };
    }
    problem.horizon_s = 100_000.0;
    problem
}

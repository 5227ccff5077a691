//! Random surveillance problems of up to four targets: all families of costs, rates that change, ages, limits, any times.

use crate::chance::Chance;
use crate::visit_problems;
use apex_model::problem::{
    CostFunction, EventRate, Position, SurveillanceProblem, SurveillanceTarget, TravelTimes, UNREACHABLE_S,
};

/// Returns a problem in which few visits fit.
pub(crate) fn problem(chance: &mut Chance) -> SurveillanceProblem {
    let count = 1 + chance.below(4);
    let travel = visit_problems::travel(chance, count);
    let mut targets: Vec<SurveillanceTarget> = (0..count).map(|index| target(chance, index)).collect();
    // A visit without duration is invalid.
    for (index, target) in targets.iter_mut().enumerate() {
        let quickest_s = quickest_s(&travel, index);
        if target.dwell_s + quickest_s < 1.0 {
            target.dwell_s = 1.0;
        }
    }
    let visit_s: f64 = (0..count).map(|to| targets[to].dwell_s + typical_s(&travel, to)).sum::<f64>() / count as f64;
    let horizon_s = (visit_s * (1.0 + 5.0 * chance.unit())).clamp(2.0, 5_000.0);
    SurveillanceProblem {
        return_to_base: chance.percent(30),
        endurance_s: chance.percent(30).then(|| horizon_s * (0.4 + chance.unit())),
        targets,
        travel,
        horizon_s,
    }
}

fn target(chance: &mut Chance, index: usize) -> SurveillanceTarget {
    SurveillanceTarget {
        name: format!("T{index}"),
        position: Position::new(0.0, index as f64),
        dwell_s: chance.of(&[0.0, 1.0, 5.0, 10.0, 20.0]),
        rate: rate(chance),
        cost: cost(chance, 0),
        initial_age_s: if chance.percent(70) { 0.0 } else { chance.eighths(200.0) },
    }
}

fn rate(chance: &mut Chance) -> EventRate {
    if chance.percent(60) {
        return EventRate::constant(chance.of(&[0.0, 0.01, 1.0, 1.0, 2.0]));
    }
    let mut from_s = chance.eighths(60.0) - 30.0;
    let mut step = |chance: &mut Chance| {
        from_s += 1.0 + chance.eighths(80.0);
        (from_s, chance.of(&[0.0, 0.1, 1.0, 3.0]))
    };
    EventRate { steps: (0..chance.below(4)).map(|_| step(chance)).collect() }
}

fn cost(chance: &mut Chance, depth: usize) -> CostFunction {
    let maximum = chance.of(&[0.0, 0.5, 1.0, 10.0]);
    match chance.below(if depth == 0 { 7 } else { 5 }) {
        0 => CostFunction::Linear { cost_per_s: chance.of(&[0.0, 0.1, 1.0]) },
        1 => CostFunction::Saturating { maximum, rate_per_s: chance.of(&[0.0, 0.001, 0.02, 0.5]) },
        2 => CostFunction::Step { deadline_s: chance.eighths(100.0), maximum },
        3 => CostFunction::Logistic { maximum, rate_per_s: 0.2 * chance.unit(), midpoint_s: chance.eighths(100.0) },
        4 => CostFunction::Table { points: table(chance) },
        5 => CostFunction::Delayed { response_s: chance.eighths(50.0), cost: Box::new(cost(chance, depth + 1)) },
        _ => CostFunction::Saturating { maximum: 1.0, rate_per_s: 0.01 },
    }
}

fn table(chance: &mut Chance) -> Vec<(f64, f64)> {
    let (mut age_s, mut cost) = (chance.eighths(20.0), chance.unit());
    let mut point = |chance: &mut Chance| {
        let here = (age_s, cost);
        age_s += 1.0 + chance.eighths(50.0);
        cost += chance.unit();
        here
    };
    (0..=chance.below(4)).map(|_| point(chance)).collect()
}

fn quickest_s(travel: &TravelTimes, to: usize) -> f64 {
    let later = travel.later.iter().map(|at| &at.between_s);
    let all = later.chain([&travel.between_s]).flat_map(|rows| rows.iter().map(|row| row[to]));
    all.fold(f64::INFINITY, f64::min)
}

fn typical_s(travel: &TravelTimes, to: usize) -> f64 {
    let all = travel.between_s.iter().map(|row| row[to]).filter(|time_s| *time_s < UNREACHABLE_S);
    let all: Vec<f64> = all.collect();
    1.0 + all.iter().sum::<f64>() / all.len().max(1) as f64
}

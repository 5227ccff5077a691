//! Random single-visit problems with given travel times: metric and non-metric, with windows, order and timing, and degenerate ones.

use crate::chance::Chance;
use apex_model::problem::{
    CrewMember, LaterTimes, Manoeuvre, MustVisit, Position, QualityFactor, QualityFactors, SingleVisitProblem,
    SingleVisitTarget, SingleVisitVehicle, TimeWindow, TravelTimes, UNREACHABLE_S,
};

/// Returns a problem of up to 8 targets whose times are multiples of an eighth of a second.
pub(crate) fn problem(chance: &mut Chance) -> SingleVisitProblem {
    let count = 1 + chance.below(8);
    let travel = travel(chance, count);
    let span_s = 20.0 + chance.eighths(60.0 * count as f64);
    let start_s = if chance.percent(30) { chance.eighths(200.0) - 100.0 } else { 0.0 };
    let has_windows = chance.percent(60);
    let has_timing = chance.percent(15);
    let has_must = chance.percent(25);
    let mut targets: Vec<SingleVisitTarget> = (0..count)
        .map(|index| SingleVisitTarget {
            name: format!("T{index}"),
            position: Position::new(0.0, index as f64),
            value: value(chance),
            manoeuvres: manoeuvres(chance, count),
            windows: if has_windows { windows(chance, start_s, span_s) } else { Vec::new() },
            timing: if has_timing { timing(chance, start_s, span_s) } else { Vec::new() },
            must: if has_must && chance.percent(40) { Some(must(chance)) } else { None },
            ..SingleVisitTarget::default()
        })
        .collect();
    if chance.percent(5) {
        targets.iter_mut().for_each(|target| target.value = 0.0);
    }
    // An endurance that limits no flight makes the ticks of planners coarse.
    let endurance_s = if has_windows && chance.percent(10) { 1e9 } else { span_s };
    let fuelled = chance.percent(15);
    let vehicle = SingleVisitVehicle {
        true_airspeed_mps: 10.0,
        endurance_s: endurance_s + 8.0,
        endurance_reserve_s: 8.0,
        fuel_kg: if fuelled { 0.25 * span_s } else { 0.0 },
        fuel_flow_kg_per_s: if fuelled { 0.5 } else { 0.0 },
        ..SingleVisitVehicle::default()
    };
    SingleVisitProblem {
        precedence: precedence(chance, count),
        targets,
        vehicle,
        start_s,
        base: chance.percent(60).then(Position::default),
        end_s: chance.percent(20).then_some(start_s + 0.75 * span_s),
        crew: crew(chance),
        travel: Some(travel),
        ..SingleVisitProblem::default()
    }
}

fn value(chance: &mut Chance) -> f64 {
    match chance.below(8) {
        0 | 1 => 0.0,
        2 => 0.1 * chance.below(30) as f64,
        3 => chance.unit(),
        4 => 1e6 * chance.unit(),
        _ => 1.0 + chance.below(20) as f64,
    }
}

fn must(chance: &mut Chance) -> MustVisit {
    MustVisit { factor_min: chance.of(&[0.0, 0.0, 0.4, 0.75, 1.0]), cost: chance.of(&[0.0, 2.0, 15.0, 1e6]) }
}

fn manoeuvres(chance: &mut Chance, count: usize) -> Vec<Manoeuvre> {
    let several = count <= 5 && chance.percent(25);
    let one = |chance: &mut Chance, number: usize| {
        let factor = if chance.percent(70) { 1.0 } else { chance.of(&[0.0, 0.5, 0.75]) };
        Manoeuvre {
            name: format!("m{number}"),
            duration_s: if chance.percent(30) { 0.0 } else { chance.eighths(20.0) },
            quality: QualityFactors {
                coverage: QualityFactor { factor, cause: String::new() },
                ..QualityFactors::default()
            },
            ..Manoeuvre::default()
        }
    };
    (0..if several { 2 } else { 1 }).map(|number| one(chance, number)).collect()
}

fn windows(chance: &mut Chance, start_s: f64, span_s: f64) -> Vec<TimeWindow> {
    let one = |chance: &mut Chance| {
        let from_s = start_s + chance.eighths(1.2 * span_s) - 0.1 * (8.0 * span_s).round() / 8.0;
        let from_s = (8.0 * from_s).round() / 8.0;
        let lasts_s = if chance.percent(15) { 0.0 } else { chance.eighths(0.4 * span_s) };
        TimeWindow { from_s, until_s: from_s + lasts_s }
    };
    (0..chance.of(&[0, 1, 1, 2, 3])).map(|_| one(chance)).collect()
}

fn timing(chance: &mut Chance, start_s: f64, span_s: f64) -> Vec<(f64, f64)> {
    let mut at_s = start_s;
    let mut point = |chance: &mut Chance| {
        at_s += 1.0 + chance.eighths(0.5 * span_s);
        (at_s, chance.of(&[0.0, 0.25, 0.5, 1.0]))
    };
    (0..chance.below(4)).map(|_| point(chance)).collect()
}

/// Returns pairs that follow the order of a shuffled list, so that they form no cycle.
fn precedence(chance: &mut Chance, count: usize) -> Vec<(String, String)> {
    if count < 2 || chance.percent(50) {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..count).collect();
    (1..count).for_each(|index| order.swap(index, chance.below(index + 1)));
    let pair = |chance: &mut Chance| {
        let first = chance.below(count - 1);
        let second = first + 1 + chance.below(count - 1 - first);
        (format!("T{}", order[first]), format!("T{}", order[second]))
    };
    (0..=chance.below(count)).map(|_| pair(chance)).collect()
}

fn crew(chance: &mut Chance) -> Vec<CrewMember> {
    let paid = chance.percent(10);
    let member = || CrewMember { role: "pilot".into(), wage_per_hour: 40.0, fixed_hours: 0.1, flight_share: 1.0 };
    paid.then(member).into_iter().collect()
}

/// Returns travel times between points of a plane, many of which may be equal, or random numbers; in a fifth of all problems they change
/// with the departure.
pub(crate) fn travel(chance: &mut Chance, count: usize) -> TravelTimes {
    let kind = chance.below(4);
    let unreachable = if kind >= 2 { chance.of(&[0, 0, 10, 30]) } else { 0 };
    let side_s = chance.of(&[10.0, 40.0, 100.0]);
    let mut places: Vec<(f64, f64)> = (0..=count).map(|_| (chance.eighths(side_s), chance.eighths(side_s))).collect();
    if kind == 1 {
        let few: Vec<(f64, f64)> = places[..places.len().div_ceil(3)].to_vec();
        places.iter_mut().for_each(|place| *place = chance.of(&few));
    }
    let mut leg = |from: usize, to: usize| {
        if chance.percent(unreachable) {
            return UNREACHABLE_S;
        }
        let apart_s = (places[from].0 - places[to].0).hypot(places[from].1 - places[to].1);
        match kind {
            0 | 1 => (8.0 * apart_s).ceil() / 8.0,
            2 => chance.of(&[0.0, 1.0, 5.0, 25.0, 100.0]),
            _ => chance.eighths(side_s),
        }
    };
    let mut travel = TravelTimes {
        from_start_s: (1..=count).map(|to| leg(0, to)).collect(),
        between_s: (1..=count).map(|from| (1..=count).map(|to| leg(from, to)).collect()).collect(),
        to_base_s: (1..=count).map(|from| leg(from, 0)).collect(),
        later: Vec::new(),
    };
    if chance.percent(20) {
        travel.later = later(chance, &travel);
    }
    travel
}

/// Returns times for two later departures; a later departure never arrives earlier.
fn later(chance: &mut Chance, first: &TravelTimes) -> Vec<LaterTimes> {
    let mut all: Vec<LaterTimes> = Vec::new();
    let mut before = LaterTimes {
        depart_s: 0.0,
        from_start_s: first.from_start_s.clone(),
        between_s: first.between_s.clone(),
        to_base_s: first.to_base_s.clone(),
    };
    for _ in 0..2 {
        let passed_s = 1.0 + chance.eighths(60.0);
        let mut next = |time_s: &f64| match *time_s >= UNREACHABLE_S {
            true => UNREACHABLE_S,
            false => (time_s - passed_s).max((2.0 * chance.unit() * time_s * 8.0).round() / 8.0),
        };
        before = LaterTimes {
            depart_s: before.depart_s + passed_s,
            from_start_s: before.from_start_s.iter().map(&mut next).collect(),
            between_s: before.between_s.iter().map(|row| row.iter().map(&mut next).collect()).collect(),
            to_base_s: before.to_base_s.iter().map(&mut next).collect(),
        };
        all.push(before.clone());
    }
    all
}

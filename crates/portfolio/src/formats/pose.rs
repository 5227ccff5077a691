//! Makes a single-visit problem with given travel times from places on a plane, times and profits.

use super::instance::ProblemKind;
use super::words::TextToken;
use crate::format_error::FormatError;
use apex_model::problem::{
    CrewMember, Manoeuvre, Position, SingleVisitProblem, SingleVisitTarget, SingleVisitVehicle, TimeWindow, TravelTimes,
};

/// The plane is drawn on this many degrees of the map.
const SHOWN_DEG: f64 = 1.0;

/// One place of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Vertex {
    pub(super) name: String,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) service: f64,
    pub(super) profit: f64,
    pub(super) opens: f64,
    pub(super) closes: f64,
}

/// Limits of a problem in addition to its targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) question: ProblemKind,
    /// Earliest departure and latest return of the vehicle.
    pub(super) opens: f64,
    pub(super) closes: f64,
    /// All times of the file are multiples of this.
    pub(super) resolution: f64,
    /// True if targets have windows.
    pub(super) windows: bool,
}

/// Returns the problem: the first vertex is the depot, all others are targets; `time(from, to)` is the travel time between two of them.
///
/// A limit may be exceeded by less than half of the resolution, because sums of decimals are not exact.
pub(super) fn problem(vertices: &[Vertex], frame: Frame, time: &dyn Fn(usize, usize) -> f64) -> SingleVisitProblem {
    let count = vertices.len();
    let half = 0.5 * frame.resolution;
    let travel = TravelTimes {
        from_start_s: (1..count).map(|to| time(0, to)).collect(),
        between_s: (1..count).map(|from| (1..count).map(|to| time(from, to)).collect()).collect(),
        to_base_s: (1..count).map(|from| time(from, 0)).collect(),
        later: Vec::new(),
    };
    let position = shown(vertices);
    let target = |vertex: &Vertex| SingleVisitTarget {
        name: vertex.name.clone(),
        position: position(vertex),
        value: vertex.profit,
        manoeuvres: vec![Manoeuvre { name: "visit".into(), duration_s: vertex.service, ..Manoeuvre::default() }],
        windows: if frame.windows {
            vec![TimeWindow { from_s: vertex.opens, until_s: vertex.closes + half }]
        } else {
            Vec::new()
        },
        ..SingleVisitTarget::default()
    };
    let start = vertices.first().map_or(Position::default(), &position);
    let mut problem = SingleVisitProblem {
        targets: vertices.iter().skip(1).map(target).collect(),
        // The endurance never ends a flight; the closing time does.
        vehicle: SingleVisitVehicle {
            true_airspeed_mps: 1.0,
            endurance_s: 2.0 * (frame.closes - frame.opens) + 1.0,
            ..SingleVisitVehicle::default()
        },
        start,
        start_s: frame.opens,
        base: Some(start),
        end_s: Some(frame.closes + half),
        travel: Some(travel),
        ..SingleVisitProblem::default()
    };
    if frame.question == ProblemKind::Tour {
        tour(&mut problem);
    }
    problem
}

/// Turns the problem into one of a shortest tour of all: time costs 1 per second, and a visit is worth more than any detour.
fn tour(problem: &mut SingleVisitProblem) {
    let legs = problem.travel.iter().flat_map(|travel| {
        let legs = travel.from_start_s.iter().chain(&travel.to_base_s).chain(travel.between_s.iter().flatten());
        legs.copied()
    });
    let worth = 1.0 + 2.0 * legs.fold(0.0, f64::max);
    for target in &mut problem.targets {
        target.value = worth;
    }
    let clock = CrewMember { role: "time".into(), wage_per_hour: 3600.0, fixed_hours: 0.0, flight_share: 1.0 };
    problem.crew = vec![clock];
}

/// Returns the displayed position of a vertex: on the plane around the point 0 0 of the map.
fn shown(vertices: &[Vertex]) -> impl Fn(&Vertex) -> Position + use<> {
    let range = |axis: fn(&Vertex) -> f64| {
        let values = vertices.iter().map(axis);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let ((west, east), (south, north)) = (range(|vertex| vertex.x), range(|vertex| vertex.y));
    let scale = SHOWN_DEG / (east - west).max(north - south).max(1e-9);
    move |vertex| Position {
        latitude_deg: scale * (vertex.y - 0.5 * (south + north)),
        longitude_deg: scale * (vertex.x - 0.5 * (west + east)),
    }
}

/// Rejects a window that closes before it opens.
pub(super) fn check_window(vertex: &Vertex, closes: &TextToken<'_>) -> Result<(), FormatError> {
    if vertex.closes < vertex.opens {
        return Err(closes.trouble(
            format!("the window of {} closes at {} before it opens at {}", vertex.name, vertex.closes, vertex.opens),
            "service may begin from the opening to the closing time",
            "exchange the two times",
        ));
    }
    Ok(())
}

/// Rejects a file without targets, and one with more targets than planners accept.
pub(super) fn check_count(count: usize, at: &TextToken<'_>) -> Result<(), FormatError> {
    let most = apex_planning::validate::TARGETS_MAX;
    if count == 0 || count > most {
        return Err(at.trouble(
            format!("{count} targets cannot be planned for"),
            format!("a problem has from 1 to {most} targets in addition to its depot"),
            if count == 0 { "add a target" } else { "take a part of the file" },
        ));
    }
    Ok(())
}

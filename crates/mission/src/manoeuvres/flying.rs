//! Time and distance of lines flown in sequence: legs through wind, turns between them with the planned radius, and a straight lead-in
//! before each line for levelling the wings.

use crate::vehicle::{Airframe, VehicleModel, turn_radius_m};
use crate::ways::lead_in_s;
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_geo::plane::{Plane, Point};
use apex_geo::travel::{Flyer, Pose};
use apex_geo::wind;
use apex_model::problem::{Position, WindField};

/// A line with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlownLine {
    pub(super) from: Position,
    pub(super) to: Position,
    pub(super) from_s: f64,
    pub(super) ground_speed_mps: f64,
    pub(super) crab_deg: f64,
}

/// All lines with their times, and time and distance from before the first lead-in to the last line's end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FlownLines {
    pub(super) lines: Vec<FlownLine>,
    /// Beginning of the first lead-in; `None` without one.
    pub(super) entry: Option<Position>,
    pub(super) duration_s: f64,
    pub(super) length_m: f64,
}

/// Flies `lines` in order at `altitude_m` from `start_s` on: on the lines at `line_airspeed_mps`, otherwise at cruise speed.
///
/// # Errors
/// A line cannot be flown against the wind.
pub(super) fn fly(
    lines: &[(Position, Position)],
    altitude_m: f64,
    start_s: f64,
    line_airspeed_mps: Option<f64>,
    model: &VehicleModel,
    field: &WindField,
) -> Result<FlownLines, String> {
    let airspeed_mps = line_airspeed_mps.unwrap_or(model.true_airspeed_m_s_cruise);
    let mut flown = FlownLines { lines: Vec::new(), entry: None, duration_s: 0.0, length_m: 0.0 };
    if let Some((from, to)) = lines.first().filter(|_| model.airframe == Airframe::FixedWing) {
        let track_deg = geodesy::azimuth_deg(*from, *to);
        flown.entry = Some(geodesy::destination(*from, track_deg + 180.0, lead_in_m(model, field)));
    }
    let mut before: Option<(Position, Position)> = None;
    for (number, (from, to)) in lines.iter().copied().enumerate() {
        let now_s = start_s + flown.duration_s;
        let refused = || format!("line {} cannot be flown at {altitude_m:.0} m: the wind is too strong", number + 1);
        let (join_s, join_m) =
            join((before, (from, to)), altitude_m, now_s, airspeed_mps, model, field).ok_or_else(refused)?;
        flown.duration_s += join_s;
        flown.length_m += join_m;
        let from_s = start_s + flown.duration_s;
        let leg_s = wind::leg_time_s(from, to, altitude_m, airspeed_mps, field, from_s).ok_or_else(refused)?;
        let (length_m, track_deg) = geodesy::inverse(from, to);
        let middle = wind::at(field, geodesy::midpoint(from, to), altitude_m, from_s + 0.5 * leg_s);
        let triangle = wind::triangle(track_deg, airspeed_mps, middle).ok_or_else(refused)?;
        flown.lines.push(FlownLine {
            from,
            to,
            from_s,
            ground_speed_mps: if leg_s > 0.0 { length_m / leg_s } else { triangle.ground_speed_mps },
            crab_deg: geodesy::wrap_180(triangle.heading_deg - track_deg),
        });
        // From a standstill to the speed of the line, or from that to cruise speed.
        let starts_s = match model.airframe {
            Airframe::Rotorcraft => 0.5 * airspeed_mps / model.acceleration_m_s2_max,
            Airframe::FixedWing => model.speed_change_losses_s(airspeed_mps, model.true_airspeed_m_s_cruise).1,
        };
        flown.duration_s += leg_s + starts_s;
        flown.length_m += length_m;
        before = Some((from, to));
    }
    Ok(flown)
}

/// Returns the time and distance from the end of one line to the beginning of the next, including the lead-in; before the first line only
/// the lead-in. `None` if the wind is too strong.
fn join(
    (before, (from, to)): (Option<(Position, Position)>, (Position, Position)),
    altitude_m: f64,
    now_s: f64,
    line_airspeed_mps: f64,
    model: &VehicleModel,
    field: &WindField,
) -> Option<(f64, f64)> {
    let airspeed_mps = model.true_airspeed_m_s_cruise;
    let wind = wind::at(field, from, altitude_m, now_s);
    if model.airframe == Airframe::Rotorcraft {
        // A rotorcraft stops at the beginning of a line, and overshoots its end.
        let Some((_, exit)) = before else { return Some((arrival_s(model), 0.0)) };
        let leg_m = geodesy::distance_m(exit, from);
        let leg_s = wind::leg_time_s(exit, from, altitude_m, airspeed_mps, field, now_s)?;
        // The end of a line is passed at the speed of the line.
        let turned_s = TURN_SHARE * line_airspeed_mps / model.acceleration_m_s2_max;
        return Some((leg_s + turned_s + arrival_s(model), leg_m));
    }
    let track_deg = geodesy::azimuth_deg(from, to);
    let lead_m = lead_in_m(model, field);
    let cruise_mps = wind::triangle(track_deg, airspeed_mps, wind)?.ground_speed_mps;
    // The vehicle has the speed of the line at its beginning.
    let lead_s = lead_m / cruise_mps + model.speed_change_losses_s(line_airspeed_mps, cruise_mps).0;
    let Some((entry, exit)) = before else { return Some((lead_s, lead_m)) };
    let plane = Plane::new(geodesy::midpoint(exit, from));
    let direction = |track_deg: f64| Some((90.0 - track_deg) * RAD_PER_DEG);
    let out_deg = geodesy::azimuth_deg(exit, entry) + 180.0;
    let lead_in = geodesy::destination(from, track_deg + 180.0, lead_m);
    let flyer = Flyer {
        true_airspeed_mps: airspeed_mps,
        turn_radius_m: turn_radius_m(model),
        wind_mps: Point { x: wind.east_mps, y: wind.north_mps },
    };
    let path = flyer.quickest(
        Pose { point: plane.project(exit)?, track_rad: direction(out_deg) },
        Pose { point: plane.project(lead_in)?, track_rad: direction(track_deg) },
    );
    let turn_s = path?.time_s;
    Some((turn_s + lead_s, turn_s * airspeed_mps + lead_m))
}

/// Returns the length of a fixed wing's lead-in. Flown paths end at its beginning too, so that plan and flight agree.
pub(super) fn lead_in_m(model: &VehicleModel, field: &WindField) -> f64 {
    lead_in_s(model) * (model.true_airspeed_m_s_cruise + wind::speed_mps_max(field))
}

/// Returns the time beyond the flight at cruise speed that a rotorcraft needs to start from a hover, stop again and settle.
pub(super) fn arrival_s(model: &VehicleModel) -> f64 {
    let speed_mps = model.true_airspeed_m_s_cruise;
    let accelerate_s = 0.5 * speed_mps / model.acceleration_m_s2_max;
    let brake_s = if model.braking_share > 0.0 {
        0.5 * speed_mps / (model.braking_share * model.acceleration_m_s2_max)
    } else {
        0.0
    };
    accelerate_s + brake_s + HANG_S
}

/// Time of a turn between two lines as a share of the time of a full stop.
const TURN_SHARE: f64 = 0.5;
/// Time in which a rotorcraft flies the last metres to a hover, s.
const HANG_S: f64 = 3.0;

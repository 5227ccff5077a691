//! The end of a wait on a circle before a line: the vehicle leaves the circle where its way to the line's lead-in takes just the time that
//! is left.

use super::landing::on_line;
use super::limits::Limits;
use super::{Request, Way};
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_geo::plane::{Plane, Point};
use apex_geo::travel::{Flyer, Pose};
use apex_geo::wind;
use apex_model::problem::Position;
use apex_vehicle::density_ratio;
use std::f64::consts::FRAC_PI_2;

/// Steps along the circle, s.
const STEP_S: f64 = 2.0;
/// Longest flight on the circle that is predicted: the wind makes longer ones uncertain.
const AHEAD_S: f64 = 3_600.0;
/// Greatest change of the arrival between two steps; after a greater one, the path has a further turn.
const JUMP_S: f64 = 10.0;
/// Weight of a second of early arrival if the line would begin before its instant; a late second has the weight 1.
const EARLY_PRICE: f64 = 10.0;

/// A line, and the instant at which the lead-in before it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlannedStart {
    pub(super) from: Position,
    pub(super) to: Position,
    pub(super) altitude_m: f64,
    pub(super) begin_s: f64,
}

impl Limits {
    /// Returns the beginning of the lead-in before a line, and the direction there, clockwise from north.
    pub(super) fn gate(&self, from: Position, to: Position) -> (Position, f64) {
        let lead_m = self.lead_in_s * (self.true_airspeed_mps + self.wind_mps_max());
        let (gate, gate_deg) = on_line(from, to, -lead_m);
        (gate, gate_deg * RAD_PER_DEG)
    }

    /// Returns the way by which a fixed wing joins a line.
    pub(super) fn way_onto(&self, request: &Request, start: &PlannedStart) -> Option<Way> {
        let (gate, gate_rad) = self.gate(start.from, start.to);
        let onto = Request { to: gate, to_altitude_m: start.altitude_m, to_track_rad: Some(gate_rad), ..*request };
        self.turning_way(&onto).or_else(|| self.open_way(&onto))
    }

    /// Returns the time that is left if the vehicle flies to the lead-in now; negative if it comes too late. `None` for a vehicle without
    /// turns, and where no way leads there.
    pub(super) fn spare_s(&self, request: &Request, start: &PlannedStart) -> Option<f64> {
        if self.turn_radius_m <= 0.0 {
            return None;
        }
        let way = self.way_onto(request, start)?;
        Some(start.begin_s - (request.at_s + way.hold_s + way.time_s))
    }

    /// Returns the time for which a vehicle on a circle around `centre` stays on it. `None` if it is not on a circle.
    pub(super) fn circling_s(&self, request: &Request, centre: Position, start: &PlannedStart) -> Option<f64> {
        let plane = Plane::new(centre);
        let (gate, gate_rad) = self.gate(start.from, start.to);
        let gate = Pose { point: plane.project(gate)?, track_rad: Some(FRAC_PI_2 - gate_rad) };
        let mut here = plane.project(request.from)?;
        if self.turn_radius_m <= 0.0 || here.length() < 0.5 * self.turn_radius_m {
            return None;
        }
        let track_rad = FRAC_PI_2 - request.from_track_rad?;
        let to_left = here.x * libm::sin(track_rad) - here.y * libm::cos(track_rad);
        let sense = if to_left >= 0.0 { 1.0 } else { -1.0 };
        // In thin air the slowest speed exceeds that of cruise.
        let slowest_mps = self.indicated_airspeed_mps_min / libm::sqrt(density_ratio(start.altitude_m));
        let true_airspeed_mps = self.true_airspeed_mps.max(slowest_mps);
        let faster = true_airspeed_mps / self.true_airspeed_mps;
        // The autopilot chooses the circle by the wind at the command.
        let air = wind::at(&self.wind, request.from, start.altitude_m, request.at_s);
        let over_ground = faster + libm::hypot(air.east_mps, air.north_mps) / self.true_airspeed_mps;
        let radius_m = self.circle_width * self.turn_radius_m * over_ground * over_ground;
        let mut angle_rad = libm::atan2(here.y, here.x);
        let mut best: Option<(f64, f64)> = None;
        let mut before: Option<(f64, f64)> = None;
        let mut stay_s = 0.0;
        while stay_s < AHEAD_S && request.at_s + stay_s <= start.begin_s {
            let at_s = request.at_s + stay_s;
            let air = wind::at(&self.wind, plane.position(here), start.altitude_m, at_s);
            let track_rad = angle_rad + sense * FRAC_PI_2;
            let flyer = Flyer {
                true_airspeed_mps,
                turn_radius_m: self.turn_radius_m,
                wind_mps: Point { x: air.east_mps, y: air.north_mps },
            };
            let way = flyer.quickest(Pose { point: here, track_rad: Some(track_rad) }, gate);
            if let Some(way) = way {
                let late_s = at_s + way.time_s - start.begin_s;
                if let Some((before_s, before_late_s)) = before
                    && before_late_s < 0.0
                    && late_s >= 0.0
                    && late_s - before_late_s <= JUMP_S
                {
                    let share = -before_late_s / (late_s - before_late_s);
                    return Some(before_s + share * (stay_s - before_s));
                }
                let cost = self.cost_of_lateness(late_s);
                if best.is_none_or(|(least, _)| cost < least) {
                    best = Some((cost, stay_s));
                }
                before = Some((stay_s, late_s));
            }
            let track_deg = geodesy::wrap_360((FRAC_PI_2 - track_rad) / RAD_PER_DEG);
            let over_ground = wind::triangle(track_deg, true_airspeed_mps, air)?;
            angle_rad += sense * over_ground.ground_speed_mps * STEP_S / radius_m;
            here = Point { x: radius_m * libm::cos(angle_rad), y: radius_m * libm::sin(angle_rad) };
            stay_s += STEP_S;
        }
        best.map(|(_, stay_s)| stay_s)
    }

    /// Returns the cost of an arrival at the lead-in that is `late_s` late; negative is early. An arrival that is earlier than the lead-in
    /// lasts begins the line too early.
    fn cost_of_lateness(&self, late_s: f64) -> f64 {
        if late_s < -self.lead_in_s { -EARLY_PRICE * late_s } else { late_s.abs() }
    }
}

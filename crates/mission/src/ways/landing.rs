//! Paths to an airfield: chooses an open final approach and the way onto it.

use super::limits::{GROUND, Limits};
use super::route::{CIRCLE_ROOM, HOLD_S_MIN, MARGIN_SHARES, Strictness};
use super::{Broken, Request, Way};
use apex_geo::geodesy;
use apex_geo::travel::TravelError;
use apex_geo::wind;
use apex_model::problem::Position;
use std::cell::OnceCell;

/// Number of candidate directions of the final approach, beginning with the one into the wind.
const COURSES: usize = 12;
/// Wind below which a vehicle lands in the direction of its arrival.
const CALM_MPS: f64 = 1.0;
/// Clearance next to a final approach.
const APPROACH_ROOM_M: f64 = 1_000.0;
/// An approach with a way that takes this much longer than the descent is compared with those of other directions, and a step away from
/// the wind counts as this much time.
const LONG_S: f64 = 600.0;
const STEP_S: f64 = 60.0;
/// Share of the way from a circle on which the vehicle still descends.
const ON_THE_WAY: f64 = 0.8;
/// Speed of the final approach, as a multiple of the slowest speed.
const APPROACH_SPEED: f64 = 1.3;
/// A rotorcraft at most this far from its field lands without a path to it.
const OVER_FIELD_M: f64 = 100.0;
/// Number of lengths of an extended final approach that are tried.
const STRETCHES: u32 = 4;

/// A landing by a way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Landing {
    /// Course of the final approach; `None` if the vehicle may choose.
    pub(super) course_deg: Option<f64>,
    /// Path to it.
    pub(super) way: Option<Way>,
}

impl Limits {
    /// Returns the landing at the destination of a request, whose altitude is that of the ground.
    pub(super) fn landing(&self, request: &Request) -> Landing {
        let straight = Landing { course_deg: None, way: None };
        if self.are_none() {
            return straight;
        }
        // The vehicle descends while it circles near the airfield.
        let approach_altitude_m = request.to_altitude_m + self.final_approach_height_m;
        let request = Request { to_altitude_m: approach_altitude_m, ..*request };
        let is_fixed_wing = self.turn_radius_m > 0.0;
        let approach_m = if is_fixed_wing { self.final_approach_m } else { 0.0 };
        let around = Request { circle_radius_m: approach_m + 2.0 * self.circle_radius_m(), ..request };
        if self.is_straight_open(&around) {
            return Landing { course_deg: self.course_over_low_ground_deg(&request), way: None };
        }
        if !is_fixed_wing {
            // The vehicle descends over the field: before that it keeps its altitude. Over the field no path is needed.
            let level = Request { to_altitude_m: request.from_altitude_m.max(approach_altitude_m), ..request };
            let is_there = geodesy::distance_m(request.from, request.to) <= OVER_FIELD_M;
            return Landing { course_deg: None, way: if is_there { None } else { self.best_way(&level) } };
        }
        let here = wind::at(&self.wind, request.to, approach_altitude_m, request.at_s);
        let into_deg = libm::atan2(-here.east_mps, -here.north_mps).to_degrees();
        let descent = DescentCircle::new();
        let down_s = (request.from_altitude_m - approach_altitude_m).max(0.0) / self.descent_rate_mps;
        let least_s = down_s.max(self.straight(&request, request.to).time_s);
        let mut closed = None;
        for margins in MARGIN_SHARES {
            // Obstacles of the least margins: those of wider ones need not close anything.
            closed = None;
            let mut best: Option<(f64, Landing)> = None;
            for index in 0..COURSES {
                let (course_deg, steps) = (aside_deg(into_deg, index), index.div_ceil(2) as f64);
                match self.approach(&request, course_deg, margins, &descent) {
                    Ok(way) => {
                        let cost_s = way.hold_s + way.time_s + STEP_S * steps;
                        if best.as_ref().is_none_or(|(best_s, _)| cost_s + LONG_S < *best_s) {
                            best = Some((cost_s, Landing { course_deg: Some(course_deg), way: Some(way) }));
                        }
                        if cost_s <= least_s + LONG_S {
                            break;
                        }
                    }
                    Err(reason) => closed = Closed::first(closed, reason),
                }
            }
            if let Some((_, landing)) = best {
                return landing;
            }
        }
        self.landing_anyway(&request, closed)
    }

    /// Returns the landing with the least violation: the way to an open final approach through what closes that way, or straight to the
    /// field if no final approach is open.
    fn landing_anyway(&self, request: &Request, closed: Option<Closed>) -> Landing {
        match closed {
            Some(Closed::Way { course_deg, reason }) => {
                let begin = self.approach_begin(request, course_deg);
                let onto = Request { to: begin, to_track_rad: Some(course_deg.to_radians()), ..*request };
                let mut way = self.required_way(&onto);
                way.via.push(begin);
                if way.broken.is_none() {
                    let around = Request { from: begin, to: begin, ..*request };
                    let name = self.shut_by(&around, (CIRCLE_ROOM * self.circle_radius_m(), 0.0));
                    let name = name.unwrap_or_else(|| self.name_of(&reason));
                    way.broken =
                        Some(Broken::one(name, "no place within reach has room for the circles of the descent"));
                }
                Landing { course_deg: Some(course_deg), way: Some(way) }
            }
            Some(Closed::Final(name)) => {
                let broken = Some(Broken::one(name, "every final approach is closed"));
                let way = Way { broken, ..self.straight(request, request.to) };
                Landing { course_deg: None, way: Some(way) }
            }
            None => Landing { course_deg: None, way: None },
        }
    }

    /// Returns the course of the final approach nearest to the vehicle's own choice whose glide path is clear of the terrain; `None` if it
    /// may choose, and if no glide path is clear.
    fn course_over_low_ground_deg(&self, request: &Request) -> Option<f64> {
        if self.terrain.is_none() || self.turn_radius_m <= 0.0 {
            return None;
        }
        let here = wind::at(&self.wind, request.to, request.to_altitude_m, request.at_s);
        let is_calm = libm::hypot(here.east_mps, here.north_mps) < CALM_MPS;
        let own_deg = match is_calm {
            true => geodesy::azimuth_deg(request.from, request.to),
            false => libm::atan2(-here.east_mps, -here.north_mps).to_degrees(),
        };
        let lead_m = self.lead_in_s * (self.true_airspeed_mps + self.wind_mps_max());
        let field_m = request.to_altitude_m - self.final_approach_height_m;
        let is_clear = |course_deg: &f64| {
            let out_deg = geodesy::wrap_360(*course_deg + 180.0);
            let begin = geodesy::destination(request.to, out_deg, self.final_approach_m + lead_m);
            self.approach_is_clear(begin, request.to, field_m)
        };
        let number = (0..COURSES).position(|index| is_clear(&aside_deg(own_deg, index)))?;
        (number > 0).then(|| aside_deg(own_deg, number))
    }

    fn straight(&self, request: &Request, to: Position) -> Way {
        Way {
            via: Vec::new(),
            altitude_m: request.to_altitude_m,
            hold_s: 0.0,
            hold_around: None,
            time_s: geodesy::distance_m(request.from, to) / self.true_airspeed_mps,
            broken: None,
        }
    }

    /// Returns the place before a final approach at which the vehicle is to fly in its direction, at the altitude of the approach.
    fn approach_begin(&self, request: &Request, course_deg: f64) -> Position {
        let lead_m = self.lead_in_s * (self.true_airspeed_mps + self.wind_mps_max());
        geodesy::destination(request.to, geodesy::wrap_360(course_deg + 180.0), self.final_approach_m + lead_m)
    }

    /// Returns the way onto the final approach with this course.
    ///
    /// # Errors
    /// The reason for which the approach, or every path to it, is closed.
    fn approach(
        &self,
        request: &Request,
        course_deg: f64,
        margins: f64,
        descent: &DescentCircle,
    ) -> Result<Way, Closed> {
        let begin = self.approach_begin(request, course_deg);
        let final_leg = Request { from: begin, from_altitude_m: request.to_altitude_m, ..*request };
        if let Some(name) = self.shut_by(&final_leg, (APPROACH_ROOM_M, margins)) {
            return Err(Closed::Final(name));
        }
        if !self.approach_is_clear(begin, request.to, request.to_altitude_m - self.final_approach_height_m) {
            return Err(Closed::Final(GROUND.to_string()));
        }
        let onto = Request { to: begin, to_track_rad: Some(course_deg.to_radians()), ..*request };
        let strict = Strictness::without_circles(margins);
        let closed = |reason| Closed::Way { course_deg, reason };
        let mut way = self.way(&onto, &strict).map_err(closed)?;
        let late_s = self.late_s(&onto, &way);
        if late_s <= HOLD_S_MIN {
            way.via.push(begin);
            return Ok(way);
        }
        let found = self.way_after_circle(&onto, request.to, descent.find(self, &onto), &strict);
        let found = found.or_else(|| self.straight_in(&onto, request.to, late_s, &strict));
        if let Some(mut found) = found {
            found.via.push(begin);
            return Ok(found);
        }
        // The vehicle circles at the beginning of the approach until it has descended.
        let around = Request { from: begin, ..onto };
        if self.shut_by(&around, (CIRCLE_ROOM * self.circle_radius_m(), margins)).is_some() {
            return Err(closed(TravelError::NoRoomToTurn));
        }
        way.via.push(begin);
        Ok(way)
    }

    /// Returns the time that is missing on a way for the descent to the altitude of its end.
    fn late_s(&self, request: &Request, way: &Way) -> f64 {
        let down_m = (request.from_altitude_m - request.to_altitude_m).max(0.0);
        down_m / self.descent_rate_mps - way.hold_s - way.time_s
    }

    /// Returns the way of a vehicle that first descends on the circle around `centre`. It leaves the circle in any direction, so that the
    /// turn onto the approach ends a turn radius before its beginning, if there is space.
    fn way_after_circle(
        &self,
        request: &Request,
        field: Position,
        centre: Option<Position>,
        strict: &Strictness,
    ) -> Option<Way> {
        let centre = centre?;
        let lengths_m = [self.turn_radius_m_over_ground(), 0.0];
        lengths_m.into_iter().find_map(|extra_m| self.way_from_circle(request, (centre, field), extra_m, strict))
    }

    /// Returns the way of a vehicle that descends on the circle around `centre` and then joins the extension of the final approach, `extra_m`
    /// before the beginning of that approach. It leaves the circle as soon as it can reach the altitude of the approach on the rest of the way.
    fn way_from_circle(
        &self,
        request: &Request,
        (centre, field): (Position, Position),
        extra_m: f64,
        strict: &Strictness,
    ) -> Option<Way> {
        let down_m = (request.from_altitude_m - request.to_altitude_m).max(0.0);
        let down_s = down_m / self.descent_rate_mps;
        // Until the end of the wait the vehicle must have reached the circle.
        let slowest_mps = (self.true_airspeed_mps - self.wind_mps_max()).max(1.0);
        let reach_s = (geodesy::distance_m(request.from, centre) + self.circle_radius_m()) / slowest_mps;
        // As plans count a landing, the approach is a part of the descent; but the vehicle cannot descend faster than it is able to.
        let extra_s = extra_m / (self.true_airspeed_mps + self.wind_mps_max());
        let approach_s = self.final_approach_m / (APPROACH_SPEED * self.indicated_airspeed_mps_min).max(1.0);
        let least_s = reach_s.max(down_m / self.descent_rate_mps_max);
        // The way of a vehicle that is still `left_m` above the approach when it leaves the circle after a time.
        let leave = |left_m: f64| {
            let after_s = (down_s - left_m / self.descent_rate_mps - extra_s - approach_s).max(least_s);
            let from_altitude_m = request.to_altitude_m + left_m;
            let at_s = request.at_s + after_s;
            let from = Request { from: centre, from_altitude_m, from_track_rad: None, at_s, ..*request };
            let way = self.way_onto_extension(&from, field, extra_m, strict)?;
            Some(Way { hold_s: after_s + way.hold_s, hold_around: Some(centre), ..way })
        };
        let level = leave(0.0)?;
        let left_m = (ON_THE_WAY * (level.time_s - extra_s) * self.descent_rate_mps).min(down_m);
        Some(leave(left_m).filter(|way| way.hold_s < level.hold_s).unwrap_or(level))
    }

    /// Returns the way to the final approach that joins its extension so far out that the vehicle descends on it, without circles.
    fn straight_in(&self, request: &Request, field: Position, late_s: f64, strict: &Strictness) -> Option<Way> {
        let fastest_mps = self.true_airspeed_mps + self.wind_mps_max();
        let mut extra_m = late_s * fastest_mps;
        for _ in 0..STRETCHES {
            let way = self.way_onto_extension(request, field, extra_m, strict)?;
            let late_s = self.late_s(request, &way);
            if late_s <= HOLD_S_MIN {
                return Some(way);
            }
            extra_m += late_s * fastest_mps;
        }
        None
    }

    /// Returns the way to the beginning of a final approach that joins its extension `extra_m` before it.
    fn way_onto_extension(&self, request: &Request, field: Position, extra_m: f64, strict: &Strictness) -> Option<Way> {
        if extra_m <= 0.0 {
            return self.way(request, strict).ok();
        }
        let far = geodesy::destination(request.to, geodesy::azimuth_deg(field, request.to), extra_m);
        let leg = Request { from: far, to_track_rad: None, ..*request };
        let field_m = request.to_altitude_m - self.final_approach_height_m;
        let is_shut = self.shut_by(&leg, (APPROACH_ROOM_M, strict.margins)).is_some();
        if is_shut || !self.approach_is_clear(far, field, field_m) {
            return None;
        }
        let mut way = self.way(&Request { to: far, ..*request }, strict).ok()?;
        way.via.push(far);
        way.time_s += extra_m / (self.true_airspeed_mps + self.wind_mps_max());
        Some(way)
    }
}

/// Returns a candidate course: 0, -30, 30, -60, 60 .. degrees away from the first a step at a time.
fn aside_deg(first_deg: f64, index: usize) -> f64 {
    let step = index.div_ceil(2) as f64 * if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    geodesy::wrap_360(first_deg + step * 360.0 / COURSES as f64)
}

/// Reason for which a final approach cannot be flown.
enum Closed {
    /// The approach itself is closed, by this obstacle.
    Final(String),
    /// The approach is open, but no path or no descent to it.
    Way { course_deg: f64, reason: TravelError },
}

impl Closed {
    /// Returns the first reason; one of an open approach precedes those of closed ones.
    fn first(before: Option<Closed>, other: Closed) -> Option<Closed> {
        match (&before, &other) {
            (None, _) | (Some(Closed::Final(_)), Closed::Way { .. }) => Some(other),
            _ => before,
        }
    }
}

/// Centre of the circle on which a vehicle descends before it flies to its approach: searched once for all approaches.
struct DescentCircle(OnceCell<Option<Position>>);

impl DescentCircle {
    fn new() -> DescentCircle {
        DescentCircle(OnceCell::new())
    }

    fn find(&self, limits: &Limits, request: &Request) -> Option<Position> {
        *self.0.get_or_init(|| {
            let stay_s = (request.from_altitude_m - request.to_altitude_m).max(0.0) / limits.descent_rate_mps;
            limits.circle_from_here(&Request { to: request.from, to_track_rad: None, stay_s, ..*request })
        })
    }
}

/// Returns the point on a line at a distance from its beginning (negative: before it), and the course there.
pub(super) fn on_line(from: Position, to: Position, along_m: f64) -> (Position, f64) {
    let azimuth_deg = geodesy::azimuth_deg(from, to);
    let there = if along_m >= 0.0 {
        geodesy::destination(from, azimuth_deg, along_m)
    } else {
        geodesy::destination(from, geodesy::wrap_360(azimuth_deg + 180.0), -along_m)
    };
    let course_deg = if along_m >= 0.0 {
        geodesy::azimuth_deg(there, geodesy::destination(there, azimuth_deg, 1_000.0))
    } else {
        geodesy::azimuth_deg(there, from)
    };
    (there, course_deg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mission;
    use apex_model::problem::{AirspaceZone, TimeWindow, ZoneKind};

    const FIELD: Position = Position { latitude_deg: 40.0, longitude_deg: -120.0 };
    const HIGH_M: f64 = 10_000.0;

    /// Returns the limits of a mission's vehicle with a square zone of 40 km whose northern edge is `south_m` away from the field.
    fn limits_beside(mission: &str, south_m: f64) -> Limits {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(mission);
        let mut limits = Limits::of(&Mission::load(&folder).unwrap());
        let corner = |east_m: f64, south_m: f64| {
            let there = geodesy::destination(FIELD, 180.0, south_m);
            geodesy::destination(there, 90.0, east_m)
        };
        let far_m = south_m + 40_000.0;
        limits.zones = vec![AirspaceZone {
            name: "south".to_string(),
            kind: ZoneKind::Restricted,
            corners: vec![
                corner(-20_000.0, south_m),
                corner(20_000.0, south_m),
                corner(20_000.0, far_m),
                corner(-20_000.0, far_m),
            ],
            altitude_m_min: 0.0,
            altitude_m_max: 20_000.0,
            active: TimeWindow::ALWAYS,
        }];
        limits.wind.layers.clear();
        limits.patches.clear();
        (limits.terrain, limits.landing_distance_m_max, limits.margin_m) = (None, None, 0.0);
        limits
    }

    /// Returns the request for a landing at the field by a vehicle that flies north.
    fn from(from: Position, from_altitude_m: f64) -> Request {
        Request {
            from,
            from_altitude_m,
            from_track_rad: Some(0.0),
            at_s: 3_600.0,
            to: FIELD,
            to_altitude_m: 0.0,
            to_track_rad: None,
            circle_radius_m: 0.0,
            stay_s: 0.0,
        }
    }

    /// Returns the landing of a Predator B over the field, and the time that its descent takes.
    fn landing(south_m: f64) -> (Landing, f64) {
        let limits = limits_beside("western-states", south_m);
        (limits.landing(&from(FIELD, HIGH_M)), (HIGH_M - limits.final_approach_height_m) / limits.descent_rate_mps)
    }

    #[test]
    fn a_zone_next_to_the_circle_of_a_descent_closes_no_approach() {
        for south_m in [4_000.0, 6_000.0, 8_000.0] {
            let (found, down_s) = landing(south_m);
            let way = found.way.unwrap();
            assert_eq!(way.broken, None, "{south_m} m");
            assert!(way.hold_around.is_some() && way.hold_s <= down_s, "{south_m} m: {} of {down_s} s", way.hold_s);
            assert!(way.hold_s + way.time_s >= 0.6 * down_s, "{south_m} m: the aircraft has time to descend");
        }
    }

    #[test]
    fn approaches_are_closed_where_a_zone_covers_the_field() {
        let broken = landing(-10_000.0).0.way.unwrap().broken.unwrap();
        assert_eq!(broken, Broken::one("south".into(), "every final approach is closed"));
    }

    #[test]
    fn a_rotorcraft_keeps_its_altitude_on_the_way_to_its_field() {
        let limits = limits_beside("structure-watch", 500.0);
        let behind = geodesy::destination(FIELD, 180.0, 45_000.0);
        let way = limits.landing(&from(behind, 120.0)).way.unwrap();
        assert!(!way.via.is_empty() && way.altitude_m == 120.0, "{way:?}");
        let over = limits_beside("structure-watch", -500.0);
        assert_eq!(over.landing(&from(FIELD, 120.0)).way, None, "a zone over the field leads no vehicle away from it");
    }
}

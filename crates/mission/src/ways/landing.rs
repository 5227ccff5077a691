//! Paths to an airfield: chooses an open final approach and the way onto it.

use super::limits::{GROUND, Limits};
use super::route::{CIRCLE_ROOM, MARGIN_SHARES, Strictness};
use super::{Broken, Request, Way};
use apex_geo::geodesy;
use apex_geo::wind;
use apex_model::problem::Position;

/// Number of candidate directions of the final approach, beginning with the one into the wind.
const COURSES: usize = 12;
/// Wind below which a vehicle lands in the direction of its arrival.
const CALM_MPS: f64 = 1.0;
/// Clearance next to a final approach.
const APPROACH_ROOM_M: f64 = 1_000.0;

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
            return Landing { course_deg: None, way: self.best_way(&request) };
        }
        let here = wind::at(&self.wind, request.to, approach_altitude_m, request.at_s);
        let into_deg = libm::atan2(-here.east_mps, -here.north_mps).to_degrees();
        let mut shut_by = None;
        for margins in MARGIN_SHARES {
            for index in 0..COURSES {
                let course_deg = aside_deg(into_deg, index);
                match self.approach(&request, course_deg, margins) {
                    Ok(way) => return Landing { course_deg: Some(course_deg), way: Some(way) },
                    Err(name) => shut_by = shut_by.or(Some(name)),
                }
            }
        }
        let name = shut_by.unwrap_or_else(|| "airspace".to_string());
        let why = "every final approach, or the descent to it, is closed".to_string();
        let way = Way { broken: Some(Broken { name, why }), ..self.straight(&request, request.to) };
        Landing { course_deg: None, way: Some(way) }
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

    /// Returns the way onto the final approach with this course.
    ///
    /// # Errors
    /// The reason for which the approach, or every path to it, is closed.
    fn approach(&self, request: &Request, course_deg: f64, margins: f64) -> Result<Way, String> {
        let out_deg = geodesy::wrap_360(course_deg + 180.0);
        let lead_m = self.lead_in_s * (self.true_airspeed_mps + self.wind_mps_max());
        let begin = geodesy::destination(request.to, out_deg, self.final_approach_m + lead_m);
        // The vehicle cannot descend before it circles at the beginning of the approach.
        let above = Request { to: request.from, ..*request };
        let can_descend = self.shut_by(&above, (CIRCLE_ROOM * self.circle_radius_m(), margins)).is_none();
        let room_m = if can_descend { APPROACH_ROOM_M } else { CIRCLE_ROOM * self.circle_radius_m() };
        let final_leg = Request { from: begin, from_altitude_m: request.to_altitude_m, ..*request };
        if let Some(name) = self.shut_by(&final_leg, (room_m, margins)) {
            return Err(name);
        }
        let field_m = request.to_altitude_m - self.final_approach_height_m;
        if !self.approach_is_clear(begin, request.to, field_m) {
            return Err(GROUND.to_string());
        }
        let to_begin = Request { to: begin, to_track_rad: Some(course_deg.to_radians()), ..*request };
        let strict = Strictness::all(margins);
        let mut way = self.way(&to_begin, &strict).map_err(|trouble| self.name_of(&trouble))?;
        way.via.push(begin);
        Ok(way)
    }
}

/// Returns a candidate course: 0, -30, 30, -60, 60 .. degrees away from the first a step at a time.
fn aside_deg(first_deg: f64, index: usize) -> f64 {
    let step = index.div_ceil(2) as f64 * if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    geodesy::wrap_360(first_deg + step * 360.0 / COURSES as f64)
}

/// Space for a circle around its centre, as a multiple of its radius, because joining it swings out.
const AROUND_ROOM: f64 = 1.4;
/// Share of the margins that circles keep.
const CIRCLE_MARGINS: f64 = 0.2;
/// Distances from a place at which circles are tried.
const ASIDE_M: f64 = 2_000.0;
const ASIDES: usize = 60;
const ASIDE_DIRECTIONS: usize = 24;

impl Limits {
    /// Returns the place nearest to the destination around which a circle is open for the whole stay; otherwise the destination itself
    /// and the reason. A vehicle inside the circle at the beginning needs more space, because it joins the circle from within.
    pub(super) fn circle_centre(&self, request: &Request) -> (Position, Option<String>) {
        if self.are_none() {
            return (request.to, None);
        }
        let radius_m = self.circle_radius_m();
        // A vehicle that circles at its present place climbs or descends on the circle; elsewhere it arrives at the altitude.
        let is_here = geodesy::distance_m(request.from, request.to) < radius_m;
        let from_altitude_m = if is_here { request.from_altitude_m } else { request.to_altitude_m };
        let shut_by = |centre: Position| {
            let there = Request { from: centre, to: centre, from_altitude_m, ..*request };
            let is_within = geodesy::distance_m(request.from, centre) < radius_m;
            let width = if is_within { CIRCLE_ROOM } else { AROUND_ROOM };
            self.shut_by(&there, (width * radius_m, CIRCLE_MARGINS))
        };
        let Some(name) = shut_by(request.to) else { return (request.to, None) };
        for aside in 1..=ASIDES {
            for direction in 0..ASIDE_DIRECTIONS {
                let azimuth_deg = 360.0 * direction as f64 / ASIDE_DIRECTIONS as f64;
                let centre = geodesy::destination(request.to, azimuth_deg, ASIDE_M * aside as f64);
                if shut_by(centre).is_none() {
                    return (centre, None);
                }
            }
        }
        (request.to, Some(name))
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

//! Circles on which the vehicle waits, climbs or descends: the nearest place at which one is open, and the way onto it.

use super::limits::{Limits, PERMITTED};
use super::route::CIRCLE_ROOM;
use super::{Broken, Request};
use apex_geo::geodesy;
use apex_geo::plane::{Plane, Point};
use apex_geo::wind::Wind;
use apex_model::problem::Position;
use apex_requirements::{Motion, Route};

/// Space for a circle around its centre, as a multiple of its radius, because joining it swings out.
const AROUND_ROOM: f64 = 1.4;
/// Share of the margins that circles keep.
const CIRCLE_MARGINS: f64 = 0.2;
/// Distances from a place at which circles are tried.
const ASIDE_M: f64 = 2_000.0;
const ASIDES: usize = 60;
const ASIDE_DIRECTIONS: usize = 24;

/// Space on both sides of the way onto a circle, as a share of its radius, and the pieces in which it is checked.
const JOIN_ROOM: f64 = 0.4;
const JOIN_STEP_M: f64 = 2_000.0;
const JOIN_STEPS_MAX: f64 = 200.0;
/// Height of the straight climb after take-off, before the first turn, and its speed as a multiple of the slowest one.
pub(crate) const STRAIGHT_CLIMB_M: f64 = 300.0;
pub(super) const CLIMB_SPEED: f64 = 1.4;
/// Distance from a zone at which a path counts as inside.
const TOUCH_M: f64 = 1.0;

impl Limits {
    /// Returns the place nearest to the destination around which a circle is open for the whole stay; otherwise the destination itself
    /// and the reason. A vehicle inside the circle at the beginning needs more space, because it joins the circle from within.
    pub(super) fn circle_centre(&self, request: &Request) -> (Position, Option<String>) {
        self.circle_where(request, |_| true)
    }

    /// Returns the place nearest to the vehicle around which it can wait, climb or descend: the circle is open, and the way onto it.
    /// `None` if there is none.
    pub(super) fn circle_from_here(&self, request: &Request) -> Option<Position> {
        let here = Request { to: request.from, ..*request };
        let space = (JOIN_ROOM * self.circle_radius_m(), CIRCLE_MARGINS);
        let found = self.circle_where(&here, |centre| self.can_join_circle(&here, centre, space));
        found.1.is_none().then_some(found.0)
    }

    fn circle_where(&self, request: &Request, can_join: impl Fn(Position) -> bool) -> (Position, Option<String>) {
        if self.are_none() {
            return (request.to, None);
        }
        let radius_m = self.circle_radius_m();
        // Where the way is too short for the change of altitude, the vehicle climbs or descends on the circle.
        let way_s = geodesy::distance_m(request.from, request.to) / (self.true_airspeed_mps + self.wind_mps_max());
        let is_level = way_s >= self.change_s(request.from_altitude_m, request.to_altitude_m);
        let from_altitude_m = if is_level { request.to_altitude_m } else { request.from_altitude_m };
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
                if shut_by(centre).is_none() && can_join(centre) {
                    return (centre, None);
                }
            }
        }
        (request.to, Some(name))
    }

    /// Returns the centre of the circle on which a fixed wing climbs after a take-off in the direction of `from_track_rad`; `None` if it
    /// can climb on a circle around the place at which it begins to turn.
    ///
    /// # Errors
    /// The zone that no circle within reach avoids.
    pub(super) fn climb_circle(&self, request: &Request) -> Result<Option<Position>, Broken> {
        if self.turn_radius_m <= 0.0 || self.are_none() {
            return Ok(None);
        }
        let straight = self.end_of_straight_climb(request);
        if let Some(name) = self.shut_by(&straight, (TOUCH_M, 0.0)).filter(|name| self.is_zone(name)) {
            return Err(Broken::one(name, "the straight climb after the take-off leads through it"));
        }
        if request.to_altitude_m <= request.from_altitude_m + STRAIGHT_CLIMB_M {
            return Ok(None);
        }
        let begin = self.begin_of_turns(request);
        let room_m = CIRCLE_ROOM * self.circle_radius_m();
        let Some(name) = self.shut_by(&begin, (room_m, CIRCLE_MARGINS)) else { return Ok(None) };
        if !self.is_zone(&name) && name != PERMITTED {
            return Ok(None);
        }
        match self.circle_from_here(&begin) {
            Some(centre) => Ok(Some(centre)),
            None if self.can_join_circle(&begin, begin.from, (0.0, 0.0)) => Ok(None),
            None => Err(Broken::one(name, "no place within reach has room for the circle of the climb")),
        }
    }

    /// Returns true if a limit of this name is a zone.
    fn is_zone(&self, name: &str) -> bool {
        self.zones.iter().any(|zone| zone.name == name)
    }

    /// Returns the climb from the place at which the first turn after a take-off begins.
    fn begin_of_turns(&self, request: &Request) -> Request {
        let airspeed_mps = (CLIMB_SPEED * self.indicated_airspeed_mps_min).min(self.true_airspeed_mps);
        let straight_m = STRAIGHT_CLIMB_M / self.climb_rate_mps * airspeed_mps;
        let from = match request.from_track_rad {
            Some(track_rad) => geodesy::destination(request.from, track_rad.to_degrees(), straight_m),
            None => request.from,
        };
        let stay_s = self.change_s(request.from_altitude_m, request.to_altitude_m);
        let from_altitude_m = request.from_altitude_m + STRAIGHT_CLIMB_M;
        Request { from, to: from, from_altitude_m, stay_s, ..*request }
    }

    /// Returns true if the turn from the vehicle's track towards a circle, the way onto it and the circle are open, with `room_m` on both
    /// sides and this share of the margins.
    fn can_join_circle(&self, request: &Request, centre: Position, (room_m, margins): (f64, f64)) -> bool {
        let plane = Plane::new(request.from);
        let radius_m = self.circle_radius_m();
        let Some(middle) = plane.project(centre) else { return false };
        let motion = Motion {
            true_airspeed_mps: self.true_airspeed_mps,
            wind: Wind::default(),
            turn_radius_m: self.turn_radius_m_over_ground(),
            climb_mps: self.climb_rate_mps,
            descent_mps: self.descent_rate_mps,
        };
        let altitudes_m = (request.from_altitude_m, request.to_altitude_m);
        // A vehicle that may leave in any direction leaves towards the circle.
        let track = request
            .from_track_rad
            .map_or(middle, |track_rad| Point { x: libm::sin(track_rad), y: libm::cos(track_rad) });
        let route = Route::begin(Point::default(), track, altitudes_m, motion).circle(middle, radius_m);
        let step_s = JOIN_STEP_M / self.true_airspeed_mps;
        let count = libm::ceil((route.end_s() / step_s).min(JOIN_STEPS_MAX)) as u32;
        let place = |number: u32| {
            let state = route.at((f64::from(number) * step_s).min(route.end_s()))?;
            Some(plane.position(state.point))
        };
        let is_open = |number: u32| {
            let Some((from, to)) = place(number).zip(place(number + 1)) else { return true };
            let leg = Request { from, to, ..*request };
            self.shut_by(&leg, (room_m, margins)).is_none()
        };
        (0..count).all(is_open)
    }
}

//! The commanded route: straight pieces and arcs on a local plane, flown at known speeds, with a climb or descent.

use crate::response::drifted_radius_m;
use apex_geo::plane::Point;
use apex_geo::wind::{GROUND_SPEED_MPS_MIN, Wind, triangle};
use std::f64::consts::{PI, TAU};

/// Motion of a vehicle on a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Airspeed along the route; must be positive.
    pub true_airspeed_mps: f64,
    /// Wind on the route.
    pub wind: Wind,
    /// Radius of its turns in still air; 0 for a vehicle that turns on the spot.
    pub turn_radius_m: f64,
    /// Rate of climb.
    pub climb_mps: f64,
    /// Rate of descent, positive.
    pub descent_mps: f64,
}

/// Predicted state of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteState {
    /// Seconds from now.
    pub after_s: f64,
    /// Point of the plane.
    pub point: Point,
    /// Above mean sea level.
    pub altitude_m: f64,
}

/// A piece of a route.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RoutePiece {
    /// From `from` over `length_m` towards `along` (unit length).
    Straight { from: Point, along: Point, length_m: f64 },
    /// On the circle from the direction `from_rad` (east is 0, north a quarter) over `sweep_rad`, positive to the left.
    Arc { centre: Point, radius_m: f64, from_rad: f64, sweep_rad: f64 },
    /// Stays at a point.
    Stop { at: Point },
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct TimedPiece {
    begin_s: f64,
    duration_s: f64,
    piece: RoutePiece,
}

/// A route from now on. After its end the position is unknown: [`Route::at`] returns `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    motion: Motion,
    pieces: Vec<TimedPiece>,
    /// End of the last piece, and the direction of flight there.
    end: (Point, Point),
    end_s: f64,
    speed_mps_max: f64,
    altitude_m: (f64, f64),
}

impl Route {
    /// Returns a route that begins at `point` in the direction `track` (any length; north if the length is zero), at the altitude
    /// `altitude_m.0`, with `altitude_m.1` commanded.
    pub fn begin(point: Point, track: Point, altitude_m: (f64, f64), motion: Motion) -> Route {
        let track = track.unit().unwrap_or(Point { x: 0.0, y: 1.0 });
        Route { motion, pieces: Vec::new(), end: (point, track), end_s: 0.0, speed_mps_max: 0.0, altitude_m }
    }

    /// Turns towards `to` by the shorter side and flies there in a straight line. A place inside the turning circle is approached
    /// directly.
    pub fn fly_to(mut self, to: Point) -> Route {
        let (from, track) = self.end;
        let radius_m =
            drifted_radius_m(self.motion.turn_radius_m, self.motion.true_airspeed_mps, wind_mps(self.motion.wind));
        if let Some(turn) = Turn::towards(from, track, to, radius_m) {
            self = self.arc(turn.centre, radius_m, turn.from_rad, turn.sweep_rad);
        }
        self.straight(to)
    }

    /// Flies straight to `to`, without a turn before it.
    pub fn straight(mut self, to: Point) -> Route {
        let (from, track) = self.end;
        let way = to.minus(from);
        let along = way.unit().unwrap_or(track);
        let track_deg = libm::atan2(along.x, along.y).to_degrees();
        let over_ground = triangle(track_deg, self.motion.true_airspeed_mps, self.motion.wind);
        let speed_mps = over_ground.map_or(GROUND_SPEED_MPS_MIN, |found| found.ground_speed_mps);
        let length_m = way.length();
        self.push(RoutePiece::Straight { from, along, length_m }, length_m, speed_mps);
        self.end = (to, along);
        self
    }

    /// Flies to the line from `from` to `to`, then along it.
    pub fn fly_line(self, from: Point, to: Point) -> Route {
        self.fly_to(from).fly_to(to)
    }

    /// Turns onto the line through `begin` towards `along` (unit length) by a circle of `radius_m` that touches it at `begin`: straight to
    /// the circle, and along it. Of the circles on both sides it takes the one with the shorter way. Returns the centre, too; `None` where
    /// the vehicle is inside both.
    pub fn join(mut self, (begin, along): (Point, Point), radius_m: f64) -> (Route, Option<Point>) {
        let (from, track) = self.end;
        let joins = [1.0, -1.0].map(|side| LineJoin::of(from, track, (begin, along), (radius_m, side)));
        let shortest = joins.into_iter().flatten().min_by(|a, b| a.cost_m.total_cmp(&b.cost_m));
        let Some(join) = shortest else { return (self.fly_to(begin), None) };
        self = self.fly_to(join.tangent);
        let outward = join.tangent.minus(join.centre);
        let from_rad = libm::atan2(outward.y, outward.x);
        (self.arc(join.centre, radius_m, from_rad, join.sweep_rad), Some(join.centre))
    }

    /// Flies to the circle of `radius_m` around `centre` and once around it, to the side with the smaller turn.
    pub fn circle(mut self, centre: Point, radius_m: f64) -> Route {
        let (from, track) = self.end;
        let outward = from.minus(centre);
        if outward.length() > radius_m + 1.0 {
            // The vehicle turns onto the circle where the straight way to the centre crosses it.
            let unit = outward.unit().unwrap_or(track);
            self = self.fly_to(centre.plus(radius_m, unit));
        } else if outward.length() < radius_m - 1.0 {
            // From inside, straight ahead until the circle.
            let along = outward.dot(track);
            let ahead_m = libm::sqrt(along * along - outward.dot(outward) + radius_m * radius_m) - along;
            self = self.straight(from.plus(ahead_m, track));
        }
        let (from, track) = self.end;
        let outward = from.minus(centre);
        let from_rad = libm::atan2(outward.y, outward.x);
        let sweep_rad = if track.cross(centre.minus(from)) >= 0.0 { TAU } else { -TAU };
        self.arc(centre, radius_m, from_rad, sweep_rad)
    }

    /// Stays where it is for `duration_s`.
    pub fn stop(mut self, duration_s: f64) -> Route {
        let at = self.end.0;
        self.pieces.push(TimedPiece { begin_s: self.end_s, duration_s, piece: RoutePiece::Stop { at } });
        self.end_s += duration_s;
        self
    }

    fn arc(mut self, centre: Point, radius_m: f64, from_rad: f64, sweep_rad: f64) -> Route {
        let length_m = radius_m * sweep_rad.abs();
        let piece = RoutePiece::Arc { centre, radius_m, from_rad, sweep_rad };
        self.push(piece, length_m, self.motion.true_airspeed_mps);
        let end_rad = from_rad + sweep_rad;
        let outward = Point { x: libm::cos(end_rad), y: libm::sin(end_rad) };
        let side = sweep_rad.signum();
        self.end = (centre.plus(radius_m, outward), Point { x: -side * outward.y, y: side * outward.x });
        self
    }

    fn push(&mut self, piece: RoutePiece, length_m: f64, speed_mps: f64) {
        if length_m <= 0.0 {
            return;
        }
        let duration_s = length_m / speed_mps.max(GROUND_SPEED_MPS_MIN);
        self.pieces.push(TimedPiece { begin_s: self.end_s, duration_s, piece });
        self.end_s += duration_s;
        self.speed_mps_max = self.speed_mps_max.max(speed_mps);
    }

    /// Returns the end of the last piece, in seconds from now.
    pub fn end_s(&self) -> f64 {
        self.end_s
    }

    /// Returns the end of the route, and the direction of flight there (unit length).
    pub fn end(&self) -> (Point, Point) {
        self.end
    }

    /// Returns an upper bound of the speed in space on the whole route.
    pub fn speed_mps_max(&self) -> f64 {
        let vertical_mps = self.motion.climb_mps.max(self.motion.descent_mps);
        libm::hypot(self.speed_mps_max, vertical_mps)
    }

    /// Returns the state `after_s` seconds from now; `None` before now and after the end.
    pub fn at(&self, after_s: f64) -> Option<RouteState> {
        if !(after_s >= 0.0 && after_s <= self.end_s) {
            return None;
        }
        let number = self.pieces.partition_point(|piece| piece.begin_s <= after_s);
        let point = match self.pieces.get(number.checked_sub(1)?) {
            None => self.end.0,
            Some(TimedPiece { begin_s, duration_s, piece }) => {
                let share = if *duration_s > 0.0 { ((after_s - begin_s) / duration_s).min(1.0) } else { 1.0 };
                match *piece {
                    RoutePiece::Straight { from, along, length_m } => from.plus(share * length_m, along),
                    RoutePiece::Stop { at } => at,
                    RoutePiece::Arc { centre, radius_m, from_rad, sweep_rad } => {
                        let angle_rad = from_rad + share * sweep_rad;
                        let outward = Point { x: libm::cos(angle_rad), y: libm::sin(angle_rad) };
                        centre.plus(radius_m, outward)
                    }
                }
            }
        };
        Some(RouteState { after_s, point, altitude_m: self.altitude_m_at(after_s) })
    }

    /// Returns true if the commanded altitude is reached by the end of the last piece.
    pub fn is_level_at_end(&self) -> bool {
        (self.altitude_m_at(self.end_s) - self.altitude_m.1).abs() < LEVEL_M
    }

    fn altitude_m_at(&self, after_s: f64) -> f64 {
        let (now_m, commanded_m) = self.altitude_m;
        if commanded_m >= now_m {
            (now_m + self.motion.climb_mps * after_s).min(commanded_m)
        } else {
            (now_m - self.motion.descent_mps * after_s).max(commanded_m)
        }
    }
}

/// Difference to the commanded altitude up to which a vehicle flies level.
const LEVEL_M: f64 = 10.0;

fn wind_mps(wind: Wind) -> f64 {
    libm::hypot(wind.east_mps, wind.north_mps)
}

/// A turn that ends on a tangent through a place.
struct Turn {
    centre: Point,
    from_rad: f64,
    sweep_rad: f64,
}

impl Turn {
    /// Returns the turn from `track` at `from`; `None` if no turn is needed, or the place is inside the turning circle.
    fn towards(from: Point, track: Point, to: Point, radius_m: f64) -> Option<Turn> {
        let way = to.minus(from);
        let aside = track.cross(way);
        if radius_m <= 0.0 || (aside.abs() <= 1e-9 * way.length() && track.dot(way) >= 0.0) {
            return None;
        }
        // Left is positive: the centre is a quarter turn left of the track.
        let side = if aside >= 0.0 { 1.0 } else { -1.0 };
        let centre = Point { x: from.x - side * track.y * radius_m, y: from.y + side * track.x * radius_m };
        let away = to.minus(centre);
        let distance_m = away.length();
        if distance_m <= radius_m {
            return None;
        }
        // The tangent point is seen from the centre at `acos(r/d)` before the place.
        let before_rad = libm::acos(radius_m / distance_m);
        let end_rad = libm::atan2(away.y, away.x) - side * before_rad;
        let outward = from.minus(centre);
        let from_rad = libm::atan2(outward.y, outward.x);
        let mut sweep_rad = libm::fmod(side * (end_rad - from_rad), TAU);
        if sweep_rad < 0.0 {
            sweep_rad += TAU;
        }
        // Rounding may turn a zero turn into a whole circle.
        if sweep_rad > TAU - 1e-9 {
            sweep_rad = 0.0;
        }
        (sweep_rad > 0.0).then_some(Turn { centre, from_rad, sweep_rad: side * sweep_rad })
    }
}

/// A turn onto a line, by a circle that touches it.
struct LineJoin {
    centre: Point,
    /// The place at which the straight way meets the circle.
    tangent: Point,
    /// Positive to the left.
    sweep_rad: f64,
    cost_m: f64,
}

/// A turn of more than this is none: the vehicle is in line, seen from the other side.
const WHOLE_TURN_RAD: f64 = 6.2;

impl LineJoin {
    /// Returns the turn by the circle on the left (`side` 1) or right (-1) of the line; `None` from inside of it.
    fn of(from: Point, track: Point, (begin, along): (Point, Point), (radius_m, side): (f64, f64)) -> Option<LineJoin> {
        let normal = Point { x: -side * along.y, y: side * along.x };
        let centre = begin.plus(radius_m, normal);
        let way = centre.minus(from);
        let gap_m = way.length();
        if gap_m <= radius_m {
            return None;
        }
        let course_rad = libm::atan2(way.y, way.x) - side * libm::asin(radius_m / gap_m);
        let straight_m = libm::sqrt(gap_m * gap_m - radius_m * radius_m);
        let tangent = from.plus(straight_m, Point { x: libm::cos(course_rad), y: libm::sin(course_rad) });
        let turn_rad = |from_rad: f64, to_rad: f64| {
            let turned = libm::fmod(side * (to_rad - from_rad), TAU);
            if turned < 0.0 { turned + TAU } else { turned }
        };
        let turned_rad = turn_rad(course_rad, libm::atan2(along.y, along.x));
        let arc_rad = if turned_rad > WHOLE_TURN_RAD { 0.0 } else { turned_rad };
        let first_rad = turn_rad(libm::atan2(track.y, track.x), course_rad);
        let cost_m = straight_m + radius_m * (arc_rad + first_rad.min(TAU - first_rad));
        Some(LineJoin { centre, tangent, sweep_rad: side * arc_rad, cost_m })
    }
}

/// Returns the time of half a turn at `radius_m`: 94 s for 95 m/s and 18 degrees of bank.
pub fn half_turn_s(radius_m: f64, true_airspeed_mps: f64) -> f64 {
    PI * radius_m / true_airspeed_mps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(turn_radius_m: f64) -> Motion {
        Motion { true_airspeed_mps: 50.0, wind: Wind::default(), turn_radius_m, climb_mps: 5.0, descent_mps: 4.0 }
    }

    fn p(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    #[test]
    fn a_straight_route_is_flown_at_its_speed() {
        let route = Route::begin(p(0.0, 0.0), p(0.0, 1.0), (100.0, 130.0), motion(500.0)).fly_to(p(0.0, 1_000.0));
        assert!((route.end_s() - 20.0).abs() < 1e-12);
        let middle = route.at(10.0).unwrap();
        assert!((middle.point.y - 500.0).abs() < 1e-9 && middle.point.x == 0.0);
        assert_eq!(middle.altitude_m, 130.0, "6 s of climb");
        assert_eq!(route.at(2.0).unwrap().altitude_m, 110.0);
        assert_eq!((route.at(-0.1), route.at(20.1)), (None, None));
    }

    #[test]
    fn a_turn_is_continuous_and_ends_on_the_tangent() {
        for to in [p(3_000.0, 1_000.0), p(-3_000.0, -500.0), p(20.0, -5_000.0), p(-1.0, -4_000.0)] {
            let route = Route::begin(p(0.0, 0.0), p(0.0, 1.0), (0.0, 0.0), motion(500.0)).fly_to(to);
            let step_s = 0.01;
            let mut previous = route.at(0.0).unwrap().point;
            let mut heading: Option<Point> = Some(p(0.0, 1.0));
            for number in 1..=(route.end_s() / step_s) as u32 {
                let here = route.at(f64::from(number) * step_s).unwrap().point;
                let moved = here.minus(previous);
                assert!((moved.length() - 50.0 * step_s).abs() < 1e-2, "no jump at {number} to {to:?}");
                let unit = moved.unit().unwrap();
                // At most 0.1 rad/s of turn: 50 m/s on 500 m.
                assert!(
                    heading.is_none_or(|last| last.dot(unit) > libm::cos(0.1 * step_s * 2.0)),
                    "no kink at {number}"
                );
                (previous, heading) = (here, Some(unit));
            }
            assert!(previous.minus(to).length() < 1.0);
        }
    }

    #[test]
    fn wind_changes_the_speed_over_ground() {
        let wind = Wind { east_mps: 0.0, north_mps: 10.0, edr: 0.0 };
        let with = |to: Point| {
            let start = Route::begin(p(0.0, 0.0), to, (0.0, 0.0), Motion { wind, ..motion(0.0) });
            start.straight(to).end_s()
        };
        assert!((with(p(0.0, 6_000.0)) - 100.0).abs() < 1e-9);
        assert!((with(p(0.0, -4_000.0)) - 100.0).abs() < 1e-9);
        assert!((with(p(4_898.979, 0.0)) - 100.0).abs() < 1e-3, "sqrt(50^2 - 10^2) across");
    }

    #[test]
    fn a_hold_begins_at_the_centre_of_its_circle() {
        let route = Route::begin(p(0.0, 0.0), p(1.0, 0.0), (0.0, 0.0), motion(300.0)).circle(p(0.0, 0.0), 800.0);
        assert_eq!(route.at(0.0).unwrap().point, p(0.0, 0.0));
        assert!((route.at(16.0).unwrap().point.minus(p(800.0, 0.0))).length() < 1e-6);
        assert!((route.at(60.0).unwrap().point.length() - 800.0).abs() < 1e-6);
    }

    /// An aircraft on the line, beyond its beginning, turns back around one of the circles that touch the line there.
    #[test]
    fn a_line_is_joined_in_its_direction() {
        for (from, track) in
            [(p(2_000.0, 300.0), p(1.0, 0.0)), (p(-9_000.0, 4_000.0), p(0.0, -1.0)), (p(500.0, -6_000.0), p(0.0, 1.0))]
        {
            let begin = Route::begin(from, track, (100.0, 100.0), motion(500.0));
            let (route, centre) = begin.join((p(0.0, 0.0), p(1.0, 0.0)), 600.0);
            let centre = centre.unwrap();
            assert!(centre.x.abs() < 1e-6 && (centre.y.abs() - 600.0).abs() < 1e-6, "{centre:?}");
            let (end, along) = route.end();
            assert!(end.length() < 1e-3 && along.x > 1.0 - 1e-9, "{end:?} towards {along:?}");
            assert!(route.is_level_at_end());
        }
    }

    #[test]
    fn a_circle_keeps_its_distance() {
        let route = Route::begin(p(0.0, 0.0), p(1.0, 0.0), (0.0, 0.0), motion(300.0)).circle(p(5_000.0, 0.0), 800.0);
        let last = route.at(route.end_s()).unwrap().point;
        assert!((last.minus(p(5_000.0, 0.0)).length() - 800.0).abs() < 1e-6);
        assert!((route.end_s() - (4_200.0 + TAU * 800.0) / 50.0).abs() < 1e-6);
    }
}

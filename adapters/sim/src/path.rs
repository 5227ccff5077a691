//! Lateral guidance: the course over ground that leads along a path, and the way to join a line with a turn.

pub(crate) use crate::geodesic::bearing;
use crate::motion::{State, wrap_pi, wrap_tau};
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_model::problem::Position;
use libm::{asin, atan, atan2, cos, sin, sqrt};
use std::cell::Cell;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Path to follow.
#[derive(Clone, Debug)]
pub(crate) enum Path {
    /// Keep the heading, wings level.
    Straight,
    /// Straight to a point.
    Point(Position),
    /// Along a line, also before its beginning and after its end.
    Line(Line),
    /// Like `Line`, with a turn of so many radians per metre: a leg of a way, which may be a chord of a turn.
    Leg(Line, f64),
    /// As `Line`, no faster over ground than this (rotorcraft).
    Paced(Line, f64),
    /// Around a point.
    Circle(Circle),
    /// Stay over a point (rotorcraft).
    Hover(Position),
}

/// A geodesic line with its initial azimuth and length.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) from: Position,
    pub(crate) azimuth_rad: f64,
    pub(crate) length_m: f64,
    /// The position that was located last, with the result: guidance and progress ask for the same one several times.
    located: Cell<Option<(Position, OnLine)>>,
}

/// Distance along a line, distance to its right, and the line's course there.
type OnLine = (f64, f64, f64);

/// A circle flown in one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    pub(crate) centre: Position,
    pub(crate) radius_m: f64,
    pub(crate) clockwise: bool,
}

/// Path onto a line: straight to `tangent`, around `turn`, then along the line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Join {
    pub(crate) tangent: Position,
    pub(crate) turn: Circle,
}

/// A course over ground, and the rate at which it turns without a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    pub(crate) course_rad: f64,
    pub(crate) rate_rad_s: f64,
}

impl Line {
    /// Returns the line between two positions.
    pub(crate) fn new(from: Position, to: Position) -> Line {
        let (azimuth_rad, length_m) = bearing(from, to);
        Line { from, azimuth_rad, length_m, located: Cell::new(None) }
    }

    /// Returns the distance along the line, the distance to its right, and the line's course there.
    pub(crate) fn locate(&self, position: Position) -> OnLine {
        let bits = |at: Position| (at.latitude_deg.to_bits(), at.longitude_deg.to_bits());
        if let Some((_, found)) = self.located.get().filter(|(at, _)| bits(*at) == bits(position)) {
            return found;
        }
        let found = self.compute(position);
        self.located.set(Some((position, found)));
        found
    }

    fn compute(&self, position: Position) -> OnLine {
        let (azimuth_rad, distance_m) = bearing(self.from, position);
        let angle = distance_m / geodesy::EARTH_RADIUS_M_MEAN;
        let turn = azimuth_rad - self.azimuth_rad;
        let across = asin((sin(angle) * sin(turn)).clamp(-1.0, 1.0));
        let along = atan2(sin(angle) * cos(turn), cos(angle));
        let middle_rad = 0.5 * (self.from.latitude_deg + position.latitude_deg) * RAD_PER_DEG;
        let east_deg = geodesy::wrap_180(position.longitude_deg - self.from.longitude_deg);
        let convergence = east_deg * RAD_PER_DEG * sin(middle_rad);
        let radius = geodesy::EARTH_RADIUS_M_MEAN;
        (along * radius, across * radius, self.azimuth_rad + convergence)
    }

    /// Returns the line's point `along_m` from its beginning.
    pub(crate) fn point(&self, along_m: f64) -> Position {
        geodesy::destination(self.from, self.azimuth_rad / RAD_PER_DEG, along_m)
    }
}

/// Steepest approach to a line, and seconds of flight within which an offset is corrected.
const INTERCEPT_RAD_MAX: f64 = 0.8;
const INTERCEPT_S: f64 = 6.0;

/// Share of the turn radius within which a vehicle counts as being on a chord of an arc.
const OFF_ARC_SHARE: f64 = 0.5;

/// Returns the course that follows `path` from `state`; `None` to keep the heading. `turn_radius_m` is the tightest turn.
pub(crate) fn course(path: &Path, state: &State, turn_radius_m: f64) -> Option<Course> {
    let speed = state.ground_speed().max(1.0);
    match path {
        Path::Straight => None,
        Path::Point(point) | Path::Hover(point) => {
            let (azimuth_rad, distance_m) = bearing(state.position, *point);
            let off_rad = wrap_pi(azimuth_rad - state.track_rad()).abs();
            if inside_turn(off_rad, distance_m, turn_radius_m) {
                return None;
            }
            Some(Course { course_rad: azimuth_rad, rate_rad_s: 0.0 })
        }
        Path::Line(line) | Path::Paced(line, _) => Some(along(line, state, 0.0)),
        Path::Leg(line, turn_rad_per_m) => {
            let (along_m, across_m, _) = line.locate(state.position);
            // Off the arc, a further turn along it would only circle and drift with the wind.
            let near_m = OFF_ARC_SHARE * turn_radius_m;
            let is_on_arc = across_m.abs() <= near_m && (-near_m..=line.length_m + near_m).contains(&along_m);
            Some(along(line, state, if is_on_arc { turn_rad_per_m * speed } else { 0.0 }))
        }
        Path::Circle(circle) => {
            let (inwards_rad, distance_m) = bearing(state.position, circle.centre);
            let sense = if circle.clockwise { 1.0 } else { -1.0 };
            let error = (distance_m - circle.radius_m) / circle.radius_m;
            let course_rad = inwards_rad - sense * (FRAC_PI_2 - atan(2.5 * error));
            let rate_rad_s = if error.abs() < 0.5 { sense * speed / circle.radius_m } else { 0.0 };
            Some(Course { course_rad, rate_rad_s })
        }
    }
}

/// Returns the course along a line from a position next to it.
fn along(line: &Line, state: &State, rate_rad_s: f64) -> Course {
    let (_, across_m, course_rad) = line.locate(state.position);
    let speed = state.ground_speed().max(1.0);
    let back = FRAC_2_PI * INTERCEPT_RAD_MAX * atan(across_m / (INTERCEPT_S * speed));
    Course { course_rad: course_rad - back, rate_rad_s }
}

/// Returns true if a point at `distance_m`, `off_rad` from the track, is inside the circle of a turn towards it, so that the vehicle
/// would circle it forever if it turned now.
fn inside_turn(off_rad: f64, distance_m: f64, radius_m: f64) -> bool {
    if off_rad < 0.15 || distance_m > 2.2 * radius_m {
        return false;
    }
    let (forward, aside) = (distance_m * cos(off_rad), distance_m * sin(off_rad) - radius_m);
    sqrt(forward * forward + aside * aside) < 1.02 * radius_m
}

/// Returns the shorter of the two joins that reach the line's point `along_m` in its direction, from `state`. It is computed in the plane
/// around that point; the length of the first turn is included, but its path is not planned.
pub(crate) fn join(line: &Line, along_m: f64, radius_m: f64, state: &State) -> Join {
    let goal = line.point(along_m);
    let (_, _, goal_course) = line.locate(goal);
    let (azimuth_rad, distance_m) = bearing(goal, state.position);
    let (east, north) = (distance_m * sin(azimuth_rad), distance_m * cos(azimuth_rad));
    let away_rad = bearing(state.position, goal).0;
    // Convergence of meridians between goal and vehicle turns the track into the goal's plane.
    let track_rad = state.track_rad() + wrap_pi(azimuth_rad + std::f64::consts::PI - away_rad);
    let candidate = |sense: f64| {
        let side = goal_course + sense * FRAC_PI_2;
        let (centre_east, centre_north) = (radius_m * sin(side), radius_m * cos(side));
        let (to_east, to_north) = (centre_east - east, centre_north - north);
        let gap_m = sqrt(to_east * to_east + to_north * to_north);
        if gap_m <= radius_m {
            return None;
        }
        let course_rad = atan2(to_east, to_north) - sense * asin(radius_m / gap_m);
        let straight_m = sqrt(gap_m * gap_m - radius_m * radius_m);
        let mut arc_rad = wrap_tau(sense * (goal_course - course_rad));
        if arc_rad > 6.2 {
            // Practically aligned from the other side: this means no turn instead of a full one.
            arc_rad = 0.0;
        }
        let first_rad = wrap_pi(course_rad - track_rad).abs();
        let cost_m = straight_m + radius_m * (arc_rad + first_rad);
        let tangent = (east + straight_m * sin(course_rad), north + straight_m * cos(course_rad));
        Some((cost_m, tangent, sense))
    };
    let place = |east_m: f64, north_m: f64| {
        let distance_m = sqrt(east_m * east_m + north_m * north_m);
        geodesy::destination(goal, atan2(east_m, north_m) / RAD_PER_DEG, distance_m)
    };
    let best = match (candidate(1.0), candidate(-1.0)) {
        (Some(right), Some(left)) => Some(if right.0 <= left.0 { right } else { left }),
        (one, other) => one.or(other),
    };
    // The two circles touch in only one point, so a vehicle is inside one at most; the fallback is that point.
    let (tangent, sense) = best.map_or(((0.0, 0.0), 1.0), |(_, tangent, sense)| (tangent, sense));
    let side = goal_course + sense * FRAC_PI_2;
    let centre = place(radius_m * sin(side), radius_m * cos(side));
    Join { tangent: place(tangent.0, tangent.1), turn: Circle { centre, radius_m, clockwise: sense > 0.0 } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_line_is_located_to_metres() {
        let (from, to) = (Position::new(40.0, -120.0), Position::new(41.5, -118.0));
        let line = Line::new(from, to);
        let middle = line.point(0.6 * line.length_m);
        let (along, across, course) = line.locate(middle);
        assert!((along - 0.6 * line.length_m).abs() < 5.0 && across.abs() < 5.0, "{along} {across}");
        let there = bearing(middle, to).0;
        assert!(wrap_pi(course - there).abs() < 1e-3, "{course} {there}");
    }

    #[test]
    fn a_line_locates_each_position_as_a_new_line_does() {
        let line = Line::new(Position::new(40.0, -120.0), Position::new(41.5, -118.0));
        for step in 0..200 {
            // Every position twice in sequence, some again later, and both signs of zero.
            let offset = f64::from(step / 2 % 7) * 0.1;
            let sign = if step % 4 < 2 { 1.0 } else { -1.0 };
            for position in [Position::new(40.0 + offset, -119.0), Position::new(sign * 0.0, -119.0 + offset)] {
                let copy = line.clone();
                let fresh = Line::new(Position::new(40.0, -120.0), Position::new(41.5, -118.0)).locate(position);
                let bits = |found: OnLine| (found.0.to_bits(), found.1.to_bits(), found.2.to_bits());
                assert_eq!(bits(line.locate(position)), bits(fresh), "{position:?}");
                assert_eq!(bits(copy.locate(position)), bits(fresh), "{position:?}");
            }
        }
    }

    #[test]
    fn a_point_next_to_the_aircraft_is_inside_its_turn() {
        assert!(inside_turn(1.5, 1000.0, 2000.0));
        assert!(!inside_turn(1.5, 4500.0, 2000.0));
        assert!(!inside_turn(0.01, 100.0, 2000.0));
    }
}

//! The route of an order, from the present position of the vehicle.

use super::commanded::FlightOrder;
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::{Plane, Point};
use apex_requirements::Route;

/// Shortest distance of a degree of latitude (at the equator).
const DEGREE_M: f64 = 110_500.0;

/// Circles of the vehicle.
pub(super) struct Circling {
    /// Centre of the circle of a vehicle that waits or has no order; `None`: its position.
    pub(super) centre: Option<Position>,
    /// Radius over ground; 0 for a vehicle that hovers.
    pub(super) radius_m: f64,
    /// Radius over ground of the turn onto a line, and the distance before the line at which it ends.
    pub(super) join_m: (f64, f64),
    /// Length of the straight flight until a vehicle that takes off begins to turn.
    pub(super) straight_m: f64,
}

/// Returns the route of an order. Without an order the vehicle circles or hovers at its position.
///
/// The first leg begins with a turn from the present track. Corners between legs are flown as planned, with curves; they are sharp here.
pub(super) fn along(
    begin: Route,
    order: Option<&FlightOrder>,
    plane: &Plane,
    circling: &Circling,
    look_ahead_s: f64,
) -> Route {
    let points = |positions: &[Position]| -> Vec<Point> {
        positions.iter().filter_map(|position| plane.project(*position)).collect()
    };
    let by = |route: Route, points: &[Point]| match points.split_first() {
        None => route,
        Some((first, rest)) => rest.iter().fold(route.fly_to(*first), |route, point| route.straight(*point)),
    };
    let hold = |route: Route, centre: Point| match circling.radius_m > 0.0 {
        true => route.circle(centre, circling.radius_m),
        false => route.stop(look_ahead_s),
    };
    match order {
        None => {
            let centre = circling.centre.and_then(|centre| plane.project(centre));
            let centre = centre.unwrap_or(begin.end().0);
            hold(begin, centre)
        }
        // A fixed wing climbs straight ahead at first, then on a circle around the place at which it begins to turn, or another one.
        Some(FlightOrder::TakeOff(centre)) => {
            let (from, track) = begin.end();
            let turns = from.plus(circling.straight_m, track);
            let centre = centre.first().and_then(|centre| plane.project(*centre));
            let route = if circling.radius_m > 0.0 { begin.straight(turns) } else { begin };
            hold(route, centre.unwrap_or(turns))
        }
        Some(FlightOrder::Line(positions)) => match points(positions).as_slice() {
            [before @ .., from, to] => onto_line(by(begin, before), !before.is_empty(), (*from, *to), circling),
            other => by(begin, other),
        },
        // A fixed wing that is not at its altitude at the place circles there.
        Some(FlightOrder::FlyBy(positions)) => {
            let route = by(begin, &points(positions));
            let place = route.end().0;
            if circling.radius_m > 0.0 && !route.is_level_at_end() { hold(route, place) } else { route }
        }
        Some(FlightOrder::Land(positions)) => by(begin, &points(positions)),
        Some(FlightOrder::Stay(positions)) => by(begin, &points(positions)).stop(look_ahead_s),
        Some(FlightOrder::Circle(positions)) => {
            let points = points(positions);
            match points.split_last() {
                None => begin,
                Some((centre, before)) => hold(by(begin, before), *centre),
            }
        }
    }
}

/// Returns the route along a line, with the turn onto it. A fixed wing that is not lined up, or not at the altitude of the line, turns onto
/// it by a circle at its beginning, on which it also climbs or descends. The way of a command ends in line.
fn onto_line(route: Route, is_by_way: bool, (from, to): (Point, Point), circling: &Circling) -> Route {
    let Some(along) = to.minus(from).unit() else { return route.fly_to(to) };
    let (radius_m, lead_m) = circling.join_m;
    let is_level = route.is_level_at_end();
    if is_level && !is_by_way && is_on_line(route.end(), from, to) {
        return route.fly_to(to);
    }
    if radius_m <= 0.0 || (is_level && (is_by_way || is_lined_up(route.end(), from, along))) {
        return route.fly_to(from).straight(to);
    }
    let (route, centre) = route.join((from.plus(-lead_m, along), along), radius_m);
    let route = match centre {
        Some(centre) if !route.is_level_at_end() => route.circle(centre, radius_m),
        _ => route,
    };
    route.straight(from).straight(to)
}

/// Returns true if a vehicle at the beginning of a route is not in line, and no way of its command leads it there.
pub(super) fn is_joining(begin: &Route, order: &FlightOrder, plane: &Plane) -> bool {
    let FlightOrder::Line(positions) = order else { return false };
    let [from, to] = positions.as_slice() else { return false };
    let Some((from, to)) = plane.project(*from).zip(plane.project(*to)) else { return false };
    let Some(along) = to.minus(from).unit() else { return false };
    !is_on_line(begin.end(), from, to) && !is_lined_up(begin.end(), from, along)
}

/// Greatest distance from a line of a vehicle that flies onto it without a further turn, and the cosine of the greatest angle to it.
const LINED_UP_M: f64 = 400.0;
const LINED_UP_COSINE: f64 = 0.939;

/// Returns true if the vehicle is in line before the beginning of a line, or just behind it.
fn is_lined_up((point, track): (Point, Point), from: Point, along: Point) -> bool {
    let passed = point.minus(from);
    along.cross(passed).abs() <= LINED_UP_M && passed.dot(along) <= ON_LINE_M && along.dot(track) >= LINED_UP_COSINE
}

/// A vehicle this near to a line, in about its direction, continues along it.
const ON_LINE_M: f64 = 300.0;
/// Cosine of the largest angle to the line: 30 degrees.
const ON_LINE_COSINE: f64 = 0.866;

pub(super) fn is_on_line((point, track): (Point, Point), from: Point, to: Point) -> bool {
    let Some(along) = to.minus(from).unit() else { return false };
    let passed = point.minus(from);
    let is_near = along.cross(passed).abs() <= ON_LINE_M && passed.dot(along) >= -ON_LINE_M;
    is_near && along.dot(track) >= ON_LINE_COSINE
}

/// Returns a lower bound of the distance to a polygon, from the box around its corners in degrees.
pub(super) fn chart_distance_m(here: Position, corners: &[Position]) -> f64 {
    let mut north = (f64::INFINITY, f64::NEG_INFINITY);
    let mut east = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in corners {
        let north_deg = corner.latitude_deg - here.latitude_deg;
        let east_deg = geodesy::wrap_180(corner.longitude_deg - here.longitude_deg);
        north = (north.0.min(north_deg), north.1.max(north_deg));
        east = (east.0.min(east_deg), east.1.max(east_deg));
    }
    let outside = |(low, high): (f64, f64)| if low > 0.0 { low } else { (-high).max(0.0) };
    let poleward_deg = (here.latitude_deg.abs() + north.0.abs().max(north.1.abs())).min(90.0);
    let narrow = libm::cos(poleward_deg.to_radians());
    libm::hypot(outside(north), outside(east) * narrow) * DEGREE_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::wind::Wind;
    use apex_requirements::Motion;

    const HOME: Position = Position { latitude_deg: 37.4, longitude_deg: -121.0 };
    const RADIUS_M: f64 = 4_000.0;
    const STRAIGHT_M: f64 = 1_500.0;
    const JOIN_M: (f64, f64) = (3_500.0, 2_000.0);

    /// Returns the distances of points of the route from a place, east and north of the vehicle, which flies east and climbs.
    fn distances_m(order: Option<&FlightOrder>, centre: Option<Position>, east_m: f64, north_m: f64) -> Vec<f64> {
        let motion = Motion {
            true_airspeed_mps: 100.0,
            wind: Wind::default(),
            turn_radius_m: 3_000.0,
            climb_mps: 5.0,
            descent_mps: 5.0,
        };
        let plane = Plane::new(HOME);
        let begin = Route::begin(Point::default(), Point { x: 1.0, y: 0.0 }, (500.0, 6_000.0), motion);
        let circling = Circling { centre, radius_m: RADIUS_M, join_m: JOIN_M, straight_m: STRAIGHT_M };
        let route = along(begin, order, &plane, &circling, 300.0);
        let points = (0..route.end_s() as u32).filter_map(|after_s| route.at(f64::from(after_s)));
        points.map(|state| libm::hypot(state.point.x - east_m, state.point.y - north_m)).collect()
    }

    fn most_m(distances_m: &[f64]) -> f64 {
        distances_m.iter().copied().fold(0.0, f64::max)
    }

    #[test]
    fn a_climb_after_take_off_is_a_circle_where_the_vehicle_begins_to_turn() {
        let around_m = distances_m(Some(&FlightOrder::TakeOff(Vec::new())), None, STRAIGHT_M, 0.0);
        assert!((most_m(&around_m) - RADIUS_M).abs() < 1.0, "{}", most_m(&around_m));
        let stated = geodesy::destination(HOME, 90.0, 20_000.0);
        // On the plane of the vehicle, whose scale differs by 0.2 %.
        let there = Plane::new(HOME).project(stated).unwrap_or_default();
        let around_m = distances_m(Some(&FlightOrder::TakeOff(vec![stated])), None, there.x, there.y);
        let last_m = around_m.last().copied().unwrap_or_default();
        assert!((last_m - RADIUS_M).abs() < 1.0, "{last_m}");
    }

    /// The vehicle is on its circle: the prediction stays there, instead of beginning a circle at each reading.
    #[test]
    fn a_circle_that_is_flown_is_predicted_around_its_centre() {
        let centre = geodesy::destination(HOME, 0.0, RADIUS_M);
        let around_m = distances_m(None, Some(centre), 0.0, RADIUS_M);
        assert!((most_m(&around_m) - RADIUS_M).abs() < 20.0, "{}", most_m(&around_m));
    }

    /// The place is reached in 100 s, and the altitude in 1,100 s.
    #[test]
    fn a_climb_at_a_place_is_a_circle_around_it() {
        let place = geodesy::destination(HOME, 90.0, 10_000.0);
        let there = Plane::new(HOME).project(place).unwrap_or_default();
        let around_m = distances_m(Some(&FlightOrder::FlyBy(vec![place])), None, there.x, there.y);
        let last_m = around_m.last().copied().unwrap_or_default();
        assert!((last_m - RADIUS_M).abs() < 1.0, "{last_m}");
    }

    #[test]
    fn a_climb_before_a_line_is_a_circle_next_to_its_beginning() {
        let (from, to) = (geodesy::destination(HOME, 90.0, 10_000.0), geodesy::destination(HOME, 90.0, 30_000.0));
        let begin = Plane::new(HOME).project(from).unwrap_or_default();
        for side in [1.0, -1.0] {
            let (radius_m, lead_m) = JOIN_M;
            let order = FlightOrder::Line(vec![from, to]);
            let around_m = distances_m(Some(&order), None, begin.x - lead_m, begin.y + side * radius_m);
            let near = around_m.iter().filter(|distance_m| (**distance_m - radius_m).abs() < 1.0).count();
            println!("{near} s on the circle at side {side}");
            if near > 200 {
                return;
            }
        }
        panic!("no circle touches the line at its lead-in");
    }
}

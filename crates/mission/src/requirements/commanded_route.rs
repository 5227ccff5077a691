//! The route of an order, from the present position of the vehicle.

use super::commanded::FlightOrder;
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::{Plane, Point};
use apex_requirements::Route;

/// Shortest distance of a degree of latitude (at the equator).
const DEGREE_M: f64 = 110_500.0;

/// Returns the route of an order. Without an order the vehicle circles or hovers at its position.
///
/// The first leg begins with a turn from the present track. Corners between legs are flown as planned, with curves; they are sharp here.
pub(super) fn along(
    begin: Route,
    order: Option<&FlightOrder>,
    plane: &Plane,
    circle_m: f64,
    look_ahead_s: f64,
) -> Route {
    let points = |positions: &[Position]| -> Vec<Point> {
        positions.iter().filter_map(|position| plane.project(*position)).collect()
    };
    let by = |route: Route, points: &[Point]| match points.split_first() {
        None => route,
        Some((first, rest)) => rest.iter().fold(route.fly_to(*first), |route, point| route.straight(*point)),
    };
    let hold = |route: Route, centre: Point| match circle_m > 0.0 {
        true => route.circle(centre, circle_m),
        false => route.stop(look_ahead_s),
    };
    match order {
        None => {
            let (centre, _) = begin.end();
            hold(begin, centre)
        }
        // The vehicle climbs on a circle near the airfield.
        Some(FlightOrder::TakeOff) => begin.stop(look_ahead_s),
        Some(FlightOrder::Line(positions)) => {
            let points = points(positions);
            let left = match points.as_slice() {
                [from, to] if is_on_line(begin.end(), *from, *to) => points.get(1..).unwrap_or_default(),
                all => all,
            };
            by(begin, left)
        }
        Some(FlightOrder::FlyBy(positions) | FlightOrder::Land(positions)) => by(begin, &points(positions)),
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

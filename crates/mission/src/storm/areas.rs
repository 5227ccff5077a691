//! Areas of cells: polygons with their times, as zones of plans and as values for the paths of flight commands.
//!
//! Bound: O(cells x slices).

use super::cell::{AHEAD_S, StormTrack};
use apex_geo::geodesy;
use apex_geo::location::Location;
use apex_geo::plane::{Plane, Point};
use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};
use apex_model::quantity::Dimension;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Distance that plans and paths keep from the edge of a cell: more than the clearance at which `(guard against storms)` acts.
pub(crate) const KEPT_M: f64 = 6_000.0;
/// The area of a cell that moves is stated for spans of this length.
const SLICE_S: f64 = 1_800.0;
/// Corners of the polygon around a circle.
const CORNERS: u32 = 12;
/// A cell is avoided at all altitudes: a radar states no top.
const TOP_M: f64 = 20_000.0;

/// Returns the areas to avoid from `now_s` on. The place of the vehicle, with the distance around it, is left open in the first span.
pub(super) fn zones(cells: &[StormTrack], now_s: f64, here: Option<(Position, f64)>) -> Vec<AirspaceZone> {
    cells.iter().flat_map(|cell| zones_of(cell, now_s, here)).collect()
}

fn zones_of(cell: &StormTrack, now_s: f64, here: Option<(Position, f64)>) -> Vec<AirspaceZone> {
    let slice_s = if cell.stands() { AHEAD_S } else { SLICE_S };
    let count = libm::ceil(AHEAD_S / slice_s) as u32;
    let Position { latitude_deg, longitude_deg } = cell.middle_at(now_s);
    let name = format!("storm at ({latitude_deg:.2} {longitude_deg:.2})");
    let slice = |number: u32| {
        let from_s = now_s + f64::from(number) * slice_s;
        let ends = [cell.middle_at(from_s), cell.middle_at(from_s + slice_s)];
        let wanted_m = cell.radius_m + KEPT_M;
        let free_m = here.filter(|_| number == 0).map_or(f64::INFINITY, |(here, around_m)| {
            ends.iter().map(|end| geodesy::distance_m(*end, here) - around_m).fold(f64::INFINITY, f64::min)
        });
        let radius_m = wanted_m.min(free_m);
        (radius_m > 0.0).then(|| AirspaceZone {
            name: name.clone(),
            kind: ZoneKind::Restricted,
            corners: swept(ends, radius_m),
            altitude_m_min: 0.0,
            altitude_m_max: TOP_M,
            active: TimeWindow { from_s, until_s: from_s + slice_s },
        })
    };
    (0..count).filter_map(slice).collect()
}

/// Returns the convex polygon around a circle that moves from one place to another.
fn swept(ends: [Position; 2], radius_m: f64) -> Vec<Position> {
    let plane = Plane::new(ends[0]);
    let around_m = radius_m / libm::cos(std::f64::consts::PI / f64::from(CORNERS));
    let mut points: Vec<Point> = Vec::new();
    for end in ends {
        let Some(middle) = plane.project(end) else { continue };
        points.extend((0..CORNERS).map(|number| {
            let angle_rad = std::f64::consts::TAU * f64::from(number) / f64::from(CORNERS);
            middle.plus(around_m, Point { x: libm::sin(angle_rad), y: libm::cos(angle_rad) })
        }));
    }
    hull(points).into_iter().map(|point| plane.position(point)).collect()
}

/// Returns the convex hull (Andrew's monotone chain).
fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup_by(|a, b| a.minus(*b).length() < 1.0);
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice()
                && b.minus(*a).cross(point.minus(*b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut chain = half(&mut points.iter().copied());
    chain.extend(half(&mut points.iter().rev().copied()));
    chain
}

/// Returns `(NAME TOP FROM UNTIL CORNER ..)`: the name of an area, its upper face in metres, its time since the start of the mission, and
/// its corners.
pub(super) fn area_value(area: &AirspaceZone) -> Value {
    let rounded = |degrees: f64| Value::Real(libm::round(degrees * 1e5) / 1e5);
    let corner = |at: &Position| Value::list([rounded(at.latitude_deg), rounded(at.longitude_deg)]);
    let time = |at_s: f64| Value::Duration(Duration::from_seconds(libm::round(at_s)));
    let TimeWindow { from_s, until_s } = area.active;
    let head = [Value::text(&area.name), Value::Real(area.altitude_m_max), time(from_s), time(until_s)];
    Value::list(head.into_iter().chain(area.corners.iter().map(corner)))
}

/// Returns the area in a value of [`area_value`].
pub(crate) fn area_of(item: &Value) -> Option<AirspaceZone> {
    let [Value::Text(name), top, from, until, corners @ ..] = item.as_list()? else { return None };
    let time_s = |value: &Value| value.as_number().filter(|(_, unit)| *unit == Dimension::TIME).map(|(at_s, _)| at_s);
    let active = TimeWindow { from_s: time_s(from)?, until_s: time_s(until)? };
    let corners: Vec<Position> = corners.iter().filter_map(|at| Location::of(at).ok()).map(|at| at.position).collect();
    (corners.len() >= 3).then(|| AirspaceZone {
        name: name.to_string(),
        kind: ZoneKind::Restricted,
        corners,
        altitude_m_min: 0.0,
        altitude_m_max: top.as_number().map_or(TOP_M, |(top_m, _)| top_m),
        active,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Position = Position::new(35.0, -118.0);

    fn contains(zone: &AirspaceZone, place: Position) -> bool {
        let plane = Plane::new(place);
        let corners: Vec<Point> = zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
        apex_geo::plane::inside(Point::default(), &corners)
    }

    #[test]
    fn areas_follow_a_cell_and_surround_it() {
        let mut cell = StormTrack::new(0.0, HERE, 20_000.0);
        cell.follow(600.0, geodesy::destination(HERE, 90.0, 6_000.0), 20_000.0);
        let found = zones(&[cell], 600.0, None);
        assert_eq!(found.len(), 4);
        for zone in &found {
            let time = zone.active;
            for at_s in [time.from_s, 0.5 * (time.from_s + time.until_s), time.until_s] {
                let middle = cell.middle_at(at_s);
                let edge = |azimuth_deg: f64| geodesy::destination(middle, azimuth_deg, 25_900.0);
                assert!((0..36).all(|step| contains(zone, edge(10.0 * f64::from(step)))), "{at_s}");
            }
            assert_eq!(
                area_of(&area_value(zone)).map(|read| (read.name, read.corners.len(), read.active.until_s)),
                Some((zone.name.clone(), zone.corners.len(), time.until_s))
            );
        }
    }

    #[test]
    fn the_place_of_the_vehicle_stays_open() {
        let cell = StormTrack::new(0.0, HERE, 20_000.0);
        let here = geodesy::destination(HERE, 0.0, 23_000.0);
        let found = zones(&[cell], 0.0, Some((here, 1_000.0)));
        assert!(found.len() == 1 && !contains(&found[0], here));
        assert!(contains(&found[0], geodesy::destination(HERE, 0.0, 20_500.0)));
        assert!(zones(&[cell], 0.0, Some((HERE, 1_000.0))).is_empty(), "inside");
    }
}

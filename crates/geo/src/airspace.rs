//! Airspace: zones to keep out of and zones to stay in, with altitude bands and windows of time.
//!
//! [`Airspace`] projects all zones once; a query is O(corners). Zones that cannot be projected (farther than 8,000 km from
//! the middle of the problem) or have fewer than three corners are refused when the airspace is made.

use crate::geodesy::{self, Position};
use crate::plane::{self, Plane, Point};
pub use apex_model::problem::{AirspaceZone, ZoneKind};
use std::fmt;

/// A span of altitude and time that a piece of flight takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Lowest altitude above mean sea level.
    pub altitude_m_min: f64,
    /// Highest.
    pub altitude_m_max: f64,
    /// Beginning.
    pub from_s: f64,
    /// End.
    pub until_s: f64,
}

impl Extent {
    /// One altitude at one instant.
    pub fn at(altitude_m: f64, time_s: f64) -> Extent {
        Extent { altitude_m_min: altitude_m, altitude_m_max: altitude_m, from_s: time_s, until_s: time_s }
    }

    /// Is `zone` active anywhere in this extent?
    pub fn meets(&self, zone: &AirspaceZone) -> bool {
        let heights = zone.altitude_m_min <= self.altitude_m_max && self.altitude_m_min < zone.altitude_m_max;
        heights && zone.active.overlaps(self.from_s, self.until_s)
    }

    /// Is `zone` active everywhere in this extent?
    fn is_covered_by(&self, zone: &AirspaceZone) -> bool {
        let heights = zone.altitude_m_min <= self.altitude_m_min && self.altitude_m_max < zone.altitude_m_max;
        heights && zone.active.from_s <= self.from_s && self.until_s < zone.active.until_s
    }
}

/// Why a place or a leg is not allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AirspaceTrouble {
    /// Inside this restricted zone, or closer to it than the margin.
    Inside(String),
    /// The way leads through this restricted zone.
    Crosses(String),
    /// Outside every permitted zone.
    Outside,
    /// Farther away than the projection reaches.
    TooFar,
}

impl fmt::Display for AirspaceTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AirspaceTrouble::Inside(zone) => write!(f, "inside restricted area {zone}"),
            AirspaceTrouble::Crosses(zone) => write!(f, "the way leads through restricted area {zone}"),
            AirspaceTrouble::Outside => f.write_str("outside the permitted area of operation"),
            AirspaceTrouble::TooFar => f.write_str("more than 8,000 km from the middle of the mission"),
        }
    }
}

#[derive(Clone, Debug)]
struct FlatZone {
    zone: AirspaceZone,
    corners: Vec<Point>,
    low: Point,
    high: Point,
}

impl FlatZone {
    /// Is the box around the segment farther than `margin_m` from the box around the zone?
    fn is_far_from(&self, a: Point, b: Point, margin_m: f64) -> bool {
        a.x.max(b.x) + margin_m < self.low.x
            || a.x.min(b.x) - margin_m > self.high.x
            || a.y.max(b.y) + margin_m < self.low.y
            || a.y.min(b.y) - margin_m > self.high.y
    }
}

/// The zones of a problem on one plane.
#[derive(Clone, Debug)]
pub struct Airspace {
    plane: Plane,
    zones: Vec<FlatZone>,
    margin_m: f64,
}

impl Airspace {
    /// Zones on a plane in the middle of `around`. Legs keep `margin_m` from edges.
    ///
    /// # Errors
    /// A sentence that names the zone with fewer than three corners or with a corner that is not on the map.
    pub fn new(zones: &[AirspaceZone], margin_m: f64, around: &[Position]) -> Result<Airspace, String> {
        let plane = Plane::around(around);
        let flat = |zone: &AirspaceZone| {
            if zone.corners.len() < 3 {
                return Err(format!("Zone {} has {} corners; a polygon needs three.", zone.name, zone.corners.len()));
            }
            let corners = zone.corners.iter().map(|corner| {
                plane.project(*corner).ok_or_else(|| {
                    let (latitude, longitude) = (corner.latitude_deg, corner.longitude_deg);
                    format!("Zone {} has a corner at ({latitude} {longitude}), too far from the mission.", zone.name)
                })
            });
            let corners: Vec<Point> = corners.collect::<Result<_, String>>()?;
            let mut low = Point { x: f64::INFINITY, y: f64::INFINITY };
            let mut high = Point { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY };
            for corner in &corners {
                low = Point { x: low.x.min(corner.x), y: low.y.min(corner.y) };
                high = Point { x: high.x.max(corner.x), y: high.y.max(corner.y) };
            }
            Ok(FlatZone { zone: zone.clone(), corners, low, high })
        };
        Ok(Airspace { plane, zones: zones.iter().map(flat).collect::<Result<_, String>>()?, margin_m })
    }

    /// The plane on which the zones lie.
    pub fn plane(&self) -> &Plane {
        &self.plane
    }

    /// The zones in order.
    pub fn zones(&self) -> impl Iterator<Item = &AirspaceZone> {
        self.zones.iter().map(|flat| &flat.zone)
    }

    /// Why it is not allowed to be at `position` in `extent`; none where it is. Margins do not count here.
    pub fn place_trouble(&self, position: Position, extent: Extent) -> Option<AirspaceTrouble> {
        if self.zones.is_empty() {
            return None;
        }
        let Some(point) = self.plane.project(position) else { return Some(AirspaceTrouble::TooFar) };
        let entered = self.restricted(extent).find(|flat| plane::inside(point, &flat.corners));
        if let Some(flat) = entered {
            return Some(AirspaceTrouble::Inside(flat.zone.name.clone()));
        }
        let inside = |flat: &FlatZone| extent.is_covered_by(&flat.zone) && plane::inside(point, &flat.corners);
        (self.has_permitted() && !self.permitted().any(inside)).then_some(AirspaceTrouble::Outside)
    }

    /// Why the straight leg from `from` to `to` is not allowed in `extent`; none where it is. The margin is kept except
    /// where an end of the leg is itself closer to the zone.
    pub fn leg_trouble(&self, from: Position, to: Position, extent: Extent) -> Option<AirspaceTrouble> {
        if self.zones.is_empty() {
            return None;
        }
        let (Some(a), Some(b)) = (self.plane.project(from), self.plane.project(to)) else {
            return Some(AirspaceTrouble::TooFar);
        };
        self.segment_trouble(a, b, extent)
    }

    /// [`Airspace::leg_trouble`] for points of the plane.
    pub fn segment_trouble(&self, a: Point, b: Point, extent: Extent) -> Option<AirspaceTrouble> {
        let margin_m = self.margin_m * self.plane.stretch(a).max(self.plane.stretch(b));
        for flat in self.restricted(extent) {
            if flat.is_far_from(a, b, margin_m) {
                continue;
            }
            if plane::inside(a, &flat.corners) || plane::inside(b, &flat.corners) {
                return Some(AirspaceTrouble::Inside(flat.zone.name.clone()));
            }
            let distance_m = plane::segment_to_edges(a, b, &flat.corners);
            if distance_m == 0.0
                || (distance_m < margin_m && distance_m < margin_between(a, b, &flat.corners, margin_m))
            {
                return Some(AirspaceTrouble::Crosses(flat.zone.name.clone()));
            }
        }
        (self.has_permitted() && !self.stays_permitted(a, b, extent)).then_some(AirspaceTrouble::Outside)
    }

    /// Is every point of the segment inside a permitted zone that is active throughout? Cuts the segment at all edges
    /// and looks at the middle of each piece.
    fn stays_permitted(&self, a: Point, b: Point, extent: Extent) -> bool {
        let usable: Vec<&FlatZone> = self.permitted().filter(|flat| extent.is_covered_by(&flat.zone)).collect();
        let along = b.minus(a);
        let mut cuts = vec![0.0, 1.0];
        for (c, d) in usable.iter().flat_map(|flat| plane::edges(&flat.corners)) {
            let edge = d.minus(c);
            let scale = along.cross(edge);
            let share = c.minus(a).cross(edge) / scale;
            if scale != 0.0 && share > 0.0 && share < 1.0 {
                cuts.push(share);
            }
        }
        cuts.sort_by(f64::total_cmp);
        let holds = |share: f64| usable.iter().any(|flat| plane::inside(a.plus(share, along), &flat.corners));
        let mut pieces = cuts.iter().zip(cuts.iter().skip(1));
        pieces.all(|(from, to)| to - from < 1e-12 || holds(0.5 * (from + to)))
    }

    fn restricted(&self, extent: Extent) -> impl Iterator<Item = &FlatZone> {
        self.zones.iter().filter(move |flat| flat.zone.kind == ZoneKind::Restricted && extent.meets(&flat.zone))
    }

    fn permitted(&self) -> impl Iterator<Item = &FlatZone> {
        self.zones.iter().filter(|flat| flat.zone.kind == ZoneKind::Permitted)
    }

    fn has_permitted(&self) -> bool {
        self.permitted().next().is_some()
    }

    /// Points from which a way around corners can be flown, each with the number of its zone: two per corner that sticks
    /// out into the space to be flown, on the corners of a path that keeps the margin.
    pub fn turning_points(&self) -> Vec<(usize, Point)> {
        let zones = self.zones.iter().enumerate();
        zones.flat_map(|(number, flat)| self.turns_around(flat).into_iter().map(move |point| (number, point))).collect()
    }

    /// Are the turning points of zone `number` of use in `extent`?
    pub fn is_turned_around(&self, number: usize, extent: Extent) -> bool {
        let flat = self.zones.get(number);
        flat.is_some_and(|flat| flat.zone.kind == ZoneKind::Permitted || extent.meets(&flat.zone))
    }

    fn turns_around(&self, flat: &FlatZone) -> Vec<Point> {
        let corners = &flat.corners;
        // Walk with the space to be flown on the right: counter-clockwise around obstacles, clockwise inside corridors.
        let counter_clockwise = plane::doubled_area(corners) > 0.0;
        let walk: Vec<Point> = if counter_clockwise == (flat.zone.kind == ZoneKind::Restricted) {
            corners.clone()
        } else {
            corners.iter().rev().copied().collect()
        };
        let count = walk.len();
        let mut points = Vec::new();
        for (index, corner) in walk.iter().enumerate() {
            let before = walk.get((index + count - 1) % count);
            let after = walk.get((index + 1) % count);
            let into = before.and_then(|before| corner.minus(*before).unit());
            let out = after.and_then(|after| after.minus(*corner).unit());
            let (Some(into), Some(out)) = (into, out) else { continue };
            let turn_rad = libm::atan2(into.cross(out), into.dot(out));
            if turn_rad <= 0.0 {
                continue;
            }
            let clearance_m = (self.margin_m * 1.01 + 5.0) * self.plane.stretch(*corner);
            let reach_m = clearance_m / libm::cos(turn_rad / 4.0);
            let right = Point { x: into.y, y: -into.x };
            points.extend([0.25, 0.75].map(|share| corner.plus(reach_m, rotated(right, share * turn_rad))));
        }
        points
    }
}

/// The margin, no more than the distance of the leg's ends from the zone.
fn margin_between(a: Point, b: Point, corners: &[Point], margin_m: f64) -> f64 {
    let end_m = plane::segment_to_edges(a, a, corners).min(plane::segment_to_edges(b, b, corners));
    margin_m.min(end_m) * (1.0 - 1e-9)
}

fn rotated(vector: Point, angle_rad: f64) -> Point {
    let (sine, cosine) = (libm::sin(angle_rad), libm::cos(angle_rad));
    Point { x: cosine * vector.x - sine * vector.y, y: sine * vector.x + cosine * vector.y }
}

/// Is `position` inside the polygon of `zone`, whatever altitude and time?
pub fn inside(zone: &AirspaceZone, position: Position) -> bool {
    let plane = Plane::around(&zone.corners);
    let corners: Option<Vec<Point>> = zone.corners.iter().map(|corner| plane.project(*corner)).collect();
    match (corners, plane.project(position)) {
        (Some(corners), Some(point)) => plane::inside(point, &corners),
        _ => false,
    }
}

/// Distance along the geodesic that leaves `from` at `track_deg` after which `zone`'s polygon is entered, within
/// `range_m`; 0 where `from` is inside. Whatever altitude and time.
pub fn entry_distance_m(zone: &AirspaceZone, from: Position, track_deg: f64, range_m: f64) -> Option<f64> {
    if inside(zone, from) {
        return Some(0.0);
    }
    let plane = Plane::around(&zone.corners);
    let corners: Vec<Point> = zone.corners.iter().map(|corner| plane.project(*corner)).collect::<Option<_>>()?;
    let (a, b) = (plane.project(from)?, plane.project(geodesy::destination(from, track_deg, range_m))?);
    let along = b.minus(a);
    let shares = plane::edges(&corners).filter_map(|(c, d)| {
        let edge = d.minus(c);
        let scale = along.cross(edge);
        let (share, edge_share) = (c.minus(a).cross(edge) / scale, c.minus(a).cross(along) / scale);
        (scale != 0.0 && (0.0..=1.0).contains(&share) && (0.0..=1.0).contains(&edge_share)).then_some(share)
    });
    let first = shares.min_by(f64::total_cmp)?;
    Some(geodesy::distance_m(from, plane.position(a.plus(first, along))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::TimeWindow;

    fn zone(name: &str, kind: ZoneKind, south: f64, north: f64, west: f64, east: f64) -> AirspaceZone {
        let corners = [(south, west), (south, east), (north, east), (north, west)];
        AirspaceZone {
            name: name.to_string(),
            kind,
            corners: corners.map(|(latitude, longitude)| Position::new(latitude, longitude)).to_vec(),
            altitude_m_min: 0.0,
            altitude_m_max: 10_000.0,
            active: TimeWindow { from_s: 0.0, until_s: 1000.0 },
        }
    }

    fn airspace(zones: &[AirspaceZone]) -> Airspace {
        Airspace::new(zones, 1000.0, &[Position::new(35.0, -121.0), Position::new(41.0, -115.0)]).unwrap()
    }

    #[test]
    fn a_leg_through_a_zone_is_found_and_one_above_or_later_is_not() {
        let space = airspace(&[zone("R-1", ZoneKind::Restricted, 37.0, 38.0, -119.0, -117.0)]);
        let (west, east) = (Position::new(37.5, -121.0), Position::new(37.5, -115.0));
        assert_eq!(
            space.leg_trouble(west, east, Extent::at(5000.0, 10.0)),
            Some(AirspaceTrouble::Crosses("R-1".into()))
        );
        assert_eq!(space.leg_trouble(west, east, Extent::at(10_000.0, 10.0)), None);
        assert_eq!(space.leg_trouble(west, east, Extent::at(5000.0, 1000.0)), None);
        let inside = Position::new(37.5, -118.0);
        assert_eq!(space.place_trouble(inside, Extent::at(0.0, 0.0)), Some(AirspaceTrouble::Inside("R-1".into())));
        assert_eq!(space.place_trouble(west, Extent::at(0.0, 0.0)), None);
    }

    #[test]
    fn the_margin_is_kept_unless_an_end_is_closer() {
        let space = airspace(&[zone("R-1", ZoneKind::Restricted, 37.0, 38.0, -119.0, -117.0)]);
        let near = |latitude: f64| (Position::new(latitude, -121.0), Position::new(latitude, -115.0));
        let (a, b) = near(36.85);
        assert!(space.leg_trouble(a, b, Extent::at(0.0, 0.0)).is_none());
        let touching = Position::new(36.997, -118.0);
        assert!(space.leg_trouble(touching, Position::new(36.0, -118.0), Extent::at(0.0, 0.0)).is_none());
    }

    #[test]
    fn two_corridors_together_permit_what_neither_does_alone() {
        let west = zone("W", ZoneKind::Permitted, 36.0, 39.0, -121.0, -117.9);
        let east = zone("E", ZoneKind::Permitted, 36.0, 39.0, -118.0, -115.0);
        let (from, to) = (Position::new(37.0, -120.0), Position::new(37.0, -116.0));
        let now = Extent::at(5000.0, 5.0);
        assert_eq!(airspace(&[west.clone(), east]).leg_trouble(from, to, now), None);
        assert_eq!(airspace(&[west]).leg_trouble(from, to, now), Some(AirspaceTrouble::Outside));
    }

    #[test]
    fn entry_is_predicted() {
        let zone = zone("R-1", ZoneKind::Restricted, 37.0, 38.0, -119.0, -117.0);
        let from = Position::new(36.0, -118.0);
        let distance = entry_distance_m(&zone, from, 0.0, 500_000.0).unwrap();
        assert!((distance - 111_000.0).abs() < 500.0, "{distance}");
        assert_eq!(entry_distance_m(&zone, from, 180.0, 500_000.0), None);
        assert_eq!(entry_distance_m(&zone, from, 0.0, 50_000.0), None);
    }

    #[test]
    fn a_line_is_no_zone() {
        let mut bad = zone("R-9", ZoneKind::Restricted, 37.0, 38.0, -119.0, -117.0);
        bad.corners.truncate(2);
        let message = Airspace::new(&[bad], 0.0, &[]).unwrap_err();
        assert!(message.contains("R-9") && message.contains("three"), "{message}");
    }
}

//! The geometry of features: points, lines and polygons with checked positions.

use super::{NamedFeature, crossing, permitted};
use crate::error::MissionResult;
use apex_geo::geodesy;
use apex_model::problem::Position;
use geojson::GeometryValue;

impl NamedFeature {
    /// Returns the feature's point, the point halfway along its line, or the mean of the corners of its largest polygon.
    pub(crate) fn position(&self) -> MissionResult<Position> {
        if let Some(polygon) = self.polygons()?.into_iter().next() {
            let count = polygon.len() as f64;
            let latitude_deg = polygon.iter().map(|corner| corner.latitude_deg).sum::<f64>() / count;
            let first_deg = polygon.first().map_or(0.0, |corner| corner.longitude_deg);
            let longitude_deg =
                polygon.iter().map(|corner| beside(first_deg, corner.longitude_deg)).sum::<f64>() / count;
            return Ok(Position::new(latitude_deg, beside(0.0, longitude_deg)));
        }
        match self.geometry() {
            Some(GeometryValue::Point { coordinates }) => self.checked(coordinates.as_slice()),
            Some(GeometryValue::LineString { .. }) => Ok(middle(&self.line()?)),
            Some(other) => Err(self
                .trouble(format!("its geometry is a {}", other.type_name()))
                .help("use a Point, a LineString, a Polygon or a MultiPolygon")),
            None => Err(self.trouble("it has no geometry").help("use a Point, a LineString or a Polygon")),
        }
    }

    /// Returns the positions of a LineString, whose length must not be zero; empty for other geometries.
    pub(crate) fn line(&self) -> MissionResult<Vec<Position>> {
        let Some(GeometryValue::LineString { coordinates }) = self.geometry() else { return Ok(Vec::new()) };
        let places = coordinates.iter().map(|place| self.checked(place.as_slice()));
        let mut places = places.collect::<MissionResult<Vec<_>>>()?;
        places.dedup();
        if length_m(&places) < LINE_M_MIN {
            return Err(self
                .trouble(format!("its line is {:.1} m long", length_m(&places)))
                .because(format!("a line to observe is at least {LINE_M_MIN} m long"))
                .help("give two positions or more that differ, or use a Point"));
        }
        Ok(places)
    }

    fn geometry(&self) -> Option<&GeometryValue> {
        self.feature.geometry.as_ref().map(|geometry| &geometry.value)
    }

    /// Returns the outer rings of the feature's polygons without the closing corner, largest first; empty for a point.
    pub(crate) fn polygons(&self) -> MissionResult<Vec<Vec<Position>>> {
        let rings: Vec<_> = match self.geometry() {
            Some(GeometryValue::Polygon { coordinates }) => coordinates.first().into_iter().collect(),
            Some(GeometryValue::MultiPolygon { coordinates }) => {
                coordinates.iter().filter_map(|polygon| polygon.first()).collect()
            }
            _ => return Ok(Vec::new()),
        };
        let mut polygons = rings.into_iter().map(|ring| self.ring(ring)).collect::<MissionResult<Vec<_>>>()?;
        polygons.sort_by(|a, b| area_m2(b).total_cmp(&area_m2(a)));
        Ok(polygons)
    }

    /// Returns true if one of its polygons has a hole.
    pub(crate) fn has_holes(&self) -> bool {
        match self.geometry() {
            Some(GeometryValue::Polygon { coordinates }) => coordinates.len() > 1,
            Some(GeometryValue::MultiPolygon { coordinates }) => coordinates.iter().any(|polygon| polygon.len() > 1),
            _ => false,
        }
    }

    fn ring(&self, ring: &[geojson::Position]) -> MissionResult<Vec<Position>> {
        let open = match (ring.first(), ring.last()) {
            (Some(first), Some(last)) if first == last && ring.len() > 1 => ring.get(..ring.len() - 1).unwrap_or(ring),
            _ => {
                return Err(self.trouble("a ring is not closed").help("repeat its first position as the last one"));
            }
        };
        let corners = open.iter().map(|corner| self.checked(corner.as_slice())).collect::<MissionResult<Vec<_>>>()?;
        if corners.len() < 3 {
            return Err(self.trouble(format!("a ring has {} corners", corners.len())).help("give three or more"));
        }
        if let Some((first, second)) = crossing::crossing(&corners) {
            return Err(self
                .trouble(format!("a ring crosses itself: the edges after its positions {first} and {second} cross"))
                .help("give the positions in order around the area, or split it into polygons that do not cross"));
        }
        Ok(corners)
    }

    /// Returns the feature's geometry as GeoJSON text, for Sherpa.
    pub(crate) fn geometry_text(&self) -> String {
        self.feature.geometry.as_ref().map(ToString::to_string).unwrap_or_default()
    }

    fn checked(&self, coordinates: &[f64]) -> MissionResult<Position> {
        let [longitude_deg, latitude_deg, ..] = coordinates else {
            return Err(self.trouble("a position has fewer than two coordinates"));
        };
        let (longitude_deg, latitude_deg) = (*longitude_deg, *latitude_deg);
        let position = Position::new(latitude_deg, longitude_deg);
        permitted::latitude(latitude_deg, |what| self.trouble(what))?;
        if latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0 {
            return Ok(Position { longitude_deg: geodesy::wrap_180(position.longitude_deg), ..position });
        }
        let swapped = longitude_deg.abs() <= 90.0 && latitude_deg.abs() <= 180.0;
        let help = if swapped {
            "GeoJSON writes longitude first, then latitude; the two seem to be exchanged"
        } else {
            "latitude is between -90 and 90, longitude between -180 and 180 degrees"
        };
        Err(self
            .trouble(format!("impossible coordinates: latitude {latitude_deg}, longitude {longitude_deg}"))
            .help(help))
    }
}

/// Shortest line to observe.
const LINE_M_MIN: f64 = 1.0;

fn length_m(line: &[Position]) -> f64 {
    line.iter().zip(line.iter().skip(1)).map(|(from, to)| geodesy::distance_m(*from, *to)).sum()
}

/// Returns the point halfway along a line.
fn middle(line: &[Position]) -> Position {
    let mut left_m = 0.5 * length_m(line);
    for (from, to) in line.iter().zip(line.iter().skip(1)) {
        let piece_m = geodesy::distance_m(*from, *to);
        if piece_m >= left_m && piece_m > 0.0 {
            return geodesy::interpolate(*from, *to, left_m / piece_m);
        }
        left_m -= piece_m;
    }
    line.last().copied().unwrap_or_default()
}

/// Returns a longitude within half a turn of another one: beyond 180 degrees where both lie across the 180th meridian.
fn beside(other_deg: f64, longitude_deg: f64) -> f64 {
    let turn_deg = longitude_deg - other_deg;
    if turn_deg.abs() > 180.0 { longitude_deg - 360.0_f64.copysign(turn_deg) } else { longitude_deg }
}

/// Returns the area of a ring by the shoelace rule in a local projection.
pub(crate) fn area_m2(ring: &[Position]) -> f64 {
    let Some(first) = ring.first() else { return 0.0 };
    let metres_per_degree = 111_195.0;
    let shrink = libm::cos(first.latitude_deg.to_radians());
    let flat = |corner: &Position| {
        (
            (beside(first.longitude_deg, corner.longitude_deg) - first.longitude_deg) * metres_per_degree * shrink,
            (corner.latitude_deg - first.latitude_deg) * metres_per_degree,
        )
    };
    let next = ring.iter().skip(1).chain(std::iter::once(first));
    let twice: f64 = ring
        .iter()
        .zip(next)
        .map(|(a, b)| {
            let ((ax, ay), (bx, by)) = (flat(a), flat(b));
            ax * by - bx * ay
        })
        .sum();
    0.5 * twice.abs()
}

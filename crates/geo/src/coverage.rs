//! Lines that sweep the ground of a target. `apex-observation` computes what a sensor sees from them.
//!
//! Bound: a sweep has at most [`SWEEP_LINES_MAX`] lines, each O(corners).

pub use crate::perimeter::perimeter_lines;

use crate::geodesy::{self, EARTH_RADIUS_M_MEAN, Position, RAD_PER_DEG};
use crate::plane::{self, Plane, Point};

/// Maximum number of lines of one sweep: more would take days.
pub const SWEEP_LINES_MAX: usize = 1_000;
/// Corners of the polygon that represents a circle.
const CIRCLE_CORNERS: usize = 32;
const TOO_FEW_CORNERS: &str = "the ground to sweep needs at least three corners on the map";
const STANDARD_GRAVITY_MPS2: f64 = 9.806_65;

/// The ground to be seen.
#[derive(Clone, Debug, PartialEq)]
pub enum CoverageArea {
    /// Everything within `radius_m` of `centre`.
    Circle {
        /// Middle.
        centre: Position,
        /// Radius.
        radius_m: f64,
    },
    /// The area inside these corners, in order, not closed.
    Polygon(Vec<Position>),
}

/// Settings of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepSettings {
    /// Width seen by one line.
    pub swath_m: f64,
    /// Share of the swath that neighbouring lines see twice, 0..0.9.
    pub overlap: f64,
    /// Direction of the lines, clockwise from north; `None` for the direction with the fewest lines.
    pub track_deg: Option<f64>,
    /// Length added at both ends of each line, to roll level.
    pub run_in_m: f64,
}

/// Returns the parallel lines from which all of `ground` is seen, beginning at the corner nearest to `approach`, flown in alternate
/// directions. A row with gaps is flown through.
///
/// # Errors
/// An error message if the ground or a setting is invalid, or the sweep would have too many lines.
pub fn sweep_lines(
    ground: &CoverageArea,
    settings: &SweepSettings,
    approach: Position,
) -> Result<Vec<(Position, Position)>, String> {
    let corners = corners_of(ground)?;
    let plane = Plane::around(&corners);
    let points: Option<Vec<Point>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    let points = points.ok_or("the ground to sweep is larger than half a continent; split it")?;
    let rows = rows_with_run_in(&points, settings)?;
    let lines = rows.into_iter().map(|(from, to)| (plane.position(from), plane.position(to))).collect();
    Ok(from_nearest_corner(lines, |end: Position| geodesy::distance_m(approach, end)))
}

/// Returns the lines of [`sweep_lines`] over a polygon of a plane, as points of that plane.
///
/// # Errors
/// Like [`sweep_lines`].
pub fn sweep_rows(corners: &[Point], settings: &SweepSettings, approach: Point) -> Result<Vec<(Point, Point)>, String> {
    if corners.len() < 3 || !corners.iter().all(|corner| corner.x.is_finite() && corner.y.is_finite()) {
        return Err(TOO_FEW_CORNERS.to_string());
    }
    let rows = rows_with_run_in(corners, settings)?;
    Ok(from_nearest_corner(rows, |end: Point| end.minus(approach).length()))
}

/// Returns the rows from left to right, each longer at both ends by the run-in.
fn rows_with_run_in(points: &[Point], settings: &SweepSettings) -> Result<Vec<(Point, Point)>, String> {
    let spacing_m = settings.swath_m * (1.0 - settings.overlap.clamp(0.0, 0.9));
    if !spacing_m.is_finite() || spacing_m <= 0.0 || !settings.run_in_m.is_finite() {
        return Err(format!("a swath of {} m cannot sweep anything; it must be positive", settings.swath_m));
    }
    let along = settings.track_deg.map(direction).or_else(|| fewest_lines_direction(points));
    let along = along.unwrap_or(Point { x: 0.0, y: 1.0 });
    let mut rows = rows_across(points, along, spacing_m, settings.swath_m)?;
    for (from, to) in &mut rows {
        *from = from.plus(-settings.run_in_m, along);
        *to = to.plus(settings.run_in_m, along);
    }
    Ok(rows)
}

/// Returns the corners of the ground; those of a circle enclose it.
///
/// # Errors
/// An error message if the ground is invalid.
pub(crate) fn corners_of(ground: &CoverageArea) -> Result<Vec<Position>, String> {
    let corners = match ground {
        CoverageArea::Polygon(corners) => corners.clone(),
        CoverageArea::Circle { centre, radius_m } => {
            if !radius_m.is_finite() || *radius_m <= 0.0 || *radius_m > EARTH_RADIUS_M_MEAN {
                return Err(format!("a circle of radius {radius_m} m cannot be swept"));
            }
            // Corners outside the circle, so that their hull contains it.
            let reach_m = radius_m / libm::cos(std::f64::consts::PI / CIRCLE_CORNERS as f64);
            let corner = |index| geodesy::destination(*centre, 360.0 * index as f64 / CIRCLE_CORNERS as f64, reach_m);
            (0..CIRCLE_CORNERS).map(corner).collect()
        }
    };
    let finite = |position: &Position| position.latitude_deg.is_finite() && position.longitude_deg.is_finite();
    if corners.len() < 3 || !corners.iter().all(finite) {
        return Err(TOO_FEW_CORNERS.to_string());
    }
    Ok(corners)
}

fn direction(track_deg: f64) -> Point {
    Point { x: libm::sin(track_deg * RAD_PER_DEG), y: libm::cos(track_deg * RAD_PER_DEG) }
}

/// Returns the direction of the edge across which the polygon is narrowest. A convex polygon is narrowest across one of its edges; for
/// other polygons this is an approximation.
fn fewest_lines_direction(points: &[Point]) -> Option<Point> {
    let width = |along: Point| {
        let across = points.iter().map(|point| along.cross(*point));
        let (low, high) =
            across.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        high - low
    };
    let directions = plane::edges(points).filter_map(|(a, b)| b.minus(a).unit());
    directions.min_by(|a, b| width(*a).total_cmp(&width(*b)))
}

/// Returns rows from left to right of `along`; each extends as far as the polygon does within the row's swath.
fn rows_across(points: &[Point], along: Point, spacing_m: f64, swath_m: f64) -> Result<Vec<(Point, Point)>, String> {
    let offset = |point: Point| along.cross(point);
    let extent = points.iter().map(|point| offset(*point));
    let (low, high) = extent.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let needed = libm::ceil(((high - low - swath_m) / spacing_m).max(0.0)) + 1.0;
    if needed > SWEEP_LINES_MAX as f64 {
        return Err(format!("the sweep would need {needed:.0} lines; fly higher or split the ground"));
    }
    let first = 0.5 * (low + high) - 0.5 * (needed - 1.0) * spacing_m;
    let left = Point { x: -along.y, y: along.x };
    let mut rows = Vec::new();
    for row in 0..needed as usize {
        let middle = first + row as f64 * spacing_m;
        let (bottom, top) = (middle - 0.5 * swath_m, middle + 0.5 * swath_m);
        let mut reach = (f64::INFINITY, f64::NEG_INFINITY);
        let mut see = |point: Point| reach = (reach.0.min(along.dot(point)), reach.1.max(along.dot(point)));
        for (a, b) in plane::edges(points) {
            let (offset_a, offset_b) = (offset(a), offset(b));
            if (bottom..=top).contains(&offset_a) {
                see(a);
            }
            for border in [bottom, top] {
                if (offset_a < border) != (offset_b < border) {
                    see(a.plus((border - offset_a) / (offset_b - offset_a), b.minus(a)));
                }
            }
        }
        if reach.0 <= reach.1 {
            let origin = Point::default().plus(middle, left);
            rows.push((origin.plus(reach.0, along), origin.plus(reach.1, along)));
        }
    }
    Ok(rows)
}

/// Orders rows from the end with the least `distance_m` among those of the first and the last row, and alternates their direction.
fn from_nearest_corner<T: Copy>(mut lines: Vec<(T, T)>, distance_m: impl Fn(T) -> f64) -> Vec<(T, T)> {
    let (Some(first), Some(last)) = (lines.first().copied(), lines.last().copied()) else { return lines };
    let starts = [(first.0, false, false), (first.1, false, true), (last.0, true, false), (last.1, true, true)];
    let nearest = starts.into_iter().min_by(|(a, _, _), (b, _, _)| distance_m(*a).total_cmp(&distance_m(*b)));
    let Some((_, from_last, backwards)) = nearest else { return lines };
    if from_last {
        lines.reverse();
    }
    for (index, line) in lines.iter_mut().enumerate() {
        if (index % 2 == 1) != backwards {
            *line = (line.1, line.0);
        }
    }
    lines
}

/// Returns the radius of a level turn.
pub fn turn_radius_m(true_airspeed_mps: f64, bank_deg: f64) -> f64 {
    true_airspeed_mps * true_airspeed_mps / (STANDARD_GRAVITY_MPS2 * libm::tan(bank_deg * RAD_PER_DEG))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CENTRE: Position = Position::new(40.0, -120.0);

    fn settings(swath_m: f64) -> SweepSettings {
        SweepSettings { swath_m, overlap: 0.1, track_deg: None, run_in_m: 0.0 }
    }

    #[test]
    fn a_wide_box_is_swept_along_its_long_side_from_the_nearest_corner() {
        let corners = [(39.9, -121.0), (39.9, -119.0), (40.1, -119.0), (40.1, -121.0)];
        let ground = CoverageArea::Polygon(corners.map(|(a, b)| Position::new(a, b)).to_vec());
        let approach = Position::new(41.0, -118.0);
        let lines = sweep_lines(&ground, &settings(6_000.0), approach).unwrap();
        assert_eq!(lines.len(), 5);
        let (from, to) = lines[0];
        assert!(from.latitude_deg > 40.0 && from.longitude_deg > -119.1, "{from:?}");
        assert!(to.longitude_deg < -120.9);
        assert!(lines[1].0.longitude_deg < -120.9, "the second line comes back");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_point_of_the_ground_is_seen(
            corners in prop::collection::vec((0.0..360.0f64, 5_000.0..40_000.0f64), 3..8),
            swath_m in 3_000.0..20_000.0f64, probe in (0.0..360.0f64, 0.0..1.0f64),
        ) {
            let mut corners = corners;
            corners.sort_by(|a, b| a.0.total_cmp(&b.0));
            let polygon: Vec<Position> =
                corners.iter().map(|(azimuth, reach)| geodesy::destination(CENTRE, *azimuth, *reach)).collect();
            let plane = Plane::around(&polygon);
            let flat: Vec<Point> = polygon.iter().map(|corner| plane.project(*corner).unwrap()).collect();
            let point = plane.project(geodesy::destination(CENTRE, probe.0, probe.1 * 40_000.0)).unwrap();
            prop_assume!(plane::inside(point, &flat));
            let lines = sweep_lines(&CoverageArea::Polygon(polygon), &settings(swath_m), CENTRE).unwrap();
            let least = lines.iter().map(|(from, to)| {
                plane::point_to_segment(point, plane.project(*from).unwrap(), plane.project(*to).unwrap())
            }).fold(f64::INFINITY, f64::min);
            prop_assert!(least <= 0.5 * swath_m + 1.0, "{least} of {swath_m}");
        }
    }
}

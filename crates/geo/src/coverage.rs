//! Coverage of a target by a line scanner: swath, resolution, sweep lines, and the manoeuvre made of them.
//!
//! Bound: a sweep has at most [`SWEEP_LINES_MAX`] lines, each O(corners).

pub use crate::perimeter::{perimeter_lines, perimeter_manoeuvre};

use crate::geodesy::{self, EARTH_RADIUS_M_MEAN, Position, RAD_PER_DEG};
use crate::plane::{self, Plane, Point};
use crate::wind::{self, WindField};
use apex_model::problem::{Manoeuvre, QualityFactor, QualityFactors};

/// Lines of one sweep: more would take days.
pub const SWEEP_LINES_MAX: usize = 1_000;
/// Lines with ends closer than this touch: the vehicle flies on around a corner.
const TOUCHING_M_MAX: f64 = 1.0;
/// Corners of the polygon that represents a circle.
const CIRCLE_CORNERS: usize = 32;
const STANDARD_GRAVITY_MPS2: f64 = 9.806_65;

/// The ground to be seen.
#[derive(Clone, Debug, PartialEq)]
pub enum Ground {
    /// Everything within `radius_m` of `centre`.
    Circle {
        /// Middle.
        centre: Position,
        /// Radius.
        radius_m: f64,
    },
    /// Everything inside these corners, in order, not closed.
    Polygon(Vec<Position>),
}

/// A sensor that looks down and sweeps across the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineScanner {
    /// Full angle across the track.
    pub field_of_view_deg: f64,
    /// Angle of one pixel.
    pub pixel_mrad: f64,
}

impl LineScanner {
    /// Width on level ground seen from `height_m` above it.
    pub fn swath_m(&self, height_m: f64) -> f64 {
        2.0 * height_m * libm::tan(0.5 * self.field_of_view_deg.clamp(0.0, 178.0) * RAD_PER_DEG)
    }

    /// Metres per pixel below the vehicle.
    pub fn resolution_m(&self, height_m: f64) -> f64 {
        height_m * self.pixel_mrad * 1e-3
    }

    /// Greatest height above ground with pixels of at most `resolution_m`.
    pub fn height_m_max(&self, resolution_m: f64) -> f64 {
        resolution_m / (self.pixel_mrad * 1e-3)
    }
}

/// How to sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepSettings {
    /// Width seen by one line.
    pub swath_m: f64,
    /// Share of the swath seen twice, 0..0.9.
    pub overlap: f64,
    /// Direction of the lines, clockwise from north; none takes the one with the fewest lines.
    pub track_deg: Option<f64>,
    /// Length added at both ends of each line, to roll level.
    pub run_in_m: f64,
}

/// Parallel lines that see all of `ground`, beginning at the nearest of the four corners to `approach`, flown in
/// alternate directions. A row with gaps is flown through.
///
/// # Errors
/// A sentence where the ground or a setting makes no sense, or the sweep would have too many lines.
pub fn sweep_lines(
    ground: &Ground,
    settings: &SweepSettings,
    approach: Position,
) -> Result<Vec<(Position, Position)>, String> {
    let corners = corners_of(ground)?;
    let spacing_m = settings.swath_m * (1.0 - settings.overlap.clamp(0.0, 0.9));
    if !spacing_m.is_finite() || spacing_m <= 0.0 || !settings.run_in_m.is_finite() {
        return Err(format!("A swath of {} m cannot sweep anything; it must be positive.", settings.swath_m));
    }
    let plane = Plane::around(&corners);
    let points: Option<Vec<Point>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    let points = points.ok_or("The ground to sweep is larger than half a continent; split it.")?;
    let along = settings.track_deg.map(direction).or_else(|| fewest_lines_direction(&points));
    let along = along.unwrap_or(Point { x: 0.0, y: 1.0 });
    let mut rows = rows_across(&points, along, spacing_m, settings.swath_m)?;
    for (from, to) in &mut rows {
        *from = from.plus(-settings.run_in_m, along);
        *to = to.plus(settings.run_in_m, along);
    }
    let lines = rows.into_iter().map(|(from, to)| (plane.position(from), plane.position(to))).collect();
    Ok(from_nearest_corner(lines, approach))
}

/// The corners of the ground; those of a circle hold all of it.
///
/// # Errors
/// A sentence where the ground makes no sense.
pub(crate) fn corners_of(ground: &Ground) -> Result<Vec<Position>, String> {
    let corners = match ground {
        Ground::Polygon(corners) => corners.clone(),
        Ground::Circle { centre, radius_m } => {
            if !radius_m.is_finite() || *radius_m <= 0.0 || *radius_m > EARTH_RADIUS_M_MEAN {
                return Err(format!("A circle of radius {radius_m} m cannot be swept."));
            }
            // Corners outside the circle, so that their hull holds all of it.
            let reach_m = radius_m / libm::cos(std::f64::consts::PI / CIRCLE_CORNERS as f64);
            let corner = |index| geodesy::destination(*centre, 360.0 * index as f64 / CIRCLE_CORNERS as f64, reach_m);
            (0..CIRCLE_CORNERS).map(corner).collect()
        }
    };
    let finite = |position: &Position| position.latitude_deg.is_finite() && position.longitude_deg.is_finite();
    if corners.len() < 3 || !corners.iter().all(finite) {
        return Err("The ground to sweep needs at least three corners on the map.".to_string());
    }
    Ok(corners)
}

fn direction(track_deg: f64) -> Point {
    Point { x: libm::sin(track_deg * RAD_PER_DEG), y: libm::cos(track_deg * RAD_PER_DEG) }
}

/// Along the edge across which the polygon is narrowest. The narrowest width of a convex hull lies along a hull edge;
/// edges between all pairs of neighbours are a fair stand-in for it.
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

/// Rows left to right of `along`; each reaches as far as the polygon does within the row's swath.
fn rows_across(points: &[Point], along: Point, spacing_m: f64, swath_m: f64) -> Result<Vec<(Point, Point)>, String> {
    let offset = |point: Point| along.cross(point);
    let extent = points.iter().map(|point| offset(*point));
    let (low, high) = extent.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let needed = libm::ceil(((high - low - swath_m) / spacing_m).max(0.0)) + 1.0;
    if needed > SWEEP_LINES_MAX as f64 {
        return Err(format!("The sweep would need {needed:.0} lines; fly higher or split the ground."));
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

/// Orders rows from the corner nearest to `approach` and alternates their direction.
fn from_nearest_corner(mut lines: Vec<(Position, Position)>, approach: Position) -> Vec<(Position, Position)> {
    let (Some(first), Some(last)) = (lines.first().copied(), lines.last().copied()) else { return lines };
    let starts = [(first.0, false, false), (first.1, false, true), (last.0, true, false), (last.1, true, true)];
    let nearest = starts
        .into_iter()
        .min_by(|(a, _, _), (b, _, _)| geodesy::distance_m(approach, *a).total_cmp(&geodesy::distance_m(approach, *b)));
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

/// Length of the turn from one line into the next, antiparallel one at distance `spacing_m`: half a circle with a
/// straight piece, or a bulb where the lines are closer than two radii.
pub fn turn_length_m(spacing_m: f64, radius_m: f64) -> f64 {
    let pi = std::f64::consts::PI;
    if spacing_m >= 2.0 * radius_m {
        return pi * radius_m + (spacing_m - 2.0 * radius_m);
    }
    radius_m * (3.0 * pi - 4.0 * libm::asin((0.5 + spacing_m / (4.0 * radius_m)).clamp(-1.0, 1.0)))
}

/// Length added by turning `turn_rad` (0..pi) where one line ends and the next begins: past the corner, and back onto
/// the next line. As long as the bulb of [`turn_length_m`] where the next line leads straight back.
pub fn corner_length_m(turn_rad: f64, radius_m: f64) -> f64 {
    let back = 2.0 / 3.0 * std::f64::consts::PI * (1.0 - libm::cos(turn_rad));
    radius_m * (turn_rad - libm::sin(turn_rad) + back)
}

/// Radius of a level turn.
pub fn turn_radius_m(true_airspeed_mps: f64, bank_deg: f64) -> f64 {
    true_airspeed_mps * true_airspeed_mps / (STANDARD_GRAVITY_MPS2 * libm::tan(bank_deg * RAD_PER_DEG))
}

/// How a fixed-wing vehicle flies lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineFlight {
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Speed through the air.
    pub true_airspeed_mps: f64,
    /// Bank in turns between lines.
    pub bank_deg: f64,
    /// When the first line begins.
    pub start_s: f64,
}

/// Time and distance for `lines` in order with the turns between them.
///
/// # Errors
/// A sentence where a line cannot be flown against the wind.
pub fn fly_lines(lines: &[(Position, Position)], flight: &LineFlight, field: &WindField) -> Result<(f64, f64), String> {
    let radius_m = turn_radius_m(flight.true_airspeed_mps, flight.bank_deg);
    let (mut time_s, mut length_m) = (0.0, 0.0);
    let mut before: Option<(Position, Position)> = None;
    for (number, (from, to)) in lines.iter().enumerate() {
        if let Some(before) = before {
            let turn_m = turn_between_m(before, (*from, *to), radius_m);
            length_m += turn_m;
            time_s += turn_m / flight.true_airspeed_mps;
        }
        let now_s = flight.start_s + time_s;
        let leg_s = wind::leg_time_s(*from, *to, flight.altitude_m, flight.true_airspeed_mps, field, now_s);
        time_s += leg_s.ok_or_else(|| {
            format!("Line {} cannot be flown at {:.0} m: the wind is too strong.", number + 1, flight.altitude_m)
        })?;
        length_m += geodesy::distance_m(*from, *to);
        before = Some((*from, *to));
    }
    Ok((time_s, length_m))
}

/// Length of the turn from one line into the next: around a corner where they touch, else back alongside.
fn turn_between_m(line: (Position, Position), next: (Position, Position), radius_m: f64) -> f64 {
    let apart_m = geodesy::distance_m(line.1, next.0);
    if apart_m > TOUCHING_M_MAX {
        return turn_length_m(apart_m, radius_m);
    }
    let heading_deg = geodesy::azimuth_deg(line.1, line.0) + 180.0;
    let turn_deg = geodesy::wrap_180(geodesy::azimuth_deg(next.0, next.1) - heading_deg);
    corner_length_m(turn_deg.abs() * RAD_PER_DEG, radius_m)
}

/// What is wanted of an observation.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationWish {
    /// What to see.
    pub ground: Ground,
    /// Height of the ground above mean sea level.
    pub ground_elevation_m: f64,
    /// Wanted metres per pixel; larger pixels discount the value in proportion.
    pub resolution_m: f64,
}

/// The sweep that sees all of the wished ground from one altitude, with its predicted time and quality.
///
/// # Errors
/// A sentence where the altitude is below ground, the sweep makes no sense, or the wind is too strong.
pub fn sweep_manoeuvre(
    wish: &ObservationWish,
    scanner: &LineScanner,
    flight: &LineFlight,
    field: &WindField,
    approach: Position,
) -> Result<Manoeuvre, String> {
    let lines = |swath_m: f64| {
        let settings = SweepSettings { swath_m, overlap: 0.1, track_deg: None, run_in_m: 0.0 };
        sweep_lines(&wish.ground, &settings, approach)
    };
    observed_manoeuvre(&Observed { name: "sweep", wish, scanner, flight, field }, lines)
}

/// What an observation is made of, but for its lines.
pub(crate) struct Observed<'a> {
    /// First part of the manoeuvre's name.
    pub(crate) name: &'a str,
    pub(crate) wish: &'a ObservationWish,
    pub(crate) scanner: &'a LineScanner,
    pub(crate) flight: &'a LineFlight,
    pub(crate) field: &'a WindField,
}

/// The manoeuvre of the lines for the swath at the flight's altitude, with its predicted time and quality.
///
/// # Errors
/// A sentence where the altitude is below ground, there are no lines, or the wind is too strong.
pub(crate) fn observed_manoeuvre(
    observed: &Observed<'_>,
    lines: impl FnOnce(f64) -> Result<Vec<(Position, Position)>, String>,
) -> Result<Manoeuvre, String> {
    let Observed { name, wish, scanner, flight, field } = observed;
    let height_m = flight.altitude_m - wish.ground_elevation_m;
    if height_m.is_nan() || height_m <= 0.0 {
        return Err(format!(
            "An altitude of {:.0} m is not above the ground at {:.0} m.",
            flight.altitude_m, wish.ground_elevation_m
        ));
    }
    let lines = lines(scanner.swath_m(height_m))?;
    let (duration_s, length_m) = fly_lines(&lines, flight, field)?;
    let obtained_m = scanner.resolution_m(height_m);
    let turbulence = lines.iter().map(|(from, to)| {
        let middle = geodesy::midpoint(*from, *to);
        wind::at(field, middle, flight.altitude_m, flight.start_s + 0.5 * duration_s).turbulence
    });
    let turbulence = turbulence.fold(0.0, f64::max).clamp(0.0, 1.0);
    Ok(Manoeuvre {
        name: format!("{name}-{:.0}m", flight.altitude_m),
        altitude_m: flight.altitude_m,
        lines,
        duration_s,
        length_m,
        quality: QualityFactors {
            coverage: QualityFactor::default(),
            resolution: discounted(wish.resolution_m / obtained_m, || {
                format!(
                    "{obtained_m:.1} m per pixel from {height_m:.0} m above ground, {:.1} m wanted",
                    wish.resolution_m
                )
            }),
            clarity: discounted(1.0 - turbulence, || format!("turbulence {turbulence:.2} forecast")),
        },
    })
}

fn discounted(factor: f64, cause: impl FnOnce() -> String) -> QualityFactor {
    if factor >= 1.0 { QualityFactor::default() } else { QualityFactor { factor: factor.max(0.0), cause: cause() } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CENTRE: Position = Position::new(40.0, -120.0);
    const SCANNER: LineScanner = LineScanner { field_of_view_deg: 86.0, pixel_mrad: 1.25 };

    fn settings(swath_m: f64) -> SweepSettings {
        SweepSettings { swath_m, overlap: 0.1, track_deg: None, run_in_m: 0.0 }
    }

    #[test]
    fn the_fire_scanner_sees_as_far_as_its_field_of_view() {
        assert!((SCANNER.swath_m(6000.0) - 11_190.2).abs() < 0.1);
        assert!((SCANNER.resolution_m(6000.0) - 7.5).abs() < 1e-9);
        assert!((SCANNER.height_m_max(10.0) - 8000.0).abs() < 1e-9);
    }

    #[test]
    fn a_wide_box_is_swept_along_its_long_side_from_the_nearest_corner() {
        let corners = [(39.9, -121.0), (39.9, -119.0), (40.1, -119.0), (40.1, -121.0)];
        let ground = Ground::Polygon(corners.map(|(a, b)| Position::new(a, b)).to_vec());
        let approach = Position::new(41.0, -118.0);
        let lines = sweep_lines(&ground, &settings(6_000.0), approach).unwrap();
        assert_eq!(lines.len(), 5);
        let (from, to) = lines[0];
        assert!(from.latitude_deg > 40.0 && from.longitude_deg > -119.1, "{from:?}");
        assert!(to.longitude_deg < -120.9);
        assert!(lines[1].0.longitude_deg < -120.9, "the second line comes back");
    }

    #[test]
    fn turns_are_continuous_where_the_bulb_becomes_a_half_circle() {
        let (just_below, just_above) = (turn_length_m(1999.999, 1000.0), turn_length_m(2000.001, 1000.0));
        assert!((just_below - just_above).abs() < 3.0);
        assert!((turn_length_m(0.0, 1000.0) - 7.0 / 3.0 * std::f64::consts::PI * 1000.0).abs() < 1e-6);
        assert!((corner_length_m(std::f64::consts::PI, 1000.0) - turn_length_m(0.0, 1000.0)).abs() < 1e-6);
        assert_eq!(corner_length_m(0.0, 1000.0), 0.0);
    }

    #[test]
    fn higher_is_quicker_and_coarser() {
        let wish = ObservationWish {
            ground: Ground::Circle { centre: CENTRE, radius_m: 15_000.0 },
            ground_elevation_m: 1500.0,
            resolution_m: 5.0,
        };
        let at = |altitude_m| {
            let flight = LineFlight { altitude_m, true_airspeed_mps: 95.0, bank_deg: 18.0, start_s: 0.0 };
            sweep_manoeuvre(&wish, &SCANNER, &flight, &WindField::default(), CENTRE)
        };
        let (low, high) = (at(4500.0).unwrap(), at(8500.0).unwrap());
        assert!(low.duration_s > high.duration_s && low.lines.len() > high.lines.len());
        assert_eq!(low.quality.resolution.factor, 1.0);
        assert!((high.quality.resolution.factor - 5.0 / 8.75).abs() < 1e-9);
        assert!(high.quality.resolution.cause.contains("8.8 m per pixel"), "{:?}", high.quality.resolution);
        assert!(at(1000.0).is_err());
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
            let lines = sweep_lines(&Ground::Polygon(polygon), &settings(swath_m), CENTRE).unwrap();
            let least = lines.iter().map(|(from, to)| {
                plane::point_to_segment(point, plane.project(*from).unwrap(), plane.project(*to).unwrap())
            }).fold(f64::INFINITY, f64::min);
            prop_assert!(least <= 0.5 * swath_m + 1.0, "{least} of {swath_m}");
        }
    }
}

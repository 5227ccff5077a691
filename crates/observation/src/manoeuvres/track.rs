//! Tracks: the path of a manoeuvre, before time and attitude are computed.
//!
//! A track is followed over ground: its turns are computed for the wind of the scene, so that following it needs no more bank than
//! planned. Bound: `POINTS_MAX` points.

use super::Craft;
use super::refusal::{Limit, Refusal};
use super::scene::{Scene, along};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::plane::Point;
use apex_geo::travel::{Flyer, Pose};
use std::f64::consts::{FRAC_PI_2, PI};

/// Maximum number of points of one track.
pub(crate) const POINTS_MAX: usize = 20_000;
/// Angle of a chord of a curve.
pub(crate) const CHORD_DEG: f64 = 7.5;
/// Greatest deviation of chords from a turn, as a share of its radius.
const CHORD_SHARE: f64 = 2e-3;

/// A point of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// Metres east and north of the target.
    pub point: Point,
    /// Height above the target.
    pub height_m: f64,
    /// Greatest speed along the path at the point; between two points the greater one applies.
    pub speed_mps_max: f64,
}

/// A part of a track.
#[derive(Clone, Debug, PartialEq)]
pub enum Element {
    /// Points that are followed; the first one is the end of the preceding part.
    Follow {
        /// The points; at least two.
        points: Vec<TrackPoint>,
        /// True if the sensor records.
        is_observed: bool,
    },
    /// Hovering, with the nose in several directions in sequence.
    Hover {
        /// Point of the track.
        at: TrackPoint,
        /// Directions of the nose, clockwise from north; at least one.
        headings_deg: Vec<f64>,
        /// Turn rate from one direction to the next.
        yaw_rate_deg_s: f64,
        /// Time in each direction.
        dwell_s: f64,
    },
}

/// Direction of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// Straight down.
    Down,
    /// At the target.
    Target,
    /// In the direction of the nose, at this tilt below the horizon (negative).
    Nose {
        /// The tilt.
        tilt_deg: f64,
    },
    /// In a fixed direction.
    Direction {
        /// Clockwise from north.
        azimuth_deg: f64,
        /// Tilt below the horizon (negative).
        tilt_deg: f64,
    },
}

/// Track of a manoeuvre with the directions of its sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Its parts in order.
    pub elements: Vec<Element>,
    /// Direction of the sensor.
    pub sight: Sight,
}

impl TrackPoint {
    /// Returns a point without a limit of speed.
    pub fn new(point: Point, height_m: f64) -> TrackPoint {
        TrackPoint { point, height_m, speed_mps_max: f64::INFINITY }
    }
}

impl Track {
    /// Returns all points in the order flown.
    pub fn points(&self) -> impl Iterator<Item = TrackPoint> {
        self.elements.iter().flat_map(|element| match element {
            Element::Follow { points, .. } => points.clone(),
            Element::Hover { at, .. } => vec![*at],
        })
    }

    /// Returns lines that are observed, as pairs of points, in the order flown: the followed parts with two points.
    pub fn observed_lines(&self) -> Vec<(TrackPoint, TrackPoint)> {
        let lines = self.elements.iter().filter_map(|element| match element {
            Element::Follow { points, is_observed: true } => match points.as_slice() {
                [from, to] => Some((*from, *to)),
                _ => None,
            },
            _ => None,
        });
        lines.collect()
    }
}

/// Returns points of an arc around `centre`, from an azimuth (clockwise from north, seen from the centre) through `sweep_deg`
/// (positive clockwise). Bound: one point per [`CHORD_DEG`], finer where the chord is longer than `chord_m_max`.
pub(crate) fn arc_points(centre: Point, radius_m: f64, from_deg: f64, sweep_deg: f64, chord_m_max: f64) -> Vec<Point> {
    let chord_deg = CHORD_DEG.min(chord_m_max / radius_m / RAD_PER_DEG).max(0.1);
    let count = (libm::ceil(sweep_deg.abs() / chord_deg) as usize).clamp(1, POINTS_MAX);
    let at = |index: usize| centre.plus(1.0, along(from_deg + sweep_deg * index as f64 / count as f64, radius_m));
    (0..=count).map(at).collect()
}

/// Returns the longest chord of a curve: a fixed wing flies a chain of chords as a turn if they are short compared with its turn radius.
pub(crate) fn chord_m_max(craft: &Craft) -> f64 {
    if craft.can_hover { f64::INFINITY } else { 0.4 * craft.turn_radius_m(craft.true_airspeed_mps) }
}

/// Returns the lines in order, each with a straight lead-in, and the turns between them. A hovering vehicle needs neither.
///
/// # Errors
/// The wind is too strong for a line.
pub(crate) fn lines_with_turns(
    manoeuvre: &str,
    lines: &[(Point, Point)],
    height_m: f64,
    airspeed_mps: f64,
    craft: &Craft,
    scene: &Scene,
) -> Result<Vec<Element>, Refusal> {
    let mut elements = Vec::new();
    let mut before: Option<(Point, Point)> = None;
    let lead_m = craft.settle_s * airspeed_mps;
    let place = |point: Point| TrackPoint::new(point, height_m);
    for (from, to) in lines.iter().copied() {
        let direction = to.minus(from).unit().unwrap_or(Point { x: 0.0, y: 1.0 });
        let entry = from.plus(-lead_m, direction);
        if let Some((_, exit)) = before {
            let turn = turn_points(manoeuvre, before, (entry, direction), airspeed_mps, craft, scene)?;
            let points = turn.unwrap_or_else(|| vec![exit, entry]).into_iter().map(place).collect();
            elements.push(Element::Follow { points, is_observed: false });
        }
        if lead_m > 0.0 {
            elements.push(Element::Follow { points: vec![place(entry), place(from)], is_observed: false });
        }
        elements.push(Element::Follow { points: vec![place(from), place(to)], is_observed: true });
        before = Some((from, to));
    }
    Ok(elements)
}

/// Returns the fastest turn of a fixed wing from the end of one line to the lead-in of the next; `None` for a vehicle that hovers.
fn turn_points(
    manoeuvre: &str,
    before: Option<(Point, Point)>,
    (entry, direction): (Point, Point),
    airspeed_mps: f64,
    craft: &Craft,
    scene: &Scene,
) -> Result<Option<Vec<Point>>, Refusal> {
    let Some((from, exit)) = before.filter(|_| !craft.can_hover) else { return Ok(None) };
    let out = exit.minus(from);
    let flyer = flyer(airspeed_mps, craft, scene);
    let pose = |point: Point, toward: Point| Pose { point, track_rad: Some(libm::atan2(toward.y, toward.x)) };
    let paths = flyer.paths(pose(exit, out), pose(entry, direction));
    let Some(path) = paths.first() else {
        let limit = Limit { manoeuvre, figure: "a wind", unit: "m/s" };
        let because = "a line cannot be flown against it";
        return Err(limit.refusal(scene.wind_mps(), airspeed_mps, because, "wait for less wind".to_string()));
    };
    // Chords are shorter than half the radius, so that they are flown as a turn.
    Ok(Some(path.points(CHORD_SHARE * flyer.turn_radius_m)))
}

/// Returns the vehicle in the form of the turn planner.
pub(crate) fn flyer(airspeed_mps: f64, craft: &Craft, scene: &Scene) -> Flyer {
    Flyer {
        true_airspeed_mps: airspeed_mps,
        turn_radius_m: craft.turn_radius_m(airspeed_mps),
        wind_mps: Point { x: scene.wind.east_mps, y: scene.wind.north_mps },
    }
}

/// Returns the radius over ground that a fixed wing keeps in any direction of the wind.
pub(crate) fn fillet_m(airspeed_mps: f64, craft: &Craft, scene: &Scene) -> f64 {
    if craft.can_hover { 0.0 } else { craft.circle_radius_m_min(airspeed_mps, scene.wind_mps()) }
}

/// Radius of rounded corners as a multiple of the tightest turn, if the legs are long enough: guidance lags behind a turn that needs the
/// whole bank.
const WIDE: f64 = 1.4;

/// Returns the radius of a rounded corner whose turn begins at most `room_m` before the corner.
pub(crate) fn wide_fillet_m(least_m: f64, turn_deg: f64, room_m: f64) -> f64 {
    let most_m = room_m / libm::tan(0.5 * turn_deg * RAD_PER_DEG);
    (WIDE * least_m).min(most_m).max(least_m)
}

/// Returns a polyline whose corners a fixed wing rounds with `radius_m`; 0 keeps the corners.
pub(crate) fn rounded(corners: &[Point], radius_m: f64, chord_m_max: f64) -> Vec<Point> {
    let mut points: Vec<Point> = corners.first().copied().into_iter().collect();
    for window in corners.windows(3) {
        let [before, corner, after] = window else { continue };
        match fillet((*before, *corner, *after), radius_m, chord_m_max) {
            Some(arc) => points.extend(arc),
            None => points.push(*corner),
        }
    }
    points.extend(corners.last().copied().filter(|_| corners.len() > 1));
    points
}

/// Returns the arc that joins two legs; `None` without a radius or a turn.
fn fillet((before, corner, after): (Point, Point, Point), radius_m: f64, chord_m_max: f64) -> Option<Vec<Point>> {
    let (into, out) = (corner.minus(before).unit()?, after.minus(corner).unit()?);
    // Clockwise is positive, as azimuths are.
    let turn_rad = -libm::atan2(into.cross(out), into.dot(out));
    if radius_m <= 0.0 || turn_rad.abs() < 1e-3 || turn_rad.abs() > PI - 1e-3 {
        return None;
    }
    let begin = corner.plus(-radius_m * libm::tan(0.5 * turn_rad.abs()), into);
    let course_rad = libm::atan2(into.x, into.y);
    let sense = if turn_rad > 0.0 { 1.0 } else { -1.0 };
    let side_deg = (course_rad + sense * FRAC_PI_2) / RAD_PER_DEG;
    let centre = begin.plus(1.0, along(side_deg, radius_m));
    Some(arc_points(centre, radius_m, side_deg + 180.0, turn_rad / RAD_PER_DEG, chord_m_max))
}

/// Returns the distance from a corner at which its rounding begins.
pub(crate) fn tangent_m(turn_deg: f64, radius_m: f64) -> f64 {
    radius_m * libm::tan(0.5 * turn_deg * RAD_PER_DEG)
}

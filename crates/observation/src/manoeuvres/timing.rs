//! Time along a track: speed from the profile, the wind and the accelerations; attitude and energy from the speed.
//!
//! A vehicle that hovers begins and ends at rest and slows at corners; a fixed wing flies on. Bound: O(points).

use super::craft::{Craft, GRAVITY_MPS2};
use super::modes::{AttitudeMode, SpeedProfile, airspeed_of};
use super::refusal::{Limit, Refusal};
use super::scene::{Instrument, Scene};
use super::track::{Element, POINTS_MAX, Track, TrackPoint};
use crate::attitude::Attitude;
use apex_geo::geodesy::{RAD_PER_DEG, wrap_180, wrap_360};
use apex_geo::plane::Point;

/// Least turn between two legs that is a corner for a hovering vehicle, at which it slows.
pub const CORNER_DEG: f64 = 25.0;
/// Time in which the direction of flight changes at a corner.
pub const CORNER_S: f64 = 1.0;
/// Ratio of speeds above which a leg counts as faster than the points at its ends.
const FASTER: f64 = 1.01;
/// Greatest number of pieces of constant speed into which a leg is divided if the speed depends on the distance from the target.
const PIECES_MAX: usize = 20;
/// Length of such a piece as a share of the height: the angle to the target changes little along it.
const PIECE_HEIGHT_SHARE: f64 = 0.3;

/// The vehicle at an instant of a manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPose {
    /// Instant, in the time of the scene.
    pub time_s: f64,
    /// Metres east and north of the target.
    pub point: Point,
    /// Height above the target.
    pub height_m: f64,
    /// Ground speed on the piece that begins here.
    pub ground_speed_mps: f64,
    /// Direction over ground of the piece that begins here, clockwise from north.
    pub track_deg: f64,
    /// Attitude.
    pub attitude: Attitude,
    /// True airspeed.
    pub true_airspeed_mps: f64,
    /// True if the sensor records the piece that begins here.
    pub is_observed: bool,
}

/// A manoeuvre with its times.
#[derive(Clone, Debug, PartialEq)]
pub struct FlownPath {
    /// Poses in the order of time; each holds until the next.
    pub poses: Vec<PathPose>,
    /// Time from the first to the last point.
    pub time_s: f64,
    /// Length over ground.
    pub length_m: f64,
    /// Time in which the sensor records.
    pub observed_s: f64,
    /// Energy used, in the unit of the drain table times seconds: kg or J.
    pub energy: f64,
    /// Greatest bank.
    pub bank_deg_max: f64,
    /// Number of turns of more than 30 degrees.
    pub turns: usize,
}

/// One straight piece with its speeds.
struct Chord {
    from: TrackPoint,
    to: TrackPoint,
    length_m: f64,
    track_deg: f64,
    speed_mps: f64,
    is_observed: bool,
}

/// Flies a track.
///
/// # Errors
/// The profile demands a speed that vehicle or wind do not permit, or the track has too many points.
pub(crate) fn fly(
    manoeuvre: &str,
    track: &Track,
    (attitude, speed): (&AttitudeMode, &SpeedProfile),
    (craft, instrument): (&Craft, &Instrument),
    scene: &Scene,
) -> Result<FlownPath, Refusal> {
    let mut flown = FlownPath {
        poses: Vec::new(),
        time_s: 0.0,
        length_m: 0.0,
        observed_s: 0.0,
        energy: 0.0,
        bank_deg_max: 0.0,
        turns: 0,
    };
    let mut chords: Vec<Chord> = Vec::new();
    for element in &track.elements {
        match element {
            Element::Follow { points, is_observed } => {
                for pair in points.windows(2) {
                    let [from, to] = pair else { continue };
                    chords.extend(chord(manoeuvre, (*from, *to), *is_observed, speed, (craft, instrument), scene)?);
                }
            }
            Element::Hover { at, headings_deg, yaw_rate_deg_s, dwell_s } => {
                follow(&mut flown, &std::mem::take(&mut chords), attitude, craft, scene);
                hover(&mut flown, at, headings_deg, (*yaw_rate_deg_s, *dwell_s), craft, scene);
            }
        }
        if chords.len() + flown.poses.len() > POINTS_MAX {
            let limit = Limit { manoeuvre, figure: "a number of points", unit: "" };
            let nearest = "split it, or space its lines wider".to_string();
            return Err(limit.refusal(
                (chords.len() + flown.poses.len()) as f64,
                POINTS_MAX as f64,
                "it is too long",
                nearest,
            ));
        }
    }
    follow(&mut flown, &chords, attitude, craft, scene);
    flown.time_s = flown.poses.last().map_or(0.0, |last| last.time_s - scene.from_s);
    Ok(flown)
}

/// A point of a path with the speed that guidance keeps there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacedPoint {
    /// Metres east and north of the target.
    pub point: Point,
    /// Height above the target.
    pub height_m: f64,
    /// Greatest speed along the path at the point, before accelerations.
    pub speed_mps: f64,
    /// True airspeed that the speed needs on the legs next to the point.
    pub true_airspeed_mps: f64,
    /// True if the sensor records the leg that begins here.
    pub is_observed: bool,
}

/// Returns the followed points of a track with their speeds; empty for a track that only hovers.
///
/// # Errors
/// Like [`fly`].
pub(crate) fn pace(
    manoeuvre: &str,
    track: &Track,
    speed: &SpeedProfile,
    (craft, instrument): (&Craft, &Instrument),
    scene: &Scene,
) -> Result<Vec<PacedPoint>, Refusal> {
    let mut chords: Vec<Chord> = Vec::new();
    for element in &track.elements {
        let Element::Follow { points, is_observed } = element else { continue };
        for pair in points.windows(2) {
            let [from, to] = pair else { continue };
            chords.extend(chord(manoeuvre, (*from, *to), *is_observed, speed, (craft, instrument), scene)?);
        }
    }
    let airspeed = |chord: &Chord| airspeed_of(chord.track_deg, chord.speed_mps, scene.wind);
    let mut before: Option<&Chord> = None;
    let mut paced: Vec<PacedPoint> = Vec::new();
    for (index, chord) in chords.iter().enumerate() {
        let speed_mps = before.map_or(chord.speed_mps, |before| before.speed_mps.min(chord.speed_mps));
        let begin = PacedPoint {
            point: chord.from.point,
            height_m: chord.from.height_m,
            speed_mps: speed_mps.min(chord.from.speed_mps_max),
            true_airspeed_mps: airspeed(chord).max(before.map_or(0.0, airspeed)),
            is_observed: chord.is_observed,
        };
        paced.push(begin);
        // On a leg the greater speed of its ends applies: one between two slower ones has its speed in the middle.
        let end_mps = chords.get(index + 1).map_or(chord.speed_mps, |after| after.speed_mps.min(chord.speed_mps));
        if chord.speed_mps > FASTER * begin.speed_mps.max(end_mps) {
            paced.push(PacedPoint {
                point: chord.from.point.plus(0.5, chord.to.point.minus(chord.from.point)),
                height_m: 0.5 * (chord.from.height_m + chord.to.height_m),
                speed_mps: chord.speed_mps,
                true_airspeed_mps: airspeed(chord),
                ..begin
            });
        }
        before = Some(chord);
    }
    paced.extend(before.map(|last| PacedPoint {
        point: last.to.point,
        height_m: last.to.height_m,
        speed_mps: last.speed_mps,
        true_airspeed_mps: airspeed(last),
        is_observed: false,
    }));
    Ok(paced)
}

fn chord(
    manoeuvre: &str,
    (from, to): (TrackPoint, TrackPoint),
    is_observed: bool,
    speed: &SpeedProfile,
    (craft, instrument): (&Craft, &Instrument),
    scene: &Scene,
) -> Result<Vec<Chord>, Refusal> {
    let step = to.point.minus(from.point);
    let (level_m, rise_m) = (step.length(), to.height_m - from.height_m);
    let length_m = libm::hypot(level_m, rise_m);
    if length_m < 1e-6 {
        return Ok(Vec::new());
    }
    let track_deg = libm::atan2(step.x, step.y) / RAD_PER_DEG;
    // The speed of some profiles changes along a long line.
    let count = match speed {
        SpeedProfile::SlowAtClosest(_) => pieces(length_m, 0.5 * (from.height_m + to.height_m)),
        _ => 1,
    };
    let mut chords = Vec::new();
    for index in 0..count {
        let at = |index: usize| {
            let share = index as f64 / count as f64;
            TrackPoint {
                point: from.point.plus(share, step),
                height_m: from.height_m + share * rise_m,
                speed_mps_max: to.speed_mps_max,
            }
        };
        let (begin, end) = (at(index), at(index + 1));
        let middle = begin.point.plus(0.5, end.point.minus(begin.point));
        let height_m = 0.5 * (begin.height_m + end.height_m);
        let level_mps = speed.ground_speed_mps(
            (manoeuvre, track_deg),
            (height_m, middle.length()),
            craft,
            instrument,
            scene.wind,
        )?;
        let climb_mps = if rise_m > 0.0 { craft.climb_mps_max } else { craft.descent_mps_max };
        let steep_mps = if rise_m.abs() < 1e-9 { f64::INFINITY } else { climb_mps * length_m / rise_m.abs() };
        let speed_mps = level_mps.min(from.speed_mps_max.max(to.speed_mps_max)).min(steep_mps);
        chords.push(Chord {
            from: begin,
            to: end,
            length_m: length_m / count as f64,
            track_deg,
            speed_mps,
            is_observed,
        });
    }
    Ok(chords)
}

/// Returns the number of pieces of a leg whose speed depends on the distance from the target. The chords of a curve stay whole: the turn
/// between two of them would be that of a short piece, with a bank that is not flown.
fn pieces(length_m: f64, height_m: f64) -> usize {
    let wanted = libm::ceil(length_m / (PIECE_HEIGHT_SHARE * height_m).max(1.0));
    (wanted as usize).clamp(1, PIECES_MAX)
}

/// Returns the ground speeds at the ends of the chords. A pass backwards applies the limit of braking, a pass forwards that of
/// acceleration.
fn node_speeds(chords: &[Chord], craft: &Craft) -> Vec<f64> {
    let mut nodes: Vec<f64> = Vec::with_capacity(chords.len() + 1);
    nodes.push(0.0);
    for pair in chords.windows(2) {
        let [into, out] = pair else { continue };
        let turn_deg = wrap_180(out.track_deg - into.track_deg).abs();
        let both = into.speed_mps.min(out.speed_mps).min(into.to.speed_mps_max);
        let is_corner = turn_deg > CORNER_DEG;
        let corner = corner_speed_mps(turn_deg, craft.acceleration_mps2);
        nodes.push(if is_corner { both.min(corner) } else { both });
    }
    nodes.push(0.0);
    let reach = |speed: f64, length_m: f64, rate: f64| libm::sqrt(speed * speed + 2.0 * rate * length_m);
    for index in (0..chords.len()).rev() {
        if let (Some(chord), Some(after)) = (chords.get(index), nodes.get(index + 1).copied()) {
            let most = reach(after, chord.length_m, craft.braking_mps2);
            if let Some(node) = nodes.get_mut(index) {
                *node = node.min(most);
            }
        }
    }
    for index in 0..chords.len() {
        if let (Some(chord), Some(before)) = (chords.get(index), nodes.get(index).copied()) {
            let most = reach(before, chord.length_m, craft.acceleration_mps2);
            if let Some(node) = nodes.get_mut(index + 1) {
                *node = node.min(most);
            }
        }
    }
    nodes
}

/// Returns the speed at a corner, so that the direction of flight changes in [`CORNER_S`].
pub fn corner_speed_mps(turn_deg: f64, acceleration_mps2: f64) -> f64 {
    acceleration_mps2 * CORNER_S / (2.0 * libm::sin(0.5 * turn_deg * RAD_PER_DEG)).max(1e-6)
}

/// Returns the time over a chord from one speed to another, with a greatest speed in between.
fn chord_s(chord: &Chord, (from, to): (f64, f64), craft: &Craft) -> f64 {
    let (a, b, length) = (craft.acceleration_mps2, craft.braking_mps2, chord.length_m);
    let peak = libm::sqrt(((2.0 * a * b * length + b * from * from + a * to * to) / (a + b)).max(0.0));
    let peak = peak.min(chord.speed_mps).max(from.max(to)).max(1e-3);
    let changes_m = (peak * peak - from * from) / (2.0 * a) + (peak * peak - to * to) / (2.0 * b);
    (peak - from) / a + (peak - to) / b + (length - changes_m).max(0.0) / peak
}

fn follow(flown: &mut FlownPath, chords: &[Chord], attitude: &AttitudeMode, craft: &Craft, scene: &Scene) {
    let Some(last) = chords.last() else { return };
    let nodes = if craft.can_hover { node_speeds(chords, craft) } else { Vec::new() };
    let mut time_s = flown.poses.last().map_or(scene.from_s, |pose| pose.time_s);
    let mut turned = 0.0_f64;
    for (index, chord) in chords.iter().enumerate() {
        let ends = (nodes.get(index).copied(), nodes.get(index + 1).copied());
        let lasts_s = match ends {
            (Some(from), Some(to)) => chord_s(chord, (from, to), craft),
            _ => chord.length_m / chord.speed_mps,
        };
        let level_m = chord.to.point.minus(chord.from.point).length();
        let ground_speed_mps = level_m / lasts_s;
        let after = chords.get(index + 1).unwrap_or(chord);
        let turn_deg = wrap_180(after.track_deg - chord.track_deg);
        let turn_rate = turn_deg * RAD_PER_DEG / (0.5 * (lasts_s + after.length_m / after.speed_mps));
        let airspeed = airspeed_of(chord.track_deg, ground_speed_mps, scene.wind);
        let cos_crab = cos_crab(chord.track_deg, ground_speed_mps, scene);
        let bank_deg = libm::atan(ground_speed_mps * turn_rate / (GRAVITY_MPS2 * cos_crab)) / RAD_PER_DEG;
        let bank_deg = if craft.can_hover { bank_deg.clamp(-craft.bank_deg, craft.bank_deg) } else { bank_deg };
        let heading_deg = attitude.heading_deg(chord.from.point, (chord.track_deg, ground_speed_mps), scene);
        flown.poses.push(PathPose {
            time_s,
            point: chord.from.point,
            height_m: chord.from.height_m,
            ground_speed_mps,
            track_deg: wrap_360(chord.track_deg),
            attitude: Attitude {
                heading_deg: wrap_360(heading_deg),
                pitch_deg: craft.level_pitch_deg,
                roll_deg: bank_deg,
            },
            true_airspeed_mps: airspeed,
            is_observed: chord.is_observed,
        });
        turned = if turn_deg.abs() < 0.1 || turned * turn_deg < 0.0 { turn_deg } else { turned + turn_deg };
        if turned.abs() > 30.0 && (turned - turn_deg).abs() <= 30.0 {
            flown.turns += 1;
        }
        time_s += lasts_s;
        flown.length_m += level_m;
        flown.energy += craft.drain.per_s(airspeed) * lasts_s;
        flown.observed_s += if chord.is_observed { lasts_s } else { 0.0 };
        flown.bank_deg_max = flown.bank_deg_max.max(bank_deg.abs());
    }
    let before = flown.poses.last().copied();
    flown.poses.extend(before.map(|before| PathPose {
        time_s,
        point: last.to.point,
        height_m: last.to.height_m,
        is_observed: false,
        ..before
    }));
}

/// Returns the cosine of the angle between nose and track of a coordinated flight.
fn cos_crab(track_deg: f64, ground_speed_mps: f64, scene: &Scene) -> f64 {
    let track_rad = track_deg * RAD_PER_DEG;
    let tail = scene.wind.east_mps * libm::sin(track_rad) + scene.wind.north_mps * libm::cos(track_rad);
    let airspeed = airspeed_of(track_deg, ground_speed_mps, scene.wind);
    if airspeed < 0.5 { 1.0 } else { ((ground_speed_mps - tail) / airspeed).clamp(0.1, 1.0) }
}

fn hover(
    flown: &mut FlownPath,
    at: &TrackPoint,
    headings_deg: &[f64],
    (yaw_rate_deg_s, dwell_s): (f64, f64),
    craft: &Craft,
    scene: &Scene,
) {
    let mut time_s = flown.poses.last().map_or(scene.from_s, |pose| pose.time_s);
    let began_s = time_s;
    let mut nose: Option<f64> = None;
    let pose = |time_s: f64, heading_deg: f64, is_observed: bool| PathPose {
        time_s,
        point: at.point,
        height_m: at.height_m,
        ground_speed_mps: 0.0,
        track_deg: wrap_360(heading_deg),
        attitude: Attitude { heading_deg: wrap_360(heading_deg), pitch_deg: 0.0, roll_deg: 0.0 },
        true_airspeed_mps: scene.wind_mps(),
        is_observed,
    };
    for heading_deg in headings_deg {
        if let Some(from_deg) = nose {
            time_s += wrap_180(heading_deg - from_deg).abs() / yaw_rate_deg_s;
        }
        nose = Some(*heading_deg);
        flown.poses.push(pose(time_s, *heading_deg, true));
        time_s += dwell_s;
        // Nothing is recorded during the turn.
        flown.poses.push(pose(time_s, *heading_deg, false));
        flown.observed_s += dwell_s;
    }
    let lasts_s = time_s - began_s;
    flown.energy += craft.drain.per_s(scene.wind_mps()) * lasts_s;
}

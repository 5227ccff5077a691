//! Prediction of the looks and the cost of a manoeuvre: its poses become planned lines or pictures, which are accumulated and
//! assessed as recorded ones are.

use super::craft::Craft;
use super::manoeuvre::{Manoeuvre, TimedTrack};
use super::modes::{AttitudeMode, PayloadUse, VIDEO_S};
use super::refusal::Refusal;
use super::scene::{Instrument, Scene};
use super::timing::{FlownPath, PathPose};
use super::track::Sight;
use crate::attitude::{Attitude, Vector};
use crate::grid::TargetGrid;
use crate::pictures::{PictureView, PlannedPicture, predict_pictures};
use crate::predict::{PlannedLine, PredictionContext, predict};
use crate::result::{Factors, LookResult, TargetResult};
use crate::sensor::gimbal::line_of;
use crate::sensor::{CameraSetting, ExposureMotion, GimbalAngles};
use crate::target::ObservedTarget;
use apex_geo::geodesy::{Position, RAD_PER_DEG, wrap_180};
use apex_geo::plane::Point;

/// Maximum number of pictures of one forecast.
const PICTURES_MAX: usize = 5_000;
/// Greatest difference of direction, in degrees, between chords that form one line of a scanner.
const STRAIGHT_DEG: f64 = 0.05;

/// Input of a forecast in addition to manoeuvre, vehicle, sensor and scene.
#[derive(Clone, Copy)]
pub struct ForecastContext<'a> {
    /// The target with its wanted look.
    pub target: &'a ObservedTarget,
    /// Its ground.
    pub grid: &'a TargetGrid,
    /// The air, earlier observations, and the other conditions.
    pub prediction: PredictionContext<'a>,
}

/// Predicted yield and cost of a manoeuvre.
#[derive(Clone, Debug, PartialEq)]
pub struct Forecast {
    /// Coverage, clarity, resolution, timing of the first wanted look.
    pub factors: Factors,
    /// Points of all wanted looks.
    pub points: f64,
    /// Time from first to last point.
    pub time_s: f64,
    /// Length over ground.
    pub length_m: f64,
    /// Energy, kg or J.
    pub energy: f64,
    /// Number of turns: fewer are better at equal value.
    pub turns: usize,
    /// Number of pictures; 0 for a scanner.
    pub pictures: usize,
    /// Share of the pictures with the middle of the target in view.
    pub tracked_share: f64,
    /// Instant at which all data are on the ground; `None`: after landing.
    pub on_ground_s: Option<f64>,
    /// The poses.
    pub flown: FlownPath,
    /// The result of the first wanted look; `None` for a target without wanted looks.
    pub look: Option<LookResult>,
}

impl Manoeuvre {
    /// Predicts the looks that a target receives, and the cost.
    ///
    /// # Errors
    /// Like [`Manoeuvre::fly`].
    pub fn forecast(
        &self,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
        context: &ForecastContext<'_>,
    ) -> Result<Forecast, Refusal> {
        let timed = self.timed(craft, instrument, scene)?;
        Ok(self.observe(timed, (craft, instrument), scene, context))
    }

    /// Predicts the looks from the poses of [`Manoeuvre::timed`].
    pub fn observe(
        &self,
        TimedTrack { sight, flown }: TimedTrack,
        (craft, instrument): (&Craft, &Instrument),
        scene: &Scene,
        context: &ForecastContext<'_>,
    ) -> Forecast {
        let (on_ground_s, result, pictures, tracked_share) = match instrument {
            Instrument::Scanner(scanner) => {
                let mut lines = planned_lines(&flown, scene);
                let arrivals_s = self.data.arrivals_s(lines.iter().map(PlannedLine::until_s)).unwrap_or_default();
                lines.iter_mut().zip(&arrivals_s).for_each(|(line, at_s)| line.on_ground_s = Some(*at_s));
                (
                    arrivals_s.last().copied(),
                    predict(context.target, context.grid, &lines, scanner, &context.prediction),
                    0,
                    1.0,
                )
            }
            Instrument::Camera(camera) => {
                let (pictures, tracked) = planned_pictures(&flown, (self, sight), camera, craft, (scene, context));
                let share = tracked as f64 / pictures.len().max(1) as f64;
                let count = pictures.len();
                let taken_s = pictures.iter().map(|picture| picture.view.time_s);
                let on_ground_s = self.data.arrivals_s(taken_s).and_then(|arrivals_s| arrivals_s.last().copied());
                (
                    on_ground_s,
                    predict_pictures(context.target, context.grid, &[pictures], &context.prediction),
                    count,
                    share,
                )
            }
        };
        let factors = factors_of(&result);
        let FlownPath { time_s, length_m, energy, turns, .. } = flown;
        let points = result.points();
        let look = result.looks.into_iter().next();
        Forecast { factors, points, time_s, length_m, energy, turns, pictures, tracked_share, on_ground_s, flown, look }
    }
}

fn factors_of(result: &TargetResult) -> Factors {
    let none = Factors { coverage: 0.0, clarity: 0.0, resolution: 0.0, timing: 0.0 };
    result.looks.first().map_or(none, |look| look.factors)
}

/// Returns the lines of a scanner: consecutive observed chords of one direction form one line.
fn planned_lines(flown: &FlownPath, scene: &Scene) -> Vec<PlannedLine> {
    let mut lines: Vec<PlannedLine> = Vec::new();
    let mut track_deg = f64::NAN;
    for pair in flown.poses.windows(2) {
        let [pose, after] = pair else { continue };
        if !pose.is_observed || pose.ground_speed_mps <= 0.0 {
            track_deg = f64::NAN;
            continue;
        }
        let to = scene.position(after.point);
        // The first track is not a number, with which every comparison is false: a new line begins.
        let goes_on = wrap_180(pose.track_deg - track_deg).abs() < STRAIGHT_DEG;
        match lines.last_mut().filter(|_| goes_on) {
            Some(line) => line.to = to,
            None => lines.push(PlannedLine {
                from: scene.position(pose.point),
                to,
                altitude_m: scene.elevation_m + pose.height_m,
                from_s: pose.time_s,
                ground_speed_mps: pose.ground_speed_mps,
                crab_deg: wrap_180(pose.attitude.heading_deg - pose.track_deg),
                pitch_deg: pose.attitude.pitch_deg,
                on_ground_s: None,
            }),
        }
        track_deg = pose.track_deg;
    }
    lines
}

/// Returns the pictures, and the number of them with the middle of the target in view.
fn planned_pictures(
    flown: &FlownPath,
    (manoeuvre, sight): (&Manoeuvre, Sight),
    camera: &CameraSetting,
    craft: &Craft,
    (scene, context): (&Scene, &ForecastContext<'_>),
) -> (Vec<PlannedPicture>, usize) {
    let (mut pictures, mut tracked) = (Vec::new(), 0);
    let mut angles = CameraSetting::straight_down();
    // Distance and time since the last picture; the first is taken at once.
    let (mut flown_m, mut waited_s) = (f64::INFINITY, f64::INFINITY);
    for pair in flown.poses.windows(2) {
        let [pose, after] = pair else { continue };
        let lasts_s = after.time_s - pose.time_s;
        if !pose.is_observed {
            (flown_m, waited_s) = (f64::INFINITY, f64::INFINITY);
            continue;
        }
        let is_still = pose.ground_speed_mps < 0.05;
        let interval_s = match &manoeuvre.payload {
            PayloadUse::StillsEvery(every_m) if !is_still => {
                (every_m / pose.ground_speed_mps).max(camera.interval_s_min)
            }
            PayloadUse::StillsInterval(interval_s) => interval_s.max(camera.interval_s_min),
            // One picture in each direction of a hovering vehicle.
            PayloadUse::StillsEvery(_) => f64::INFINITY,
            PayloadUse::Video | PayloadUse::LineScan => VIDEO_S,
        };
        let by_distance = matches!(manoeuvre.payload, PayloadUse::StillsEvery(_)) && !is_still;
        let carried_s = if by_distance { flown_m / pose.ground_speed_mps } else { waited_s };
        let mut next_s = if is_still { 0.0 } else { (interval_s - carried_s).max(0.0) };
        let mut last_s = None;
        while next_s < lasts_s - 1e-6 && pictures.len() < PICTURES_MAX {
            let here = facing(between(pose, after, next_s / lasts_s), &manoeuvre.attitude, scene);
            let view;
            (view, angles) = view_of(&here, sight, camera, scene, angles);
            tracked += usize::from(sees(&view, here.point, scene));
            let weights = weights_of((&here, view.position), camera, craft, (scene, context));
            pictures.push(PlannedPicture { view, weights });
            last_s = Some(next_s);
            next_s += interval_s;
        }
        let left_s = lasts_s - last_s.unwrap_or(0.0);
        (flown_m, waited_s) = match last_s {
            Some(_) => (left_s * pose.ground_speed_mps, left_s),
            None => (flown_m + left_s * pose.ground_speed_mps, waited_s + left_s),
        };
    }
    (pictures, tracked)
}

/// Returns the pose at a fraction of the way to the next one.
fn between(from: &PathPose, to: &PathPose, share: f64) -> PathPose {
    PathPose {
        time_s: from.time_s + share * (to.time_s - from.time_s),
        point: from.point.plus(share, to.point.minus(from.point)),
        height_m: from.height_m + share * (to.height_m - from.height_m),
        ..*from
    }
}

/// Returns a pose with the nose towards the target, for a vehicle that moves and points it there; other poses unchanged.
fn facing(pose: PathPose, attitude: &AttitudeMode, scene: &Scene) -> PathPose {
    if !matches!(attitude, AttitudeMode::Pointing) || pose.ground_speed_mps < 0.05 {
        return pose;
    }
    let heading_deg = attitude.heading_deg(pose.point, (pose.track_deg, pose.ground_speed_mps), scene);
    PathPose { attitude: Attitude { heading_deg, ..pose.attitude }, ..pose }
}

/// Returns the view of a camera at a pose, with the angles that its mount reaches from the present ones.
fn view_of(
    pose: &PathPose,
    sight: Sight,
    camera: &CameraSetting,
    scene: &Scene,
    present: GimbalAngles,
) -> (PictureView, GimbalAngles) {
    let level = |azimuth_deg: f64, tilt_deg: f64| line_of(GimbalAngles { pan_deg: azimuth_deg, tilt_deg });
    let line = match sight {
        Sight::Down => Vector::new(0.0, 0.0, 1.0),
        Sight::Target => Vector::new(-pose.point.y, -pose.point.x, pose.height_m),
        Sight::Nose { tilt_deg } => level(pose.attitude.heading_deg, tilt_deg),
        Sight::Direction { azimuth_deg, tilt_deg } => level(azimuth_deg, tilt_deg),
    };
    let body = match camera.is_stabilised {
        true => Attitude { heading_deg: pose.attitude.heading_deg, pitch_deg: 0.0, roll_deg: 0.0 },
        false => pose.attitude,
    };
    let cone_deg = camera.mount.nadir_cone_deg(0.0);
    let angles = camera.mount.point(body.rotation().to_body(line), present, cone_deg).angles;
    let view = PictureView {
        time_s: pose.time_s,
        position: scene.position(pose.point),
        altitude_m: scene.elevation_m + pose.height_m,
        attitude: pose.attitude,
        angles,
        is_stabilised: camera.is_stabilised,
        wide_deg: camera.wide_deg,
        high_deg: camera.high_deg,
        pixel_mrad: camera.pixel_mrad,
    };
    (view, angles)
}

fn weights_of(
    (pose, position): (&PathPose, Position),
    camera: &CameraSetting,
    craft: &Craft,
    (scene, context): (&Scene, &ForecastContext<'_>),
) -> crate::clarity::ClarityWeights {
    let air = context.prediction.conditions.at(position, scene.elevation_m + pose.height_m, pose.time_s);
    let motion = ExposureMotion {
        ground_speed_mps: pose.ground_speed_mps,
        slant_m: libm::hypot(pose.height_m, pose.point.length()),
        ..ExposureMotion::default()
    };
    let mut weights = camera.planned_weights(&motion, &craft.hold, air.edr);
    // A bank that the mount does not compensate counts as roll.
    if !camera.is_stabilised {
        weights.roll *= camera.roll.weight(pose.attitude.roll_deg);
    }
    weights
}

/// Returns true if the middle of the target is inside a view from `here`.
fn sees(view: &PictureView, here: Point, scene: &Scene) -> bool {
    let sight = crate::sensor::camera::sight_of(&view.attitude, view.angles, view.is_stabilised);
    let axis = sight(Vector::new(1.0, 0.0, 0.0));
    let line = Vector::new(-here.y, -here.x, view.altitude_m - scene.elevation_m);
    axis.angle_rad(line) <= 0.5 * view.high_deg.min(view.wide_deg) * RAD_PER_DEG
}

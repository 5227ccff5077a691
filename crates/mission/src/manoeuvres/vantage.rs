//! Pictures of a point: a rotorcraft hovers over it or to its side; a fixed wing flies across it.

use super::altitudes::closed_by;
use super::drafts::{Draft, predicted};
use super::flying::arrival_s;
use super::wish::Wish;
use super::{picture_heights as heights, picture_runs as runs};
use crate::observing::{ForecastAir, hold_of};
use crate::requirements::sun_margin_deg;
use crate::vehicle::Airframe;
use apex_geo::geodesy::{self, RAD_PER_DEG};
use apex_model::problem::{Manoeuvre, PictureWork, Position};
use apex_observation::attitude::Attitude;
use apex_observation::clarity::ClarityWeights;
use apex_observation::pictures::{PictureView, PlannedPicture};
use apex_observation::predict::Conditions;
use apex_observation::sensor::{CameraSetting, ExposureMotion, GimbalAngles};
use apex_observation::target::LookAngles;
use apex_requirements::margin::sensor::ViewDirection;

/// Candidate look angles if overflight is closed or not wanted, degrees off the vertical.
const ASIDE_DEG: [f64; 4] = [20.0, 35.0, 50.0, 65.0];
/// Number of candidate directions for a hover to the side of the point, beginning with the direction of arrival.
const AZIMUTHS: u32 = 8;
/// Distance kept from zones as a multiple of the required one, because corners of zones are nearer than their edges.
const ZONE_MARGIN: f64 = 1.1;
/// Margin of planned look angles inside the wanted range, degrees.
const INSIDE_DEG: f64 = 2.0;
/// Required probability that at least one picture is valid, which determines their number; and the greatest number of pictures.
const VALID_CHANCE: f64 = 0.98;
const PICTURES_MAX: u32 = 10;
/// The mount slews this far on average, degrees.
const SLEW_DEG: f64 = 90.0;
/// Greatest turn of the nose for a mount that only tilts, degrees.
const NOSE_DEG: f64 = 150.0;
/// Time from one command to the next, including acknowledgements and the steps of the procedure, s.
const STEPS_S: f64 = 0.4;

/// Returns the ways to take pictures of the point.
///
/// # Errors
/// If there is none: the reason, with the nearest possibility.
pub(super) fn ways(wish: &Wish<'_>, camera: &CameraSetting, place: Position) -> Result<Vec<Manoeuvre>, String> {
    if wish.mission.model.airframe == Airframe::FixedWing {
        return runs::passes(wish, camera, place);
    }
    let angles_deg = look_angles_deg(wish, camera)?;
    let mut made: Vec<Manoeuvre> = Vec::new();
    let mut trouble = None;
    for angle_deg in angles_deg {
        let altitudes_m = match heights::of(wish, camera, angle_deg) {
            Ok(altitudes_m) => altitudes_m,
            Err(why) => {
                trouble.get_or_insert(why);
                continue;
            }
        };
        for altitude_m in altitudes_m {
            match vantage_point(wish, camera, place, (altitude_m, angle_deg)) {
                Ok(from) => made.extend(predicted(wish, draft(wish, camera, place, (from, altitude_m, angle_deg)))),
                Err(why) => {
                    trouble.get_or_insert(why);
                }
            }
        }
    }
    match (made.is_empty(), trouble) {
        (true, Some(why)) => Err(why),
        _ => Ok(made),
    }
}

/// Returns the look angles to try, steepest first: those that the target requires and the mount can reach.
fn look_angles_deg(wish: &Wish<'_>, camera: &CameraSetting) -> Result<Vec<f64>, String> {
    let (low_deg, high_deg) = camera.mount.tilt_deg;
    let (least_deg, most_deg) = (90.0 + low_deg, 90.0 + high_deg);
    let wanted = wish.look.look_angles.unwrap_or(LookAngles { min_deg: 0.0, max_deg: 89.0, ramp_deg: 0.0 });
    let (from_deg, to_deg) = (wanted.min_deg.max(least_deg), wanted.max_deg.min(most_deg));
    if from_deg > to_deg {
        return Err(format!(
            "`{}` tilts from {low_deg:.0} to {high_deg:.0} degrees and looks {:.0} to {:.0} degrees off the vertical, \
             `look_angle_deg` requires {:.0} to {:.0}",
            camera.name,
            least_deg.max(0.0),
            most_deg,
            wanted.min_deg,
            wanted.max_deg
        ));
    }
    let between = ASIDE_DEG.into_iter().filter(|angle_deg| (from_deg..=to_deg).contains(angle_deg));
    // A margin inside the wanted range, because the vehicle does not hover exactly in place.
    let steepest_deg = if from_deg > 0.0 { (from_deg + INSIDE_DEG).min(0.5 * (from_deg + to_deg)) } else { 0.0 };
    let mut angles_deg: Vec<f64> =
        std::iter::once(steepest_deg).chain(between.filter(|angle_deg| *angle_deg > steepest_deg)).collect();
    angles_deg.sort_by(f64::total_cmp);
    angles_deg.dedup();
    Ok(angles_deg)
}

/// Returns the hover point at this altitude for a picture at this angle off the vertical: on the side from which the vehicle arrives,
/// otherwise the next side that no zone closes and from which the camera does not look into the sun at arrival.
fn vantage_point(
    wish: &Wish<'_>,
    camera: &CameraSetting,
    place: Position,
    (altitude_m, angle_deg): (f64, f64),
) -> Result<Position, String> {
    let height_m = altitude_m - wish.fire.wanted.elevation_m;
    let aside_m = height_m * libm::tan(angle_deg * RAD_PER_DEG);
    let towards_deg = geodesy::azimuth_deg(place, wish.approach);
    let count = if aside_m < 1.0 { 1 } else { AZIMUTHS };
    let (mut closed, mut dazzled) = (None, None);
    for step in 0..count {
        // Alternately to the right and to the left.
        let turn = f64::from(step.div_ceil(2)) * 360.0 / f64::from(AZIMUTHS);
        let azimuth_deg = towards_deg + if step % 2 == 0 { turn } else { -turn };
        let from = if aside_m < 1.0 { place } else { geodesy::destination(place, azimuth_deg, aside_m) };
        match closed_by(wish, &cross(from, ZONE_MARGIN * wish.mission.requirements.zone_margin_m), altitude_m) {
            None => {}
            Some(zone) => {
                closed = Some(zone);
                continue;
            }
        }
        let sight = ViewDirection { azimuth_deg: geodesy::azimuth_deg(from, place), elevation_deg: angle_deg - 90.0 };
        match sun_margin_deg(wish.mission, &camera.name, from, sight, wish.from_s).filter(|deg| *deg < 0.0) {
            None => return Ok(from),
            Some(deg) => dazzled = Some(deg),
        }
    }
    if let Some(deg) = dazzled {
        return Err(format!(
            "`{}` would look {:.0} degrees too near to the sun at {angle_deg:.0} degrees off the vertical",
            camera.name, -deg
        ));
    }
    let (name, low_m, high_m) =
        closed.map_or(("", 0.0, 0.0), |zone| (zone.name.as_str(), zone.altitude_m_min, zone.altitude_m_max));
    Err(format!("it needs {altitude_m:.0} m above sea level, zone {name} closes {low_m:.0} to {high_m:.0} m"))
}

/// Returns lines north to south and west to east through a place, `reach_m` to each side.
fn cross(place: Position, reach_m: f64) -> [(Position, Position); 2] {
    let [north, east, south, west] =
        [0.0, 90.0, 180.0, 270.0].map(|azimuth_deg| geodesy::destination(place, azimuth_deg, reach_m));
    [(north, south), (west, east)]
}

fn draft(
    wish: &Wish<'_>,
    camera: &CameraSetting,
    place: Position,
    (from, altitude_m, angle_deg): (Position, f64, f64),
) -> Draft {
    let model = &wish.mission.model;
    let height_m = altitude_m - wish.fire.wanted.elevation_m;
    let slant_m = height_m / libm::cos(angle_deg * RAD_PER_DEG);
    let air = ForecastAir::new(wish.mission).at(from, altitude_m, wish.from_s);
    let motion = ExposureMotion { slant_m, ..ExposureMotion::default() };
    let weights = camera.planned_weights(&motion, &hold_of(model), air.edr);
    let weights = ClarityWeights { clear_share: air.clear_share, ..weights };
    let count = wish.fire.pictures.count.unwrap_or_else(|| pictures_needed(weights.roll));
    let view = PictureView {
        time_s: wish.from_s,
        position: from,
        altitude_m,
        // The nose or the pan of the mount points at the target.
        attitude: Attitude { heading_deg: geodesy::azimuth_deg(from, place), pitch_deg: 0.0, roll_deg: 0.0 },
        angles: GimbalAngles { pan_deg: 0.0, tilt_deg: angle_deg - 90.0 },
        is_stabilised: true,
        wide_deg: camera.wide_deg,
        high_deg: camera.high_deg,
        pixel_mrad: camera.pixel_mrad,
    };
    let picture_s = model.cameras.iter().find(|one| one.name == camera.name).map_or(0.0, |one| one.picture_s);
    let nose_s =
        if camera.mount.pan_deg.1 > 0.0 || angle_deg < 1.0 { 0.0 } else { NOSE_DEG / model.yaw_rate_deg_s_max };
    let point_s = nose_s + SLEW_DEG / camera.mount.rate_deg_s + camera.mount.settle_s;
    let each_s = picture_s.max(camera.interval_s_min);
    Draft {
        name: format!("vantage-{angle_deg:.0}deg-{height_m:.0}m"),
        altitude_m,
        lines: vec![(from, from)],
        entry: None,
        duration_s: arrival_s(model) + point_s + each_s * f64::from(count) + STEPS_S,
        length_m: 0.0,
        passes: (0..count).map(|_| vec![PlannedPicture { view, weights }]).collect(),
        work: PictureWork {
            camera: camera.name.clone(),
            at: Some(wish.target.id.clone()),
            count,
            every_m: None,
            true_airspeed_mps: model.true_airspeed_m_s_cruise,
            form: None,
        },
    }
}

/// Returns the number of pictures of which at least one is valid with the required probability.
fn pictures_needed(valid: f64) -> u32 {
    if valid >= VALID_CHANCE {
        return 1;
    }
    let needed = libm::ceil(libm::log(1.0 - VALID_CHANCE) / libm::log(1.0 - valid.clamp(0.01, 0.99)));
    (needed as u32).clamp(1, PICTURES_MAX)
}

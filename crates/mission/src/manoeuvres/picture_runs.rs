//! Pictures by distance: strips along a line, sweeps of an area, crossings of a point.

use super::altitudes::closed_by;
use super::drafts::{Draft, predicted};
use super::flying::{FlownLines, fly, lead_in_m};
use super::growth::remaining;
use super::picture_heights as heights;
use super::wish::Wish;
use crate::observing::{ForecastAir, hold_of};
use crate::vehicle::Airframe;
use apex_geo::coverage::{SweepSettings, sweep_lines};
use apex_geo::geodesy;
use apex_geo::wind::{self, Wind};
use apex_model::problem::{Manoeuvre, PictureWork, Position};
use apex_observation::attitude::Attitude;
use apex_observation::clarity::ClarityWeights;
use apex_observation::pictures::{PictureView, PlannedPicture};
use apex_observation::predict::{AirConditions, Conditions};
use apex_observation::sensor::{CameraSetting, ExposureMotion};
use apex_observation::target::TargetArea;

/// Least speed over ground on a line, m/s.
const GROUND_SPEED_M_S_MIN: f64 = 1.0;
/// Planned interval between pictures as a multiple of the camera's least interval.
const INTERVAL_MARGIN: f64 = 1.1;
/// Time in seconds for which a fixed wing turns after the last line, until the camera is at rest and the next path is known.
const LEAVE_S: f64 = 5.0;
/// Maximum number of pictures of one way; a larger target must be split.
const PICTURES_MAX: f64 = 20_000.0;
/// The line across a point is as long as this many pictures.
const PASS_PICTURES: f64 = 2.0;

/// Strips along a line, or sweeps of an area.
///
/// # Errors
/// If there is none: the reason, with the nearest possibility.
pub(super) fn ways(wish: &Wish<'_>, camera: &CameraSetting) -> Result<Vec<Manoeuvre>, String> {
    runs(wish, camera, |altitude_m| match &wish.fire.wanted.area {
        TargetArea::Line(places) => Ok(along(places, wish.approach)),
        _ => sweep(wish, camera, altitude_m),
    })
}

/// Returns lines across a point, for a vehicle that cannot hover: in the direction of its arrival.
///
/// # Errors
/// If there is none: the reason, with the nearest possibility.
pub(super) fn passes(wish: &Wish<'_>, camera: &CameraSetting, place: Position) -> Result<Vec<Manoeuvre>, String> {
    runs(wish, camera, |altitude_m| {
        let (_, along_m) = camera.footprint_m(altitude_m - wish.fire.wanted.elevation_m);
        let track_deg = geodesy::azimuth_deg(wish.approach, place);
        let half_m = 0.5 * PASS_PICTURES * along_m;
        Ok(vec![(
            geodesy::destination(place, track_deg + 180.0, half_m),
            geodesy::destination(place, track_deg, half_m),
        )])
    })
}

fn runs(
    wish: &Wish<'_>,
    camera: &CameraSetting,
    lines_at: impl Fn(f64) -> Result<Vec<(Position, Position)>, String>,
) -> Result<Vec<Manoeuvre>, String> {
    if !camera.sees_nadir() {
        let (low_deg, high_deg) = camera.mount.tilt_deg;
        return Err(format!(
            "pictures of lines and areas look straight down, `{}` tilts from {low_deg:.0} to {high_deg:.0} degrees",
            camera.name
        ));
    }
    if let Some(angles) = wish.look.look_angles.filter(|angles| angles.min_deg > 0.0) {
        return Err(format!(
            "pictures of lines and areas look straight down, `look_angle_deg` requires {:.0} degrees at least; give points for \
             oblique looks",
            angles.min_deg
        ));
    }
    let (mut made, mut trouble): (Vec<Manoeuvre>, Option<String>) = (Vec::new(), None);
    for lowest_m in heights::of(wish, camera, 0.0)? {
        let draft = lines_at(lowest_m).and_then(|lines| {
            let altitude_m = over_lead_ins_m(wish, &lines, lowest_m)?;
            match closed_by(wish, &lines, altitude_m) {
                None => draft(wish, camera, lines, altitude_m),
                Some(zone) => {
                    let (low_m, high_m) = (zone.altitude_m_min, zone.altitude_m_max);
                    Err(format!("it needs {altitude_m:.0} m, zone {} closes {low_m:.0} to {high_m:.0} m", zone.name))
                }
            }
        });
        let draft = match draft {
            Ok(draft) => draft,
            Err(why) => {
                trouble = Some(why);
                continue;
            }
        };
        let (altitude_m, is_raised) = (draft.altitude_m, draft.altitude_m > lowest_m);
        if is_raised && made.iter().any(|other| other.altitude_m == altitude_m) {
            continue;
        }
        match predicted(wish, draft) {
            Some(manoeuvre) => made.push(manoeuvre),
            None if is_raised => {
                let wanted_m = wish.look.resolution.wanted_m;
                trouble = Some(format!(
                    "the terrain before its lines needs {altitude_m:.0} m, too high for pixels of {wanted_m} m"
                ));
            }
            None => {}
        }
    }
    match (made.is_empty(), trouble) {
        (true, Some(why)) => Err(why),
        _ => Ok(made),
    }
}

/// Returns the lowest altitude from `altitude_m` on that is clear of the terrain under lines and, for a fixed wing, under the lead-ins
/// before them: a vehicle joins a line at its altitude.
///
/// # Errors
/// If the vehicle does not fly so high.
fn over_lead_ins_m(wish: &Wish<'_>, lines: &[(Position, Position)], altitude_m: f64) -> Result<f64, String> {
    let (mission, model) = (wish.mission, &wish.mission.model);
    if model.airframe == Airframe::Rotorcraft {
        return Ok(altitude_m);
    }
    let Some(terrain) = &mission.terrain else { return Ok(altitude_m) };
    let above_m = mission.requirements.terrain_clearance_m.unwrap_or(0.0) + heights::LEVEL_M;
    let clear_m = lines.iter().filter_map(|(from, to)| {
        let before_deg = geodesy::azimuth_deg(*from, *to) + 180.0;
        let entry = geodesy::destination(*from, before_deg, lead_in_m(model, &mission.forecast));
        Some(terrain.highest_m_along(entry, *to, mission.ground_room_m(), (0.0, 0.0))? + above_m)
    });
    let raised_m = clear_m.fold(altitude_m, f64::max);
    let ceiling_m = model.ceiling_m * model.planning.ceiling_share;
    if raised_m > ceiling_m {
        return Err(format!(
            "the terrain before its lines needs {raised_m:.0} m, the vehicle flies no higher than {ceiling_m:.0} m"
        ));
    }
    Ok(raised_m)
}

/// Returns the pieces of a line in order, from its nearer end.
fn along(places: &[Position], approach: Position) -> Vec<(Position, Position)> {
    let far = |place: Option<&Position>| place.map_or(0.0, |place| geodesy::distance_m(*place, approach));
    let mut places = places.to_vec();
    if far(places.last()) < far(places.first()) {
        places.reverse();
    }
    places.iter().copied().zip(places.iter().copied().skip(1)).collect()
}

/// Returns parallel lines over an area, spaced for the required sidelap.
fn sweep(wish: &Wish<'_>, camera: &CameraSetting, altitude_m: f64) -> Result<Vec<(Position, Position)>, String> {
    let (across_m, along_m) = camera.footprint_m(altitude_m - wish.fire.wanted.elevation_m);
    let wind = wind_at(wish, altitude_m);
    let airspeed_mps = wish.mission.model.true_airspeed_m_s_cruise;
    // Pictures are turned by the crab angle: the strip that they all see is narrower.
    let crab_sine = (libm::hypot(wind.east_mps, wind.north_mps) / airspeed_mps).min(0.7);
    let swath_m = across_m * libm::sqrt(1.0 - crab_sine * crab_sine) - along_m * crab_sine * wish.fire.pictures.overlap;
    let settings = SweepSettings {
        swath_m: swath_m.max(0.3 * across_m),
        overlap: wish.fire.pictures.sidelap,
        track_deg: None,
        run_in_m: 0.0,
    };
    let (mut lines, mut entry) = (Vec::new(), wish.approach);
    for ground in remaining(wish.fire) {
        lines.extend(sweep_lines(&ground, &settings, entry)?);
        entry = lines.last().map_or(entry, |(_, exit)| *exit);
    }
    Ok(lines)
}

fn wind_at(wish: &Wish<'_>, altitude_m: f64) -> Wind {
    wind::at(&wish.mission.forecast, wish.target.position, altitude_m, wish.from_s)
}

fn draft(
    wish: &Wish<'_>,
    camera: &CameraSetting,
    lines: Vec<(Position, Position)>,
    altitude_m: f64,
) -> Result<Draft, String> {
    let (mission, model) = (wish.mission, &wish.mission.model);
    let height_m = altitude_m - wish.fire.wanted.elevation_m;
    let (_, along_m) = camera.footprint_m(height_m);
    let base_m = along_m * (1.0 - wish.fire.pictures.overlap);
    let (airspeed_mps, fastest_mps) = airspeed(wish, camera, &lines, (altitude_m, height_m, base_m))?;
    // Where the vehicle cannot fly slower, pictures are farther apart.
    let every_m = rounded(base_m.max(fastest_mps * camera.interval_s_min * INTERVAL_MARGIN));
    let flown = fly(&lines, altitude_m, wish.from_s, Some(airspeed_mps), model, &mission.forecast)?;
    let pictures = planned(wish, camera, &flown, (altitude_m, height_m, every_m))?;
    let kind = match &wish.fire.wanted.area {
        TargetArea::Point(_) => "pass",
        TargetArea::Line(_) => "strip",
        _ => "survey",
    };
    Ok(Draft {
        name: format!("{kind}-{height_m:.0}m"),
        altitude_m,
        lines,
        // Missions without requirements leave joins to the autopilot, which chooses where a lead-in begins.
        entry: None,
        duration_s: flown.duration_s + if model.airframe == Airframe::FixedWing { LEAVE_S } else { 0.0 },
        length_m: flown.length_m,
        work: PictureWork {
            camera: camera.name.clone(),
            at: None,
            count: u32::try_from(pictures.len()).unwrap_or(u32::MAX),
            every_m: Some(every_m),
            true_airspeed_mps: airspeed_mps,
            form: None,
        },
        passes: vec![pictures],
    })
}

/// Rounds to a tenth, so that plans stay readable.
fn rounded(number: f64) -> f64 {
    (number * 10.0).round() / 10.0
}

/// Returns the airspeed on the lines, and the resulting greatest ground speed: limited by the picture interval and smear of the camera,
/// and by the least speed of the vehicle.
fn airspeed(
    wish: &Wish<'_>,
    camera: &CameraSetting,
    lines: &[(Position, Position)],
    (altitude_m, height_m, base_m): (f64, f64, f64),
) -> Result<(f64, f64), String> {
    let model = &wish.mission.model;
    let wind = wind_at(wish, altitude_m);
    let limit_mps = camera.ground_speed_mps_max(height_m).min(base_m / (camera.interval_s_min * INTERVAL_MARGIN));
    let speeds = |airspeed_mps: f64| -> Option<(f64, f64)> {
        let mut range = (f64::INFINITY, 0.0_f64);
        for (from, to) in lines {
            let triangle = wind::triangle(geodesy::azimuth_deg(*from, *to), airspeed_mps, wind)?;
            range = (range.0.min(triangle.ground_speed_mps), range.1.max(triangle.ground_speed_mps));
        }
        Some(range)
    };
    let slowest_mps = match model.airframe {
        Airframe::FixedWing => 1.15 * model.indicated_airspeed_m_s_min,
        Airframe::Rotorcraft => GROUND_SPEED_M_S_MIN,
    };
    let mut airspeed_mps = model.true_airspeed_m_s_cruise;
    for _ in 0..8 {
        let Some((_, fastest_mps)) = speeds(airspeed_mps) else { break };
        if fastest_mps <= limit_mps {
            break;
        }
        airspeed_mps = (airspeed_mps - (fastest_mps - limit_mps)).max(slowest_mps);
    }
    airspeed_mps = rounded(airspeed_mps);
    // Against the wind the vehicle must still make progress.
    while speeds(airspeed_mps).is_none_or(|(least_mps, _)| least_mps < GROUND_SPEED_M_S_MIN) {
        airspeed_mps = rounded(airspeed_mps + 0.5);
        if airspeed_mps > model.true_airspeed_m_s_max {
            return Err(format!("its lines cannot be flown at {altitude_m:.0} m: the wind is too strong"));
        }
    }
    let (_, fastest_mps) = speeds(airspeed_mps).unwrap_or((airspeed_mps, airspeed_mps));
    Ok((airspeed_mps, fastest_mps))
}

/// Returns the pictures along the lines.
fn planned(
    wish: &Wish<'_>,
    camera: &CameraSetting,
    flown: &FlownLines,
    (altitude_m, height_m, every_m): (f64, f64, f64),
) -> Result<Vec<PlannedPicture>, String> {
    let hold = hold_of(&wish.mission.model);
    let air = ForecastAir::new(wish.mission);
    let wanted = flown.lines.iter().map(|line| geodesy::distance_m(line.from, line.to) / every_m + 1.0).sum::<f64>();
    if wanted > PICTURES_MAX {
        return Err(format!(
            "it needs {wanted:.0} pictures from {height_m:.0} m, {PICTURES_MAX} are possible; split it, or want larger pixels"
        ));
    }
    let mut pictures = Vec::new();
    for line in &flown.lines {
        let (length_m, track_deg) = geodesy::inverse(line.from, line.to);
        let count = libm::floor(length_m / every_m) as u32;
        for number in 0..=count {
            let along_m = f64::from(number) * every_m;
            let position = geodesy::destination(line.from, track_deg, along_m);
            let time_s = line.from_s + along_m / line.ground_speed_mps;
            let motion = ExposureMotion {
                ground_speed_mps: line.ground_speed_mps,
                slant_m: height_m,
                ..ExposureMotion::default()
            };
            let AirConditions { edr, clear_share } = air.at(position, altitude_m, time_s);
            let weights = ClarityWeights { clear_share, ..camera.planned_weights(&motion, &hold, edr) };
            let heading_deg = if wish.mission.model.airframe == Airframe::FixedWing { line.crab_deg } else { 0.0 };
            let view = PictureView {
                time_s,
                position,
                altitude_m,
                attitude: Attitude { heading_deg: track_deg + heading_deg, pitch_deg: 0.0, roll_deg: 0.0 },
                angles: CameraSetting::straight_down(),
                is_stabilised: true,
                wide_deg: camera.wide_deg,
                high_deg: camera.high_deg,
                pixel_mrad: camera.pixel_mrad,
            };
            pictures.push(PlannedPicture { view, weights });
        }
    }
    Ok(pictures)
}

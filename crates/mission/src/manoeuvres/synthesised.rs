//! Manoeuvres of library "manoeuvres" as ways to observe a wanted look: the candidates of acquisition goals, for planners of tours.
//!
//! Bound: [`ALTERNATIVES_MAX`] forecasts for each look.

use super::flying::{arrival_s, lead_in_m};
use super::scanner::quality;
use super::wish::Wish;
use crate::Mission;
use crate::acquisition::{
    AcquisitionGoal, ManoeuvreCandidate, ProductKind, at_height, closed_by, craft_of, forecast_of, form_of,
    ground_kept, heights_m, scene_of, sun_miss,
};
use crate::ground::MissionGround;
use apex_geo::geodesy;
use apex_geo::wind;
use apex_model::pattern::Pattern;
use apex_model::problem::{Manoeuvre, PictureWork, Position};
use apex_model::value::Value;
use apex_observation::grid::{GridSettings, PLANNING_CELLS, TargetGrid};
use apex_observation::manoeuvres::{DataHandling, FlightPath, Forecast, Instrument, Scene};
use apex_observation::sensor::CameraSetting;
use apex_observation::timing::LightNeed;
use std::sync::Arc;

/// Maximum number of predicted candidates for one look.
const ALTERNATIVES_MAX: usize = 24;
/// Maximum number of chords by which a path is described to planners.
const CHORDS_MAX: usize = 48;
/// Time in seconds, in addition to the slew, in which a camera is pointed at the target before the path begins: acknowledgements and steps.
const STEPS_S: f64 = 1.0;
/// Assumed slew of the mount before the path begins, degrees.
const SLEW_DEG: f64 = 90.0;
/// Items of `(perform FORM at PLACE for TARGET with CAMERA at SPEED every DISTANCE due DUE)`.
const PERFORM_ITEMS: usize = 14;

/// Returns true if the mission's program can fly a planned manoeuvre: it uses library "manoeuvres".
pub(super) fn are_flown(mission: &Mission) -> bool {
    mission.library.procedures.iter().any(|procedure| match &procedure.index {
        Pattern::List(items) if items.len() == PERFORM_ITEMS => {
            matches!(items.first(), Some(Pattern::Literal(Value::Symbol(head))) if head.is("perform"))
        }
        _ => false,
    })
}

/// Returns orbits, spirals, arcs and offset lines from which the camera sees the look, each with its predicted result.
///
/// # Errors
/// If there is none: the nearest possibility.
pub(super) fn alternatives(wish: &Wish<'_>, camera: &CameraSetting) -> Result<Vec<Manoeuvre>, String> {
    let goal = goal_of(wish, camera);
    let instrument = Instrument::Camera(camera.clone());
    let from = (wish.approach, wish.from_s);
    let mut candidates = Vec::new();
    for height_m in heights_m(wish.mission, &goal, &instrument) {
        let all = at_height((wish.mission, &goal), (&camera.name, &instrument), height_m, from);
        candidates.extend(all.into_iter().filter(|candidate| is_other(&candidate.manoeuvre.path)));
    }
    let (count, mut made, mut nearest) = (candidates.len(), Vec::new(), None::<(f64, String)>);
    for (index, candidate) in candidates.into_iter().enumerate() {
        // Beyond the limit, candidates are thinned evenly.
        let kept =
            count <= ALTERNATIVES_MAX || index * ALTERNATIVES_MAX / count != (index + 1) * ALTERNATIVES_MAX / count;
        if !kept {
            continue;
        }
        match way(wish, &goal, camera, candidate) {
            Ok(way) => made.extend(way),
            Err((by, why)) => {
                if nearest.as_ref().is_none_or(|(least, _)| by < *least) {
                    nearest = Some((by, why));
                }
            }
        }
    }
    match (made.is_empty(), nearest) {
        (true, Some((_, why))) => Err(why),
        (true, None) => Err("no manoeuvre fits the vehicle and its camera".to_string()),
        (false, _) => Ok(made),
    }
}

/// Returns true for the paths that only this module plans: module `scanner` and its siblings plan lines over the target and vantage points.
fn is_other(path: &FlightPath) -> bool {
    matches!(path, FlightPath::Orbit(_) | FlightPath::Spiral(_) | FlightPath::Arc(_) | FlightPath::StandOff(_))
}

/// Returns the look as an acquisition goal.
fn goal_of(wish: &Wish<'_>, camera: &CameraSetting) -> AcquisitionGoal {
    let mut target = wish.fire.wanted.clone();
    (target.name, target.looks, target.after) = (wish.target.id.clone(), vec![wish.look.clone()], Vec::new());
    // The grid is as coarse as for goals in flight, because a whole orbit has many pictures.
    let settings = GridSettings { cells: PLANNING_CELLS / 4, ..GridSettings::default() };
    let ground = MissionGround::new(wish.mission.terrain.clone(), target.elevation_m);
    let grid = TargetGrid::new(&target, settings).map(|grid| Arc::new(grid.with_elevations(&ground)));
    let grid = grid.unwrap_or_else(|_| Arc::clone(&wish.fire.grid));
    AcquisitionGoal {
        named: Value::symbol(&wish.target.id),
        target,
        grid,
        position: wish.target.position,
        radius_m: wish.fire.radius_m,
        product: ProductKind::Stills,
        resolution_m: wish.look.resolution.wanted_m,
        coverage_min: 0.0,
        clarity_min: 0.0,
        look_angle_deg: wish.look.look_angles.map(|angles| (angles.min_deg, angles.max_deg)),
        light: LightNeed::Any,
        latency_s: None,
        by_s: None,
        sensor: Some(camera.name.clone()),
        data: None,
        handling: DataHandling::Store,
    }
}

/// Returns the candidate as a way to observe; `None` if it has no value. The error contains the relative distance from meeting the
/// limits.
fn way(
    wish: &Wish<'_>,
    goal: &AcquisitionGoal,
    camera: &CameraSetting,
    candidate: ManoeuvreCandidate,
) -> Result<Option<Manoeuvre>, (f64, String)> {
    let mission = wish.mission;
    let altitude_m = goal.target.elevation_m + candidate.height_m;
    let craft = craft_of(&mission.model, altitude_m);
    let place = (goal.position, goal.target.elevation_m);
    let scene = scene_of(place, &mission.forecast, candidate.height_m, wish.approach, wish.from_s);
    let setting = (&craft, &candidate.instrument, &scene);
    let seen = (&goal.target, goal.grid.as_ref());
    let forecast = forecast_of(mission, &candidate.manoeuvre, setting, seen, wish.is_explained)
        .map_err(|refusal| (1.0 + refusal.excess(), refusal.to_string()))?;
    let name = format!("{}-{:.0}m", candidate.manoeuvre.path.name(), candidate.height_m);
    if let Some(zone) = closed_by(mission, &forecast, &scene, None) {
        let (low_m, high_m) = (zone.altitude_m_min, zone.altitude_m_max);
        let by = (high_m - altitude_m).min(altitude_m - low_m).max(0.0) / altitude_m.max(1.0);
        let why = format!("`{name}` needs {altitude_m:.0} m, zone {} closes {low_m:.0} to {high_m:.0} m", zone.name);
        return Err((by, why));
    }
    if let Err(refusal) = ground_kept(mission, goal, &candidate, (&forecast, &scene)) {
        return Err((refusal.excess(), refusal.to_string()));
    }
    if let Some((by, why)) = sun_miss(mission, &camera.name, &forecast, &scene) {
        return Err((by, format!("`{name}` {why}")));
    }
    let (Some(form), Some(look)) = (form_of(&candidate.manoeuvre.path), &forecast.look) else { return Ok(None) };
    let factors = quality(look);
    if factors.product() <= 0.0 {
        return Err((0.9, format!("the pictures of `{name}` are worth nothing")));
    }
    let lines = chords(&forecast, &scene);
    let slew_s = SLEW_DEG / camera.mount.rate_deg_s + camera.mount.settle_s;
    let (before_s, entry) = match craft.can_hover {
        true => (arrival_s(&mission.model) + slew_s + STEPS_S, None),
        false => {
            let found = lead_in(mission, &lines, (altitude_m, wish.from_s), candidate.speed_mps);
            found.map_or((0.0, None), |(seconds, entry)| (seconds, Some(entry)))
        }
    };
    Ok(Some(Manoeuvre {
        name,
        altitude_m,
        entry,
        duration_s: before_s + forecast.time_s,
        length_m: forecast.length_m,
        quality: factors,
        pictures: Some(PictureWork {
            camera: camera.name.clone(),
            at: Some(wish.target.id.clone()),
            count: u32::try_from(forecast.pictures).unwrap_or(u32::MAX),
            every_m: Some(candidate.every_m),
            true_airspeed_mps: candidate.speed_mps,
            form: Some(form),
        }),
        lines,
    }))
}

/// Returns the path as chords.
fn chords(forecast: &Forecast, scene: &Scene) -> Vec<(Position, Position)> {
    let poses = &forecast.flown.poses;
    let step = poses.len().div_ceil(CHORDS_MAX).max(1);
    let mut places: Vec<Position> = poses.iter().step_by(step).map(|pose| scene.position(pose.point)).collect();
    places.extend(poses.last().map(|pose| scene.position(pose.point)));
    places.dedup();
    let mut lines: Vec<(Position, Position)> = places.windows(2).filter_map(pair).collect();
    if let (true, Some(place)) = (lines.is_empty(), places.first()) {
        lines.push((*place, *place));
    }
    lines
}

fn pair(pair: &[Position]) -> Option<(Position, Position)> {
    match pair {
        [from, to] => Some((*from, *to)),
        _ => None,
    }
}

/// Returns the time and the beginning of the straight flight before the first chord, as it is flown: from cruise speed to that of the
/// path. `None` for a path without length, and against a wind that is too strong.
fn lead_in(
    mission: &Mission,
    lines: &[(Position, Position)],
    (altitude_m, at_s): (f64, f64),
    speed_mps: f64,
) -> Option<(f64, Position)> {
    let (from, to) = lines.first().filter(|(from, to)| from != to)?;
    let (model, field) = (&mission.model, &mission.forecast);
    let track_deg = geodesy::azimuth_deg(*from, *to);
    let length_m = lead_in_m(model, field);
    let wind = wind::at(field, *from, altitude_m, at_s);
    let cruise_mps = wind::triangle(track_deg, model.true_airspeed_m_s_cruise, wind)?.ground_speed_mps;
    let lasts_s = length_m / cruise_mps + model.speed_change_losses_s(speed_mps, cruise_mps).0;
    Some((lasts_s, geodesy::destination(*from, track_deg + 180.0, length_m)))
}

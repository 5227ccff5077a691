//! Conversion of the mission's vehicle, sensors and targets to the types of manoeuvre synthesis.

use super::sweep_form::{corners_of, radius_m};
use crate::observing::{camera_names, camera_of, hold_of, looks_with, scanner_of};
use crate::vehicle::{Airframe, VehicleModel};
use crate::{Mission, Target, TargetKind};
use apex_geo::plane::Point;
use apex_geo::wind;
use apex_model::problem::{Position, WindField};
use apex_observation::manoeuvres::{Craft, DrainTable, Instrument, Scene};

/// Maximum rearward and sideways airspeed of a rotorcraft, m/s, which vehicle files do not state. Assumption: small helicopters reach 5
/// to 10 m/s.
const ASIDE_MPS_MAX: f64 = 10.0;
/// Time of straight flight of a fixed wing before it begins a line.
const SETTLE_S: f64 = 5.0;
/// Slowest planned airspeed of a fixed wing as a multiple of its minimum indicated airspeed.
const SLOW_SHARE: f64 = 1.15;

/// Returns the performance of the vehicle at an altitude above mean sea level.
pub(crate) fn craft_of(model: &VehicleModel, altitude_m: f64) -> Craft {
    let can_hover = model.airframe == Airframe::Rotorcraft;
    let (cruise, most) = (model.true_airspeed_m_s_cruise, model.true_airspeed_m_s_max);
    let slowest = if can_hover { 0.0 } else { SLOW_SHARE * model.indicated_airspeed_m_s_min };
    let hovers = |figure: f64| if can_hover { figure } else { 0.0 };
    let steps = 24;
    let drain = (0..=steps).map(|step| {
        let airspeed = most * f64::from(step) / f64::from(steps);
        (airspeed, model.drain_per_s(airspeed, altitude_m, 0.0))
    });
    Craft {
        name: model.name.clone(),
        can_hover,
        true_airspeed_mps: cruise,
        true_airspeed_mps_min: slowest.min(cruise),
        true_airspeed_mps_max: most,
        bank_deg: if can_hover { model.bank_deg_max } else { model.turns.bank_share * model.bank_deg_max },
        acceleration_mps2: model.acceleration_m_s2_max,
        braking_mps2: if can_hover {
            model.braking_share * model.acceleration_m_s2_max
        } else {
            model.acceleration_m_s2_max
        },
        yaw_rate_deg_s: hovers(model.yaw_rate_deg_s_max),
        climb_mps_max: model.climb_rate_m_s_max,
        descent_mps_max: model.descent_rate_m_s_max,
        rearward_mps_max: hovers(ASIDE_MPS_MAX.min(most)),
        sideways_mps_max: hovers(ASIDE_MPS_MAX.min(most)),
        wind_mps_max: model.wind_m_s_max,
        settle_s: if can_hover { 0.0 } else { SETTLE_S },
        level_pitch_deg: model.cruise_pitch_rad(altitude_m).to_degrees(),
        hold: hold_of(model),
        drain: DrainTable { points: drain.collect() },
    }
}

/// Returns the sensor called `name`: `scanner` or a camera. Without a name: the first camera, otherwise the scanner.
///
/// # Errors
/// The names of the sensors on board if the vehicle does not carry the requested one.
pub(crate) fn instrument_of(model: &VehicleModel, name: Option<&str>) -> Result<Instrument, String> {
    let scanner = || scanner_of(model).map(Instrument::Scanner);
    let found = match name {
        Some("scanner") => scanner(),
        Some(name) => camera_of(model, name).map(Instrument::Camera),
        None => looks_with(model).map(Instrument::Camera).or_else(scanner),
    };
    found.ok_or_else(|| {
        let mut carried = camera_names(model);
        if model.scanner.is_some() {
            carried.push("scanner");
        }
        let wanted = name.map_or_else(|| "a sensor".to_string(), |name| format!("`{name}`"));
        match carried.is_empty() {
            true => format!("`{}` carries no sensor", model.name),
            false => format!("`{}` does not carry {wanted}; it carries {}", model.name, carried.join(", ")),
        }
    })
}

/// Returns the target with this id; upper and lower case are equal.
///
/// # Errors
/// The names of the mission's targets if none has this id.
pub(crate) fn target_of<'a>(mission: &'a Mission, id: &str) -> Result<&'a Target, String> {
    mission.targets.iter().find(|target| target.id.eq_ignore_ascii_case(id)).ok_or_else(|| {
        let known: Vec<&str> = mission.targets.iter().map(|target| target.id.as_str()).collect();
        let near = nearest_name(id, &known).map_or_else(String::new, |name| format!("did you mean `{name}`? "));
        format!("the mission has no target `{id}`; {near}it has {}", known.join(", "))
    })
}

/// Returns the known name that shares the longest prefix with a wrong one.
fn nearest_name<'a>(wrong: &str, known: &[&'a str]) -> Option<&'a str> {
    let shared = |name: &str| {
        let same = |(a, b): &(char, char)| a.eq_ignore_ascii_case(b);
        name.chars().zip(wrong.chars()).take_while(same).count()
    };
    known.iter().copied().max_by_key(|name| shared(name)).filter(|name| shared(name) >= 1)
}

/// Returns the corners of a target's ground, metres east and north of its middle; none for a point.
pub(super) fn target_corners(target: &Target) -> Vec<(f64, f64)> {
    match &target.kind {
        TargetKind::Fire(fire) => {
            let scene = Scene::still(target.position, elevation_m(target));
            corners_of(&fire.wanted.area, &scene, radius_m(target.position, &fire.grid))
        }
        _ => Vec::new(),
    }
}

/// Returns the level of the observed part above mean sea level: the observed ground, or the middle of a structure.
pub(crate) fn elevation_m(target: &Target) -> f64 {
    match &target.kind {
        TargetKind::Fire(fire) => fire.wanted.elevation_m,
        _ => target.elevation_m,
    }
}

/// Returns the scene of a manoeuvre `height_m` over a target, with the wind that `field` holds.
pub(crate) fn scene_of(
    (position, elevation_m): (Position, f64),
    field: &WindField,
    height_m: f64,
    approach: Position,
    from_s: f64,
) -> Scene {
    let wind = wind::at(field, position, elevation_m + height_m, from_s);
    let scene = Scene { target: position, elevation_m, wind, approach: Point { x: 0.0, y: -1.0 }, from_s };
    let towards = scene.point(approach);
    Scene { approach: if towards.length() > 1.0 { towards } else { scene.approach }, ..scene }
}

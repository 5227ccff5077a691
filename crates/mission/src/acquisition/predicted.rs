//! Predicted yield of a manoeuvre in PDL notation in a mission.

use super::modes::{at_interval, check_sight, manoeuvre_of_form};
use super::paths::{height_m, manoeuvre_of};
use super::sweep_form::SweptGround;
use super::vehicle::{craft_of, elevation_m, instrument_of, scene_of, target_corners, target_of};
use crate::ground::MissionGround;
use crate::observing::ForecastAir;
use crate::{Mission, TargetKind};
use apex_geo::geodesy::Position;
use apex_model::value::Value;
use apex_observation::grid::TargetGrid;
use apex_observation::manoeuvres::{
    Craft, FlightPath, Forecast, ForecastContext, Instrument, Manoeuvre, PayloadUse, Refusal, Scene, TimedTrack,
};
use apex_observation::predict::PredictionContext;
use apex_observation::target::ObservedTarget;
use std::collections::BTreeMap;

/// A manoeuvre requested by a PDL program.
#[derive(Clone, Debug, PartialEq)]
pub struct PerformedManoeuvre<'a> {
    /// The form, for example `(orbit :radius 60m :height 40m)`.
    pub form: &'a Value,
    /// The target's id.
    pub target: &'a str,
    /// The camera, or `scanner`; `None` for the vehicle's default sensor.
    pub sensor: Option<&'a str>,
    /// Airspeed of a fixed wing, ground speed of a rotorcraft; `None` is the speed of the sharpest pictures.
    pub speed_mps: Option<f64>,
    /// Recording of a camera.
    pub payload: PayloadUse,
    /// Its beginning, since the mission's start.
    pub from_s: f64,
}

/// Predicts the looks of the manoeuvre at its target and its cost.
///
/// # Errors
/// An error message: the form is invalid, the mission has no such target or sensor, or a limit of vehicle, sensor or wind is exceeded.
pub fn forecast(mission: &Mission, wanted: &PerformedManoeuvre<'_>) -> Result<Forecast, String> {
    let target = target_of(mission, wanted.target)?;
    let instrument = instrument_of(&mission.model, wanted.sensor)?;
    let corners = target_corners(target);
    let ground = SweptGround { target: &target.id, corners: &corners, instrument: &instrument };
    let (path, modes) = manoeuvre_of_form(wanted.form, &ground)?;
    let scene = scene(mission, (target.position, elevation_m(target)), &path, target.position, wanted.from_s);
    let craft = craft_of(&mission.model, scene.elevation_m + height_m(&path));
    let scans = matches!(instrument, Instrument::Scanner(_));
    let data = modes.data_over(mission.settings.downlink.as_ref())?;
    let manoeuvre = manoeuvre_of((path, modes), wanted.speed_mps, data, (craft.can_hover, scans));
    let payload = if scans { manoeuvre.payload } else { wanted.payload };
    let manoeuvre = Manoeuvre { payload, ..manoeuvre };
    let instrument = at_interval(instrument, &manoeuvre.payload);
    check_sight(&manoeuvre, &craft, &instrument)?;
    let TargetKind::Fire(fire) = &target.kind else {
        return Err(format!("the mission states no observation of `{}`: give it a value and a resolution", target.id));
    };
    let told = |refusal: Refusal| refusal.to_string();
    forecast_of(mission, &manoeuvre, (&craft, &instrument, &scene), (&fire.wanted, &fire.grid), false).map_err(told)
}

/// Returns the scene of a path over a place in the mission's forecast wind.
pub(super) fn scene(
    mission: &Mission,
    place: (Position, f64),
    path: &FlightPath,
    approach: Position,
    from_s: f64,
) -> Scene {
    scene_of(place, &mission.forecast, height_m(path), approach, from_s)
}

/// Returns the forecast of a manoeuvre in the mission's air; with the causes of its losses if requested.
pub(crate) fn forecast_of(
    mission: &Mission,
    manoeuvre: &Manoeuvre,
    (craft, instrument, scene): (&Craft, &Instrument, &Scene),
    observed: (&ObservedTarget, &TargetGrid),
    is_explained: bool,
) -> Result<Forecast, Refusal> {
    let timed = manoeuvre.timed(craft, instrument, scene)?;
    Ok(observe(mission, (manoeuvre, timed), (craft, instrument, scene), observed, is_explained))
}

/// Returns the forecast of a manoeuvre whose poses are known.
pub(super) fn observe(
    mission: &Mission,
    (manoeuvre, timed): (&Manoeuvre, TimedTrack),
    (craft, instrument, scene): (&Craft, &Instrument, &Scene),
    (target, grid): (&ObservedTarget, &TargetGrid),
    is_explained: bool,
) -> Forecast {
    let first_valid_s = BTreeMap::new();
    let air = ForecastAir::new(mission);
    let ground = MissionGround::new(mission.terrain.clone(), target.elevation_m);
    let prediction = PredictionContext {
        zero_unix_s: mission.settings.epoch_unix_s.unwrap_or(0.0),
        ground: &ground,
        conditions: &air,
        seen: None,
        products: &[],
        first_valid_s: &first_valid_s,
        is_explained,
    };
    manoeuvre.observe(timed, (craft, instrument), scene, &ForecastContext { target, grid, prediction })
}

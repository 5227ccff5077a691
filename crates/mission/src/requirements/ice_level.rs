//! The altitude without ice near ice that was met or is forecast, and whether the flight leads back into it.
//!
//! Near ice that was met, all air between freezing and the temperature that is too cold for ice counts as ice, by the measured temperature
//! and the standard lapse rate.

use super::commanded::{Commanded, FlightOrder, Flown};
use crate::Mission;
use apex_model::event::{EventKind, StateVariable};
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;

/// Temperature falls by this with altitude in the standard atmosphere, K/m.
const LAPSE_K_M: f64 = 0.0065;
/// Ice forms between these temperatures, K; an altitude without ice is warmer or colder by the margin, and is kept as long as it is
/// warmer or colder by the rest of it.
const ICE_K: (f64, f64) = (253.15, 273.15);
const MARGIN_K: f64 = 1.5;
const REST_K: f64 = 0.3;
/// Least height over the ground, and distance below the ceiling, of an altitude without ice.
const HEIGHT_M_MIN: f64 = 500.0;
const BELOW_CEILING_M: f64 = 50.0;
/// Multiple of the required terrain clearance that is kept.
const CLEARANCE_SHARE: f64 = 1.5;
/// Interval of altitudes that are compared with the forecast of clouds.
const STEP_M: f64 = 250.0;

/// Temperatures of the air, from that at the vehicle.
struct MeasuredAir {
    altitude_m: f64,
    outside_k: f64,
}

impl MeasuredAir {
    fn altitude_m_of(&self, kelvin: f64) -> f64 {
        self.altitude_m + (self.outside_k - kelvin) / LAPSE_K_M
    }

    /// Returns true if ice may form at an altitude, with a margin of temperature on both sides.
    fn may_ice(&self, altitude_m: f64, margin_k: f64) -> bool {
        let there_k = self.outside_k - LAPSE_K_M * (altitude_m - self.altitude_m);
        (ICE_K.0 - margin_k..=ICE_K.1 + margin_k).contains(&there_k)
    }
}

/// Updates the memory of ice by the vehicle's present state.
pub(super) fn update(flown: &mut Flown, mission: &Mission, commanded: &Commanded, now_s: f64) {
    let (Some(here), Some(outside_k)) = (flown.position, flown.outside_k) else { return };
    let is_icing = flown.is_icing;
    flown.ice.remember(now_s, here, is_icing);
    let air = MeasuredAir { altitude_m: flown.altitude_m, outside_k };
    let is_bound = matches!(commanded.order, Some(FlightOrder::Land(_) | FlightOrder::TakeOff(_)));
    let planned_m = commanded.planned_m.unwrap_or(flown.altitude_m);
    let (low_m, high_m) = (planned_m.min(flown.altitude_m), planned_m.max(flown.altitude_m));
    let meets = low_m <= air.altitude_m_of(ICE_K.0) && high_m >= air.altitude_m_of(ICE_K.1);
    let is_expected = || !flown.ice.is_empty() && is_forecast(mission, &air, (here, now_s), (low_m, high_m));
    let is_near = meets && !is_bound && (flown.ice.is_met_near(here) || is_expected());
    flown.ice.is_near = is_near;
    let kept = flown.ice.level_m.filter(|level_m| is_near && !air.may_ice(*level_m, REST_K));
    flown.ice.level_m = if is_near { kept.or_else(|| level_m(flown, mission, &air)) } else { None };
}

/// Returns true if a cloud is forecast here between two altitudes, in air in which ice may form.
fn is_forecast(
    mission: &Mission,
    air: &MeasuredAir,
    (here, now_s): (Position, f64),
    (low_m, high_m): (f64, f64),
) -> bool {
    let count = libm::ceil((high_m - low_m) / STEP_M) as u32;
    let mut altitudes = (0..=count).map(|step| (low_m + STEP_M * f64::from(step)).min(high_m));
    let is_cloud = |altitude_m: f64| mission.clouds.iter().any(|deck| deck.contains(here, altitude_m, now_s));
    altitudes.any(|altitude_m| air.may_ice(altitude_m, 0.0) && is_cloud(altitude_m))
}

/// Returns the altitude without ice that is reached soonest, otherwise the highest one.
fn level_m(flown: &Flown, mission: &Mission, air: &MeasuredAir) -> Option<f64> {
    let model = &mission.model;
    let ground_m = flown.altitude_m - flown.height_above_ground_m.unwrap_or(0.0);
    let clearance_m = CLEARANCE_SHARE * mission.requirements.terrain_clearance_m.unwrap_or(0.0);
    let lowest_m = ground_m + HEIGHT_M_MIN.max(clearance_m);
    let highest_m = model.ceiling_m - BELOW_CEILING_M;
    let climb_mps = model.climb().rate_m_s(flown.altitude_m).max(0.5);
    let time_s = |level_m: f64| {
        let up_m = level_m - flown.altitude_m;
        (up_m / climb_mps).max(-up_m / model.descent_rate_m_s_max)
    };
    let levels = [flown.altitude_m, air.altitude_m_of(ICE_K.1 + MARGIN_K), air.altitude_m_of(ICE_K.0 - MARGIN_K)];
    let is_open = |level_m: &f64| (lowest_m..=highest_m).contains(level_m) && !air.may_ice(*level_m, REST_K);
    let soonest = levels.into_iter().filter(is_open).min_by(|a, b| time_s(*a).total_cmp(&time_s(*b)));
    soonest.or(Some(highest_m))
}

/// Reports the ice near the flight, in flights that have met ice.
pub(super) fn report(flown: &mut Flown, mission: &Mission, commanded: &Commanded, now: Time) -> Vec<Input> {
    let ice = &mut flown.ice;
    if ice.is_empty() && !ice.is_reported {
        return Vec::new();
    }
    ice.is_reported = !ice.is_empty();
    let metres = |metres: f64| Value::measured(libm::round(metres), Dimension::LENGTH);
    let is_near = if ice.is_near { Value::symbol("t") } else { Value::nil() };
    let near = std::iter::once(("icing-near", is_near));
    let level = ice.level_m.map(|level_m| ("ice-free-altitude", metres(level_m)));
    let planned = commanded.planned_m.map(|planned_m| ("planned-altitude", metres(planned_m)));
    let sample = |(attribute, value): (&str, Value)| {
        let variable = StateVariable::new(Symbol::new(attribute), Value::Symbol(mission.agent.name.clone()));
        Input::new(now, EventKind::Measurement(variable, value))
    };
    near.chain(level).chain(planned).map(sample).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_geo::geodesy;
    use apex_model::planned::Location;

    const HERE: Position = Position::new(35.0, -118.0);

    fn mission() -> Mission {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        Mission::load(&path).unwrap_or_else(|error| panic!("{error:?}"))
    }

    fn in_ice(altitude_m: f64, celsius: f64, is_icing: bool) -> Flown {
        let mut flown = Flown::default();
        flown.measure("location", &Location { position: HERE, altitude_m }.value());
        flown.measure("height-above-ground", &Value::measured(altitude_m - 700.0, Dimension::LENGTH));
        flown.measure("outside-temperature", &Value::measured(273.15 + celsius, Dimension::TEMPERATURE));
        flown.is_icing = is_icing;
        flown
    }

    fn planned(altitude_m: f64) -> Commanded {
        let mut commanded = Commanded::default();
        commanded.planned_m.replace(altitude_m);
        commanded
    }

    #[test]
    fn the_nearest_altitude_without_ice_is_not_in_the_cloud_that_was_met() {
        let mission = mission();
        let commanded = planned(4_979.0);
        let mut flown = in_ice(5_300.0, -19.0, true);
        update(&mut flown, &mission, &commanded, 0.0);
        let level_m = flown.ice.level_m.unwrap_or_default();
        assert!((5_500.0..5_900.0).contains(&level_m), "{level_m}");
        // Above the cloud no ice forms; the level is kept, because the planned altitude leads back.
        (flown.altitude_m, flown.outside_k, flown.is_icing) = (level_m, Some(273.15 - 21.5), false);
        update(&mut flown, &mission, &commanded, 600.0);
        assert!(flown.ice.is_near);
        assert_eq!(flown.ice.level_m, Some(level_m));
        // Far from the ice, and after a long time, it does not matter.
        flown.position = Some(geodesy::destination(HERE, 90.0, 70_000.0));
        update(&mut flown, &mission, &commanded, 1_200.0);
        assert!(!flown.ice.is_near && flown.ice.level_m.is_none());
        flown.position = Some(HERE);
        update(&mut flown, &mission, &commanded, 8_000.0);
        assert!(!flown.ice.is_near);
    }

    #[test]
    fn a_climb_or_descent_through_the_cloud_leads_back_into_it() {
        let mission = mission();
        let mut flown = in_ice(3_000.0, -5.0, true);
        update(&mut flown, &mission, &Commanded::default(), 0.0);
        (flown.altitude_m, flown.outside_k, flown.is_icing) = (2_000.0, Some(273.15 + 1.5), false);
        let near = |planned_m: f64, flown: &mut Flown| {
            update(flown, &mission, &planned(planned_m), 60.0);
            flown.ice.is_near
        };
        // Above the air in which ice forms, and below it.
        assert!(near(7_000.0, &mut flown) && !near(1_900.0, &mut flown));
    }
}

//! The descent over a landing place, from an altitude to the ground. Plans, requirements and predicted landings count it by this
//! definition.

use crate::Mission;
use crate::vehicle::{Airframe, VehicleModel};
use apex_geo::travel;
use apex_geo::wind;
use apex_vehicle::density_ratio;
use std::f64::consts::PI;

/// Steps of altitude over which the drain is averaged: it changes by 2 % from one to the next.
const STEPS: u32 = 12;
/// Speed of the final approach, as a multiple of the slowest speed.
const APPROACH_SHARE: f64 = 1.3;
/// Straight flight between the turn onto the final approach and its beginning.
const LINED_UP_S: f64 = 16.0;
/// Radius of that turn, as a multiple of the tightest one, and the part of it by which the way to the turn is longer.
const TURN_WIDTH: f64 = 1.1;
const TURN_OUT: f64 = 0.6;
/// Greatest wind, as a share of the speed, in the times of a turn and of a final approach; a stronger wind counts as this share.
const WIND_SHARE_MAX: f64 = 0.9;
/// Plans take the wind at the base at least this long before the end of the mission, s.
const BEFORE_END_S: f64 = 600.0;

/// Speed of the wind over a landing place as a function of the altitude, m/s.
pub(crate) type WindSpeedAt<'a> = &'a dyn Fn(f64) -> f64;

/// Time and energy of a descent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Descent {
    /// Duration.
    pub(crate) time_s: f64,
    /// Fuel in kg, or energy from the battery in J.
    pub(crate) energy: f64,
}

impl Descent {
    /// Returns the descent from one altitude to another and the landing, through wind: at the rate of plans, or as long as the last turns
    /// and the final approach of a fixed wing take, if that is longer.
    pub(crate) fn new(model: &VehicleModel, altitudes_m: (f64, f64), wind_mps: WindSpeedAt<'_>) -> Descent {
        let descent = Descent::straight(model, altitudes_m);
        if descent.time_s <= 0.0 || model.airframe == Airframe::Rotorcraft {
            return descent;
        }
        let level_s = (circling_s(model, altitudes_m, wind_mps) - descent.time_s).max(0.0);
        let low_m = altitudes_m.1 + model.final_approach_height_m;
        let level = model.drain_per_s(model.true_airspeed_m_s_cruise, low_m, 0.0);
        Descent { time_s: descent.time_s + level_s, energy: descent.energy + level_s * level }
    }

    /// Returns the descent of a vehicle that is already lined up, at the rate of plans.
    pub(crate) fn straight(model: &VehicleModel, (from_m, to_m): (f64, f64)) -> Descent {
        let rate_mps = descent_rate_mps(model);
        let height_m = (from_m - to_m).max(0.0);
        let time_s = height_m / rate_mps;
        let middles = (0..STEPS).map(|step| to_m + height_m * (f64::from(step) + 0.5) / f64::from(STEPS));
        let drains = middles.map(|altitude_m| drain_per_s(model, altitude_m, rate_mps));
        Descent { time_s, energy: time_s * drains.sum::<f64>() / f64::from(STEPS) }
    }

    /// Returns the descent from cruise altitude to the base of the mission, in the wind that is forecast for [`BEFORE_END_S`] or the end
    /// margin before the end of the mission, whichever is earlier.
    pub(crate) fn to_base(mission: &Mission) -> Descent {
        let settings = &mission.settings;
        let before_s = settings.end_margin.seconds().max(BEFORE_END_S);
        Descent::to_base_at(mission, (settings.duration.seconds() - before_s).max(0.0))
    }

    /// Like [`Descent::to_base`], in the wind that is forecast for `at_s`.
    pub(crate) fn to_base_at(mission: &Mission, at_s: f64) -> Descent {
        let wind_mps = |altitude_m: f64| {
            let there = wind::at(&mission.forecast, mission.start, altitude_m, at_s);
            libm::hypot(there.east_mps, there.north_mps)
        };
        Descent::new(&mission.model, (mission.cruise_altitude_m(), mission.start_altitude_m), &wind_mps)
    }
}

/// Returns the time of a landing of a fixed wing that begins over the place: out to the turn, which is as wide as the wind at the first
/// altitude requires; around it onto the final approach, at the speed of the approach, and further whole circles until the approach's
/// altitude is reached at the fastest descent; then the final approach against the wind near the ground.
fn circling_s(model: &VehicleModel, (from_m, to_m): (f64, f64), wind_mps: WindSpeedAt<'_>) -> f64 {
    let (high_mps, low_mps) = (wind_mps(from_m), wind_mps(to_m + 0.5 * model.final_approach_height_m));
    let cruise_mps = model.true_airspeed_m_s_cruise;
    let approach_mps = approach_mps(model, to_m);
    let fast_mps = cruise_mps + high_mps;
    let bank_rad = (model.turns.bank_share * model.bank_deg_max).to_radians();
    let radius_m = TURN_WIDTH * travel::turn_radius_m(fast_mps, bank_rad);
    let final_m = model.final_approach_m + LINED_UP_S * fast_mps;
    let out_s = (final_m + TURN_OUT * radius_m) / cruise_mps;
    let share = (low_mps / approach_mps).min(WIND_SHARE_MAX);
    let around_s = PI * radius_m / (approach_mps * libm::sqrt(1.0 - share * share));
    let down_s = (from_m - to_m - model.final_approach_height_m).max(0.0) / model.descent_rate_m_s_max;
    let circles = libm::ceil((down_s - out_s - around_s).max(0.0) / (2.0 * around_s));
    out_s + around_s * (1.0 + 2.0 * circles) + final_m / (approach_mps * (1.0 - share))
}

/// Returns the true airspeed of the final approach of a fixed wing at an altitude.
pub(crate) fn approach_mps(model: &VehicleModel, altitude_m: f64) -> f64 {
    let true_per_indicated = 1.0 / libm::sqrt(density_ratio(altitude_m));
    (APPROACH_SHARE * model.indicated_airspeed_m_s_min * true_per_indicated).min(model.true_airspeed_m_s_cruise)
}

/// Returns the rate of descent of plans.
pub(crate) fn descent_rate_mps(model: &VehicleModel) -> f64 {
    model.descent_rate_m_s_max * model.planning.descent_share
}

/// Returns the drain in a descent: a rotorcraft may descend without forward speed.
fn drain_per_s(model: &VehicleModel, altitude_m: f64, rate_mps: f64) -> f64 {
    let forward = model.drain_per_s(model.true_airspeed_m_s_cruise, altitude_m, -rate_mps);
    match model.airframe {
        Airframe::FixedWing => forward,
        Airframe::Rotorcraft => forward.max(model.drain_per_s(0.0, altitude_m, -rate_mps)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(name: &str) -> VehicleModel {
        crate::vehicle::read(name).unwrap()
    }

    #[test]
    fn a_high_aircraft_needs_more_than_its_reserve() {
        let global_hawk = model("global-hawk");
        let descent = Descent::new(&global_hawk, (18_300.0, 700.0), &|_| 0.0);
        assert_eq!(descent.time_s, 17_600.0 / 5.0);
        assert!(descent.time_s > global_hawk.reserve_s(), "{descent:?}");
        assert_eq!(Descent::new(&global_hawk, (500.0, 700.0), &|_| 0.0), Descent::default(), "the place is higher");
    }

    #[test]
    fn the_energy_is_the_sum_over_short_steps_of_time() {
        for (name, high_m) in
            [("predator-b", 7_000.0), ("global-hawk", 18_300.0), ("quadrotor", 150.0), ("rmax", 120.0)]
        {
            let model = model(name);
            let descent = Descent::straight(&model, (high_m, 100.0));
            let rate_mps = (high_m - 100.0) / descent.time_s;
            let count = 20_000;
            let step_s = descent.time_s / f64::from(count);
            let at = |step: i32| high_m - rate_mps * step_s * (f64::from(step) + 0.5);
            let fast = |step| model.drain_per_s(model.true_airspeed_m_s_cruise, at(step), -rate_mps);
            let slow = |step| model.drain_per_s(0.0, at(step), -rate_mps);
            let hovers = model.airframe == Airframe::Rotorcraft;
            let drain = |step| if hovers && slow(step) > fast(step) { slow(step) } else { fast(step) };
            let sum: f64 = (0..count).map(|step| step_s * drain(step)).sum();
            assert!((descent.energy - sum).abs() < 0.005 * sum, "{name}: {} and {sum}", descent.energy);
        }
    }

    /// Landings of the Predator B, as the simulator flew them: altitude over the field (m), wind at this altitude and near the ground
    /// (m/s), and the time until it touched down (s).
    #[test]
    fn a_fixed_wing_needs_its_turns_and_its_final_approach() {
        let predator = model("predator-b");
        for (high_m, high_mps, low_mps, flown_s) in [
            (1_500.0, 0.0, 0.0, 510.0),
            (1_500.0, 16.5, 15.0, 688.0),
            (4_000.0, 0.0, 0.0, 900.0),
            (4_000.0, 20.0, 15.0, 710.0),
            (7_000.0, 24.8, 15.0, 1_362.0),
            (7_000.0, 32.3, 18.0, 1_572.0),
        ] {
            let wind_mps = |altitude_m: f64| if altitude_m > 1_000.0 { high_mps } else { low_mps };
            let time_s = Descent::new(&predator, (high_m, 100.0), &wind_mps).time_s;
            assert!((0.93..1.1).contains(&(time_s / flown_s)), "{high_m} m, {high_mps} m/s: {time_s} and {flown_s}");
        }
        let storm = Descent::new(&predator, (4_000.0, 100.0), &|_| 200.0).time_s;
        assert!(storm.is_finite() && storm > 3_600.0, "{storm}");
    }
}

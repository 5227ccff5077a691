//! The descent over a landing place, from an altitude to the ground. Plans, requirements and predicted landings count it by this definition.

use crate::Mission;
use crate::vehicle::{Airframe, VehicleModel};

/// Steps of altitude over which the drain is averaged: it changes by 2 % from one to the next.
const STEPS: u32 = 12;

/// Time and energy of a descent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Descent {
    /// Duration.
    pub(crate) time_s: f64,
    /// Fuel, kg, or charge of the battery, J.
    pub(crate) energy: f64,
}

impl Descent {
    /// Returns the descent at the rate of plans: the last turns and the final approach take time, too.
    pub(crate) fn new(model: &VehicleModel, from_altitude_m: f64, to_altitude_m: f64) -> Descent {
        let rate_mps = descent_rate_mps(model);
        let height_m = (from_altitude_m - to_altitude_m).max(0.0);
        let time_s = height_m / rate_mps;
        let middles = (0..STEPS).map(|step| to_altitude_m + height_m * (f64::from(step) + 0.5) / f64::from(STEPS));
        let drains = middles.map(|altitude_m| drain_per_s(model, altitude_m, rate_mps));
        Descent { time_s, energy: time_s * drains.sum::<f64>() / f64::from(STEPS) }
    }

    /// Returns the descent from cruise altitude to the base of the mission.
    pub(crate) fn to_base(mission: &Mission) -> Descent {
        Descent::new(&mission.model, mission.cruise_altitude_m(), mission.start_altitude_m)
    }
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
        let descent = Descent::new(&global_hawk, 18_300.0, 700.0);
        assert_eq!(descent.time_s, 17_600.0 / 5.0);
        assert!(descent.time_s > global_hawk.reserve_s(), "{descent:?}");
        assert_eq!(Descent::new(&global_hawk, 500.0, 700.0), Descent::default(), "the place is higher");
    }

    #[test]
    fn the_energy_is_the_sum_over_short_steps_of_time() {
        for (name, high_m) in
            [("predator-b", 7_000.0), ("global-hawk", 18_300.0), ("quadrotor", 150.0), ("rmax", 120.0)]
        {
            let model = model(name);
            let descent = Descent::new(&model, high_m, 100.0);
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
}

//! Energy of the vehicle as planners count it: fuel and flight time, for tanks and for batteries.

use crate::Mission;
use crate::descent::Descent;
use crate::situation::Situation;
use apex_vehicle::EnergyModel;

/// Energy at the instant of a planning problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlannedEnergy {
    /// Fuel on board; 0 for a battery.
    pub(crate) fuel_kg: f64,
    /// Fuel that must remain; 0 for a battery.
    pub(crate) fuel_reserve_kg: f64,
    /// Fuel burnt per second as planners assume it; 0 for a battery, which limits only the flight time.
    pub(crate) fuel_flow_kg_per_s: f64,
    /// Flight time until the store is empty.
    pub(crate) endurance_s: f64,
    /// Flight time that must remain.
    pub(crate) reserve_s: f64,
    /// Fuel for the descent over the base; 0 for a battery.
    pub(crate) landing_fuel_kg: f64,
    /// Flight time that the energy of this descent allows.
    pub(crate) landing_s: f64,
    /// Fuel that the climb to cruise altitude takes beyond level flight of the same time; 0 for a battery.
    pub(crate) climb_fuel_kg: f64,
}

/// Returns the energy of the mission's vehicle, as last reported. For a rotorcraft the greater of its drains in cruise and hover counts,
/// so that a plan may hover for any time.
pub(crate) fn energy(mission: &Mission, situation: &Situation) -> PlannedEnergy {
    let (model, vehicle) = (&mission.model, &situation.vehicle);
    let drain = model.drain_planned_per_s(mission.cruise_altitude_m());
    let reserve = reserve_share(mission) * model.reserve();
    let reserve_s = reserve / drain;
    let landing = Descent::to_base(mission).energy;
    let landing_s = landing / drain;
    match &model.energy {
        EnergyModel::Fuel(fuel) => {
            let fuel_kg = vehicle.fuel_kg.unwrap_or(fuel.capacity_kg);
            let from_m = vehicle.altitude_m.max(mission.start_altitude_m);
            PlannedEnergy {
                climb_fuel_kg: climb_kg(mission, from_m),
                fuel_kg,
                fuel_reserve_kg: reserve,
                fuel_flow_kg_per_s: drain,
                endurance_s: fuel_kg / drain,
                reserve_s,
                landing_fuel_kg: landing,
                landing_s,
            }
        }
        EnergyModel::Battery(battery) => PlannedEnergy {
            fuel_kg: 0.0,
            fuel_reserve_kg: 0.0,
            fuel_flow_kg_per_s: 0.0,
            endurance_s: vehicle.battery_charge.unwrap_or(1.0) * battery.full_j() / drain,
            reserve_s,
            landing_fuel_kg: 0.0,
            landing_s,
            climb_fuel_kg: 0.0,
        },
    }
}

/// Returns the fuel of a climb to cruise altitude beyond that of level flight, at the rate and speed of plans.
fn climb_kg(mission: &Mission, from_m: f64) -> f64 {
    let (model, to_m) = (&mission.model, mission.cruise_altitude_m());
    let rate_mps = model.climb_rate_m_s_max * model.planning.climb_share;
    let height_m = (to_m - from_m).max(0.0);
    let above_level = |step: u32| {
        let altitude_m = from_m + height_m * (f64::from(step) + 0.5) / f64::from(CLIMB_STEPS);
        let at = |vertical_mps: f64| model.drain_per_s(model.true_airspeed_m_s_cruise, altitude_m, vertical_mps);
        at(rate_mps) - at(0.0)
    };
    let mean = (0..CLIMB_STEPS).map(above_level).sum::<f64>() / f64::from(CLIMB_STEPS);
    mean * height_m / rate_mps
}

/// Steps of altitude over which the drain of a climb is averaged.
const CLIMB_STEPS: u32 = 12;

/// Returns the reserve that the mission requires, as a multiple of the vehicle's own: plans keep the greater one, so that a flight as
/// planned raises no alarm.
fn reserve_share(mission: &Mission) -> f64 {
    let stated_s = mission.requirements.energy_reserve_s.unwrap_or(0.0);
    (stated_s / mission.model.reserve_s()).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.6 of the level flow at the fastest climb, whatever the rate: the penalty is proportional to it.
    #[test]
    fn plans_keep_fuel_for_the_climb() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        let mut mission = Mission::load(&folder).unwrap();
        let low = energy(&mission, &Situation::default()).climb_fuel_kg;
        let EnergyModel::Fuel(fuel) = &mut mission.model.energy else { panic!("no tank") };
        assert_eq!(fuel.climb_penalty, 0.6);
        (fuel.low_altitude_penalty, fuel.climb_penalty) = (0.0, 1.2);
        let height_m = mission.cruise_altitude_m() - mission.start_altitude_m;
        let level = mission.model.drain_per_s(mission.model.true_airspeed_m_s_cruise, 0.0, 0.0);
        let expected_kg = 1.2 * level * height_m / mission.model.climb_rate_m_s_max;
        let found_kg = energy(&mission, &Situation::default()).climb_fuel_kg;
        assert!((found_kg / expected_kg - 1.0).abs() < 1e-9, "{found_kg} instead of {expected_kg} kg");
        assert!((0.4 * found_kg..found_kg).contains(&low), "{low} kg with half of the penalty");
        let mut situation = Situation::default();
        situation.vehicle.altitude_m = mission.cruise_altitude_m();
        assert_eq!(energy(&mission, &situation).climb_fuel_kg, 0.0);
    }

    #[test]
    fn plans_keep_the_greater_of_the_reserves_of_vehicle_and_mission() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/western-states");
        let mut mission = Mission::load(&folder).unwrap();
        let own = energy(&mission, &Situation::default());
        mission.requirements.energy_reserve_s = Some(2.0 * mission.model.reserve_s());
        let stated = energy(&mission, &Situation::default());
        assert_eq!(stated.fuel_reserve_kg, 2.0 * own.fuel_reserve_kg);
        assert_eq!(stated.reserve_s, 2.0 * own.reserve_s);
        mission.requirements.energy_reserve_s = Some(60.0);
        assert_eq!(energy(&mission, &Situation::default()), own);
        mission.requirements.energy_reserve_s = None;
        assert_eq!(energy(&mission, &Situation::default()), own);
    }
}

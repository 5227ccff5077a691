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
            PlannedEnergy {
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
        },
    }
}

/// Returns the reserve that the mission requires, as a multiple of the vehicle's own: plans keep the greater one, so that a flight as
/// planned raises no alarm.
fn reserve_share(mission: &Mission) -> f64 {
    let stated_s = mission.requirements.energy_reserve_s.unwrap_or(0.0);
    (stated_s / mission.model.reserve_s()).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

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

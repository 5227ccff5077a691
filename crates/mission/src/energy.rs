//! Energy of the vehicle as planners count it: fuel and flight time, for tanks and for batteries.

use crate::Mission;
use crate::situation::Situation;
use apex_vehicle::EnergyModel;

/// Energy at the instant of a planning problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlannedEnergy {
    /// Fuel on board; 0 for a battery.
    pub(crate) fuel_kg: f64,
    /// Fuel that must remain; 0 for a battery.
    pub(crate) fuel_reserve_kg: f64,
    /// Fuel burnt per second that plans count on; 0 for a battery, which limits the flight time alone.
    pub(crate) fuel_flow_kg_per_s: f64,
    /// Flight time until the store is empty.
    pub(crate) endurance_s: f64,
    /// Flight time that must remain.
    pub(crate) reserve_s: f64,
}

/// Energy of the mission's vehicle, as last reported. A rotorcraft is counted with the greater of its drains in cruise and
/// hover, so that a plan may hover for as long as it likes.
pub(crate) fn energy(mission: &Mission, situation: &Situation) -> PlannedEnergy {
    let (model, vehicle) = (&mission.model, &situation.vehicle);
    let drain = model.drain_planned_per_s(mission.cruise_altitude_m());
    let reserve_s = model.reserve() / drain;
    match &model.energy {
        EnergyModel::Fuel(fuel) => {
            let fuel_kg = vehicle.fuel_kg.unwrap_or(fuel.capacity_kg);
            PlannedEnergy {
                fuel_kg,
                fuel_reserve_kg: model.reserve(),
                fuel_flow_kg_per_s: drain,
                endurance_s: fuel_kg / drain,
                reserve_s,
            }
        }
        EnergyModel::Battery(battery) => PlannedEnergy {
            fuel_kg: 0.0,
            fuel_reserve_kg: 0.0,
            fuel_flow_kg_per_s: 0.0,
            endurance_s: vehicle.battery_charge.unwrap_or(1.0) * battery.full_j() / drain,
            reserve_s,
        },
    }
}

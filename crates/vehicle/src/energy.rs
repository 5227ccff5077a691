//! Energy on board and the rate at which flight consumes it: fuel in kilograms, batteries in joules.
//!
//! `stored` is in kilograms of fuel or joules of charge, `drain` in kilograms or joules per second. Callers that only compare and divide
//! do not need to distinguish the two.

use crate::model::{Airframe, VehicleModel};
use libm::{pow, sqrt};
use serde::{Deserialize, Serialize};

/// Standard acceleration of gravity.
const GRAVITY_M_S2: f64 = 9.806_65;
/// Density of the International Standard Atmosphere at sea level.
const SEA_LEVEL_KG_M3: f64 = 1.225;
/// Joules of a watt hour.
pub const JOULES_PER_WH: f64 = 3_600.0;
/// Fuel flow of a parked vehicle with its engine running, as a share of the reference flow.
const IDLE_SHARE: f64 = 0.2;
/// Least drain in a descent, as a share of the reference flow or of the power of level flight.
const LEAST_SHARE: f64 = 0.1;
/// Energy counts as low this share of the capacity above the reserve.
const LOW_MARGIN_SHARE: f64 = 0.05;

/// Source of energy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EnergyModel {
    /// A tank.
    Fuel(FuelModel),
    /// A battery.
    Battery(BatteryModel),
}

/// Fuel capacity and consumption.
///
/// `flow = reference * (share[0] + share[1] x + share[2] x^3) * altitude factor * climb factor` with `x` the true
/// airspeed over `speed_m_s_reference`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FuelModel {
    /// Usable fuel when full.
    pub capacity_kg: f64,
    /// Fuel flow in level flight at the reference speed and altitude, if the shares sum to one.
    pub flow_kg_h_reference: f64,
    /// Reference speed, at which `x` is one.
    pub speed_m_s_reference: f64,
    /// Constant, linear and cubic share of the flow.
    pub share: [f64; 3],
    /// Reference altitude, at which the altitude factor is one.
    pub altitude_m_reference: f64,
    /// Additional share of the flow at sea level, compared with the reference altitude.
    pub low_altitude_penalty: f64,
    /// Additional share of the flow in the fastest climb.
    pub climb_penalty: f64,
    /// Share of the flow that the fastest descent saves.
    pub descent_saving: f64,
}

/// A battery, and the power that flight draws from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatteryModel {
    /// Energy of the new, full battery at 20 degrees Celsius.
    pub capacity_wh: f64,
    /// Share of the capacity that age has left (state of health).
    pub health_share: f64,
    /// Share of the drained energy that reaches the motors.
    pub discharge_efficiency: f64,
    /// Outside temperatures, rising, degrees Celsius.
    pub temperature_c: Vec<f64>,
    /// Usable share of the capacity at each of these temperatures: linear between them, constant beyond the first and the last.
    pub temperature_share: Vec<f64>,
    /// Power of avionics and sensors.
    pub avionics_w: f64,
    /// Share of the power in a climb that lifts the vehicle.
    pub climb_efficiency: f64,
    /// Share of the potential energy lost in a descent that reduces the power.
    pub descent_saving: f64,
    /// Power of level flight.
    pub power: FlightPower,
}

/// Power of level flight at sea level as a function of the true airspeed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FlightPower {
    /// Rotors; power of Zeng, Xu and Zhang, "Energy minimization for wireless communication with rotary-wing UAV", IEEE
    /// Transactions on Wireless Communications 18 (2019), equation (6):
    /// `blade (1 + 3 V^2/U^2) + induced sqrt(sqrt(1 + V^4/(4 v^4)) - V^2/(2 v^2)) + parasite V^3`.
    Rotor {
        /// Blade profile power in hover.
        blade_w: f64,
        /// Induced power in hover.
        induced_w: f64,
        /// U: speed of the blade tips.
        tip_speed_m_s: f64,
        /// v: induced velocity of the air in hover.
        induced_speed_m_s: f64,
        /// Power per cube of the airspeed that the fuselage takes, W s3/m3.
        parasite_w_s3_m3: f64,
    },
    /// Wings with a parabolic drag polar: `power (parasite x^3 + (1 - parasite) / x)`, `x` the equivalent airspeed over the
    /// reference.
    Wing {
        /// Power at the reference speed at sea level.
        power_w_reference: f64,
        /// Reference speed.
        speed_m_s_reference: f64,
        /// Share of the power at the reference speed that grows with the cube of speed.
        parasite_share: f64,
    },
}

/// Energy that must remain when the flight ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reserve {
    /// Minutes of level flight at cruise speed and cruise altitude.
    Minutes(f64),
    /// Share of the capacity.
    Share(f64),
}

/// Endurance that the sources state, full to empty, against which the energy figures are checked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatedEndurance {
    /// At cruise speed and cruise altitude.
    pub cruise_min: f64,
    /// In hover at sea level; `None` for a fixed wing.
    pub hover_min: Option<f64>,
}

/// Returns the density over that of sea level in the International Standard Atmosphere, up to 20 km.
pub fn density_ratio(altitude_m: f64) -> f64 {
    const TROPOPAUSE_M: f64 = 11_000.0;
    let ratio = |altitude_m: f64| pow((1.0 - 2.255_77e-5 * altitude_m).max(0.1), 4.255_88);
    if altitude_m <= TROPOPAUSE_M {
        return ratio(altitude_m);
    }
    ratio(TROPOPAUSE_M) * libm::exp((TROPOPAUSE_M - altitude_m) / 6_341.6)
}

/// Returns the temperature of the International Standard Atmosphere, degrees Celsius.
pub fn standard_temperature_c(altitude_m: f64) -> f64 {
    15.0 - 0.006_5 * altitude_m.min(11_000.0)
}

impl FlightPower {
    /// Returns the power of level flight, W, in air of `ratio` times the density at sea level.
    fn level_w(&self, true_airspeed_m_s: f64, ratio: f64) -> f64 {
        let speed = true_airspeed_m_s;
        match self {
            FlightPower::Rotor { blade_w, induced_w, tip_speed_m_s, induced_speed_m_s, parasite_w_s3_m3 } => {
                // Momentum theory: the induced velocity and power of a given thrust grow as one over the root of density.
                let thin = 1.0 / sqrt(ratio);
                let induced = induced_speed_m_s * thin;
                let slip = speed * speed / (2.0 * induced * induced);
                let carried = sqrt((sqrt(1.0 + slip * slip) - slip).max(0.0));
                let tip = speed / tip_speed_m_s;
                blade_w * ratio * (1.0 + 3.0 * tip * tip)
                    + induced_w * thin * carried
                    + parasite_w_s3_m3 * ratio * speed * speed * speed
            }
            FlightPower::Wing { power_w_reference, speed_m_s_reference, parasite_share } => {
                let x = speed * sqrt(ratio) / speed_m_s_reference;
                // Below a quarter of the reference speed no wing flies; the bound keeps the ground roll finite.
                let x = x.max(0.25);
                power_w_reference / sqrt(ratio) * (parasite_share * x * x * x + (1.0 - parasite_share) / x)
            }
        }
    }
}

impl BatteryModel {
    /// Returns the energy of the full battery at its age, J.
    pub fn full_j(&self) -> f64 {
        self.capacity_wh * self.health_share * JOULES_PER_WH
    }

    /// Returns the usable share of the capacity at an outside temperature.
    pub fn usable_share(&self, temperature_c: f64) -> f64 {
        let points = || self.temperature_c.iter().copied().zip(self.temperature_share.iter().copied());
        let below = points().rfind(|(at, _)| *at <= temperature_c);
        let above = points().find(|(at, _)| *at > temperature_c);
        match (below, above) {
            (Some((low, share)), Some((high, other))) => share + (other - share) * (temperature_c - low) / (high - low),
            (Some((_, share)), None) | (None, Some((_, share))) => share,
            (None, None) => 1.0,
        }
    }
}

impl VehicleModel {
    /// Returns the energy of the full tank or battery: kg or J.
    pub fn stored_full(&self) -> f64 {
        match &self.energy {
            EnergyModel::Fuel(fuel) => fuel.capacity_kg,
            EnergyModel::Battery(battery) => battery.full_j(),
        }
    }

    /// Returns the part of `stored` that can be drained at an outside temperature: kg or J. Cold makes a share of a battery unusable.
    pub fn available(&self, stored: f64, temperature_c: f64) -> f64 {
        match &self.energy {
            EnergyModel::Fuel(_) => stored,
            EnergyModel::Battery(battery) => {
                let locked = (1.0 - battery.usable_share(temperature_c)) * battery.full_j();
                (stored - locked).max(0.0)
            }
        }
    }

    /// Returns the drain in flight: kg/s or W, never negative.
    pub fn drain_per_s(&self, true_airspeed_m_s: f64, altitude_m: f64, vertical_speed_m_s: f64) -> f64 {
        match &self.energy {
            EnergyModel::Fuel(fuel) => self.fuel_flow_kg_s(fuel, true_airspeed_m_s, altitude_m, vertical_speed_m_s),
            EnergyModel::Battery(battery) => {
                let level_w = battery.power.level_w(true_airspeed_m_s, density_ratio(altitude_m));
                let lift_w = self.mass_kg * GRAVITY_M_S2 * vertical_speed_m_s;
                let share = if lift_w >= 0.0 { 1.0 / battery.climb_efficiency } else { battery.descent_saving };
                let flight_w = (level_w + lift_w * share).max(LEAST_SHARE * level_w);
                (flight_w + battery.avionics_w) / battery.discharge_efficiency
            }
        }
    }

    fn fuel_flow_kg_s(
        &self,
        fuel: &FuelModel,
        true_airspeed_m_s: f64,
        altitude_m: f64,
        vertical_speed_m_s: f64,
    ) -> f64 {
        let reference = fuel.flow_kg_h_reference / 3600.0;
        let x = true_airspeed_m_s / fuel.speed_m_s_reference;
        let [constant, linear, cubic] = fuel.share;
        let height = (1.0 - altitude_m / fuel.altitude_m_reference).max(-0.5);
        let climb = if vertical_speed_m_s >= 0.0 {
            1.0 + fuel.climb_penalty * vertical_speed_m_s / self.climb_rate_m_s_max
        } else {
            1.0 + fuel.descent_saving * vertical_speed_m_s / self.descent_rate_m_s_max
        };
        let flow = reference * (constant + linear * x + cubic * x * x * x) * (1.0 + fuel.low_altitude_penalty * height);
        (flow * climb).max(LEAST_SHARE * reference)
    }

    /// Returns the drain of the vehicle on the ground with its engine running: kg/s or W.
    pub fn drain_idle_per_s(&self) -> f64 {
        match &self.energy {
            EnergyModel::Fuel(fuel) => IDLE_SHARE * fuel.flow_kg_h_reference / 3600.0,
            EnergyModel::Battery(battery) => battery.avionics_w / battery.discharge_efficiency,
        }
    }

    /// Returns the drain in level flight at cruise speed and cruise altitude above ground at sea level: kg/s or W.
    pub fn drain_cruise_per_s(&self) -> f64 {
        self.drain_per_s(self.true_airspeed_m_s_cruise, self.planning.cruise.altitude_m(0.0), 0.0)
    }

    /// Returns the drain that plans count on: the greater of cruise and, for a rotorcraft, hover at the altitude `altitude_m`.
    pub fn drain_planned_per_s(&self, altitude_m: f64) -> f64 {
        let cruise = self.drain_per_s(self.true_airspeed_m_s_cruise, altitude_m, 0.0);
        match self.airframe {
            Airframe::FixedWing => cruise,
            Airframe::Rotorcraft => cruise.max(self.drain_per_s(0.0, altitude_m, 0.0)),
        }
    }

    /// Returns the energy that must remain when the flight ends: kg or J.
    pub fn reserve(&self) -> f64 {
        match self.reserve {
            Reserve::Minutes(minutes) => minutes * 60.0 * self.drain_cruise_per_s(),
            Reserve::Share(share) => share * self.stored_full(),
        }
    }

    /// Returns the flight time at cruise that the reserve represents, s.
    pub fn reserve_s(&self) -> f64 {
        self.reserve() / self.drain_cruise_per_s()
    }

    /// Returns the energy below which `(watch the fuel)` reports low energy: the reserve and five hundredths of the capacity, kg or J.
    pub fn low(&self) -> f64 {
        self.reserve() + LOW_MARGIN_SHARE * self.stored_full()
    }

    /// Returns the time from full to empty at cruise, s.
    pub fn endurance_cruise_s(&self) -> f64 {
        self.stored_full() / self.drain_cruise_per_s()
    }

    /// Returns the time from full to empty in hover at sea level, s; `None` for a fixed wing.
    pub fn endurance_hover_s(&self) -> Option<f64> {
        (self.airframe == Airframe::Rotorcraft).then(|| self.stored_full() / self.drain_per_s(0.0, 0.0, 0.0))
    }
}

/// Returns the hover power of momentum theory, W: `(m g)^1.5 / sqrt(2 rho A)` at sea level over the figure of merit.
pub fn ideal_hover_w(mass_kg: f64, disc_m2: f64) -> f64 {
    let weight = mass_kg * GRAVITY_M_S2;
    weight * sqrt(weight) / sqrt(2.0 * SEA_LEVEL_KG_M3 * disc_m2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parameters and results of Zeng, Xu and Zhang 2019, section V.
    #[test]
    fn rotor_power_is_that_of_the_article() {
        let power = FlightPower::Rotor {
            blade_w: 79.86,
            induced_w: 88.63,
            tip_speed_m_s: 120.0,
            induced_speed_m_s: 4.03,
            parasite_w_s3_m3: 0.5 * 0.6 * 1.225 * 0.05 * 0.503,
        };
        for (speed, watt) in [(0.0, 168.49), (10.0, 126.03), (15.0, 138.55), (20.0, 178.30)] {
            assert!((power.level_w(speed, 1.0) - watt).abs() < 0.01, "{speed}: {}", power.level_w(speed, 1.0));
        }
        let least = (0..4_000)
            .map(|step| f64::from(step) * 0.01)
            .min_by(|a, b| power.level_w(*a, 1.0).total_cmp(&power.level_w(*b, 1.0)));
        assert!((least.unwrap_or_default() - 10.21).abs() < 0.02, "{least:?}");
    }

    /// A quadrotor of 6.3 kg with four rotors of 0.533 m: 328 W by momentum theory.
    #[test]
    fn hover_power_is_that_of_momentum_theory() {
        let disc_m2 = 4.0 * std::f64::consts::PI * 0.266_7 * 0.266_7;
        assert!((ideal_hover_w(6.3, disc_m2) - 328.0).abs() < 1.0, "{}", ideal_hover_w(6.3, disc_m2));
    }

    /// Densities of the standard atmosphere (ISO 2533): 0.909, 0.590 and 0.1937 kg/m3 at 3, 7 and 15 km.
    #[test]
    fn density_is_that_of_the_standard_atmosphere() {
        for (altitude_m, density) in [(0.0, 1.225), (3_000.0, 0.9093), (7_000.0, 0.5900), (15_000.0, 0.1937)] {
            let found = SEA_LEVEL_KG_M3 * density_ratio(altitude_m);
            assert!((found / density - 1.0).abs() < 0.005, "{altitude_m}: {found}");
        }
    }
}

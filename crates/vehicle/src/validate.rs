//! Rules for the figures of a vehicle model: limits on each figure, and limits between figures.

use crate::energy::{BatteryModel, EnergyModel, FlightPower, FuelModel, Reserve};
use crate::error::{FileName, VehicleFileError};
use crate::model::{Airframe, CruiseLevel, VehicleModel};
use crate::rules::{Checker, Rule};
use crate::sensor::Optics;

/// Slowest indicated airspeed at which a fixed wing can stay in the air.
const FIXED_WING_M_S_MIN: f64 = 5.0;
/// Figures above these are taken for mistakes in units, because no aircraft reaches them.
const MASS_KG_MAX: f64 = 1e6;
const SPEED_M_S_MAX: f64 = 1_000.0;
const CLIMB_M_S_MAX: f64 = 300.0;
const CEILING_M_MAX: f64 = 50_000.0;
const ACCELERATION_M_S2_MAX: f64 = 100.0;
const RATE_DEG_S_MAX: f64 = 1_000.0;
/// Somewhat more than the 25 nautical miles of a localizer's range (ICAO Annex 10, volume I, 3.1.3.3).
const FINAL_APPROACH_M_MAX: f64 = 50_000.0;
/// Greatest height of a final approach as a share of its length: a glide path of 26 degrees.
const APPROACH_SLOPE_MAX: f64 = 0.5;
/// A range shorter than this is taken for a mistake in units.
const RANGE_M_MIN: f64 = 1_000.0;
/// Shortest and longest time between two reports of a vehicle: requirements are checked at each of them.
const REPORT_S_MIN: f64 = 0.01;
const REPORT_S_MAX: f64 = 600.0;
/// Greatest permitted relative difference between the endurance from the energy figures and the stated endurance.
const ENDURANCE_DEVIATION_MAX: f64 = 0.15;

impl VehicleModel {
    /// Checks that the figures describe a vehicle that can fly; `file` names the file in errors.
    ///
    /// # Errors
    /// The first figure that breaks a rule, with the rule.
    pub fn validate(&self, file: &str) -> Result<(), VehicleFileError> {
        let check = Checker { file: FileName::vehicle(file) };
        self.check_flight(&check)?;
        self.check_planning(&check)?;
        self.check_energy(&check)?;
        let report = &self.report;
        let intervals = [
            ("scanning_s", report.scanning_s, Rule::Between(REPORT_S_MIN, REPORT_S_MAX)),
            ("manoeuvring_s", report.manoeuvring_s, Rule::Between(REPORT_S_MIN, REPORT_S_MAX)),
            ("cruise_s", report.cruise_s, Rule::Between(REPORT_S_MIN, REPORT_S_MAX)),
        ];
        check.each("report", &intervals)?;
        self.check_sensors(&check)
    }

    fn check_flight(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let fixed_wing = self.airframe == Airframe::FixedWing;
        let if_fixed_wing = |rule: Rule| if fixed_wing { rule } else { Rule::Between(0.0, 0.0) };
        let if_rotorcraft = |rule: Rule| if fixed_wing { Rule::Between(0.0, 0.0) } else { rule };
        let slowest = if_fixed_wing(Rule::Between(FIXED_WING_M_S_MIN, 500.0));
        let figures = [
            ("mass_kg", self.mass_kg, Rule::AboveUpTo(0.0, MASS_KG_MAX)),
            ("indicated_airspeed_m_s_stall", self.indicated_airspeed_m_s_stall, if_fixed_wing(Rule::Positive)),
            ("indicated_airspeed_m_s_min", self.indicated_airspeed_m_s_min, slowest),
            ("true_airspeed_m_s_cruise", self.true_airspeed_m_s_cruise, Rule::AboveUpTo(0.0, SPEED_M_S_MAX)),
            ("true_airspeed_m_s_max", self.true_airspeed_m_s_max, Rule::AboveUpTo(0.0, SPEED_M_S_MAX)),
            ("acceleration_m_s2_max", self.acceleration_m_s2_max, Rule::AboveUpTo(0.0, ACCELERATION_M_S2_MAX)),
            ("bank_deg_max", self.bank_deg_max, Rule::AboveUpTo(0.0, 60.0)),
            ("level_roll_deg_max", self.level_roll_deg_max, Rule::AboveUpTo(0.0, 45.0)),
            ("roll_rate_deg_s_max", self.roll_rate_deg_s_max, Rule::AboveUpTo(0.0, RATE_DEG_S_MAX)),
            ("yaw_rate_deg_s_max", self.yaw_rate_deg_s_max, Rule::AboveUpTo(0.0, RATE_DEG_S_MAX)),
            ("climb_rate_m_s_max", self.climb_rate_m_s_max, Rule::AboveUpTo(0.0, CLIMB_M_S_MAX)),
            ("descent_rate_m_s_max", self.descent_rate_m_s_max, Rule::AboveUpTo(0.0, CLIMB_M_S_MAX)),
            ("ceiling_m", self.ceiling_m, Rule::AboveUpTo(0.0, CEILING_M_MAX)),
            ("wind_m_s_max", self.wind_m_s_max, Rule::AboveUpTo(0.0, SPEED_M_S_MAX)),
            ("glide_ratio", self.glide_ratio, Rule::Between(0.0, 60.0)),
            ("final_approach_m", self.final_approach_m, if_fixed_wing(Rule::AboveUpTo(0.0, FINAL_APPROACH_M_MAX))),
            ("final_approach_height_m", self.final_approach_height_m, if_fixed_wing(Rule::Positive)),
            ("braking_share", self.braking_share, if_rotorcraft(Rule::AboveUpTo(0.0, 1.0))),
            ("drag_per_s", self.drag_per_s, if_rotorcraft(Rule::NotNegative)),
        ];
        check.each("flight", &figures)?;
        if fixed_wing {
            check.below(
                "flight.indicated_airspeed_m_s_stall",
                self.indicated_airspeed_m_s_stall,
                self.indicated_airspeed_m_s_min,
                "flight.indicated_airspeed_m_s_min",
            )?;
        }
        if fixed_wing {
            check.at_most(
                "flight.final_approach_height_m",
                self.final_approach_height_m,
                APPROACH_SLOPE_MAX * self.final_approach_m,
                "half of flight.final_approach_m",
            )?;
        }
        // A true airspeed is never below the indicated airspeed, so a cruise speed below the stall speed means a stall at every altitude.
        check.at_most(
            "flight.indicated_airspeed_m_s_min",
            self.indicated_airspeed_m_s_min,
            self.true_airspeed_m_s_cruise,
            "flight.true_airspeed_m_s_cruise",
        )?;
        check.at_most(
            "flight.true_airspeed_m_s_cruise",
            self.true_airspeed_m_s_cruise,
            self.true_airspeed_m_s_max,
            "flight.true_airspeed_m_s_max",
        )
    }

    fn check_energy(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let capacity = match &self.energy {
            EnergyModel::Fuel(fuel) => {
                self.check_fuel(check, fuel)?;
                "fuel.capacity_kg"
            }
            EnergyModel::Battery(battery) => {
                check_battery(check, battery)?;
                "battery.capacity_wh"
            }
        };
        let range_m = self.endurance_cruise_s() * self.true_airspeed_m_s_cruise;
        if range_m < RANGE_M_MIN {
            let expected = format!("energy for at least {RANGE_M_MIN} m of cruise");
            let help = "correct the capacity or the consumption; a flow is in kg per hour, a power in W";
            return Err(check.file.error(capacity, expected, format!("energy for {range_m:.0} m"), help));
        }
        let figures = match self.reserve {
            Reserve::Minutes(minutes) => ("duration_min", minutes, Rule::NotNegative),
            Reserve::Share(share) => ("share", share, Rule::Between(0.0, 0.9)),
        };
        check.each("reserve", &[figures])?;
        if self.low() >= self.stored_full() {
            let share = self.reserve() / self.stored_full() * 100.0;
            let found = format!("{share:.0} % of the capacity");
            let help = "shorten the reserve, or correct the capacity";
            return Err(check.file.error(
                format!("reserve.{}", figures.0),
                "less than 95 % of the capacity",
                found,
                help,
            ));
        }
        let stated = &self.endurance;
        check.each("endurance", &[("cruise_min", stated.cruise_min, Rule::Positive)])?;
        check_stated(check, "cruise_min", stated.cruise_min, self.endurance_cruise_s() / 60.0)?;
        let Some((hover_min, found_s)) = stated.hover_min.zip(self.endurance_hover_s()) else { return Ok(()) };
        check.each("endurance", &[("hover_min", hover_min, Rule::Positive)])?;
        check_stated(check, "hover_min", hover_min, found_s / 60.0)
    }

    fn check_fuel(&self, check: &Checker<'_>, fuel: &FuelModel) -> Result<(), VehicleFileError> {
        let [constant, linear, cubic] = fuel.share;
        let figures = [
            ("capacity_kg", fuel.capacity_kg, Rule::Positive),
            ("flow_kg_h_reference", fuel.flow_kg_h_reference, Rule::Positive),
            ("speed_m_s_reference", fuel.speed_m_s_reference, Rule::Positive),
            ("share[0]", constant, Rule::Finite),
            ("share[1]", linear, Rule::Finite),
            ("share[2]", cubic, Rule::Finite),
            ("altitude_m_reference", fuel.altitude_m_reference, Rule::Positive),
            ("low_altitude_penalty", fuel.low_altitude_penalty, Rule::NotNegative),
            ("climb_penalty", fuel.climb_penalty, Rule::NotNegative),
            ("descent_saving", fuel.descent_saving, Rule::Between(0.0, 1.0)),
        ];
        check.each("fuel", &figures)?;
        for speed in [self.true_airspeed_m_s_cruise, self.true_airspeed_m_s_max] {
            let x = speed / fuel.speed_m_s_reference;
            let flow = constant + linear * x + cubic * x * x * x;
            if flow <= 0.0 {
                let found = format!("{flow} at {speed} m/s");
                let expected = "shares whose flow is greater than zero from cruise to maximum speed";
                return Err(check.file.error("fuel.share", expected, found, "correct the shares of the flow"));
            }
        }
        Ok(())
    }

    fn check_sensors(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let mut scanners = 0;
        for (number, sensor) in self.sensors.iter().enumerate() {
            if self.sensors.iter().take(number).any(|other| other.name == sensor.name) {
                let found = format!("`{}` again", sensor.name);
                let path = format!("sensors[{number}].name");
                return Err(check.file.error(path, "a unique name", found, "rename the sensor"));
            }
            if !matches!(sensor.model.optics, Optics::LineScanner { .. }) {
                continue;
            }
            scanners += 1;
            if scanners > 1 {
                let path = format!("sensors[{number}].sensor");
                let help = "carry one line scanner; its modes are described in its file";
                return Err(check.file.error(path, "one line scanner at most", "a second one", help));
            }
            let limit = sensor.model.motion.roll_deg_valid;
            let name = format!("motion.roll_deg_valid` of `{}", sensor.reference);
            check.at_most("flight.level_roll_deg_max", self.level_roll_deg_max, limit, &name)?;
        }
        Ok(())
    }

    fn check_planning(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let turns = [
            ("bank_share", self.turns.bank_share, Rule::AboveUpTo(0.0, 1.0)),
            ("circle_width", self.turns.circle_width, Rule::Between(1.0, 10.0)),
        ];
        check.each("turns", &turns)?;
        let hold = [
            ("roll_deg_per_edr", self.attitude_hold.roll_deg_per_edr, Rule::Between(0.0, 100.0)),
            ("natural_frequency_rad_s", self.attitude_hold.natural_frequency_rad_s, Rule::AboveUpTo(0.0, 100.0)),
            ("damping_ratio", self.attitude_hold.damping_ratio, Rule::Between(0.05, 5.0)),
        ];
        check.each("attitude_hold", &hold)?;
        let planning = &self.planning;
        let cruise = match planning.cruise {
            CruiseLevel::Altitude(altitude_m) => ("cruise_altitude_m", altitude_m, Rule::Positive),
            CruiseLevel::Height(height_m) => ("cruise_height_m", height_m, Rule::Positive),
        };
        let figures = [
            cruise,
            ("climb_share", planning.climb_share, Rule::AboveUpTo(0.0, 1.0)),
            ("descent_share", planning.descent_share, Rule::AboveUpTo(0.0, 1.0)),
            ("ceiling_share", planning.ceiling_share, Rule::AboveUpTo(0.0, 1.0)),
            ("visit_height_m", planning.visit_height_m, Rule::Positive),
        ];
        check.each("planning", &figures)?;
        check.at_most(&format!("planning.{}", cruise.0), cruise.1, self.ceiling_m, "flight.ceiling_m")?;
        check.at_most("planning.visit_height_m", planning.visit_height_m, self.ceiling_m, "flight.ceiling_m")?;
        // The indicated airspeed of a cruise at this true airspeed falls with the density of the air.
        let cruise_mps = self.true_airspeed_m_s_cruise;
        let slowest_mps = self.true_airspeed_m_s_min(cruise.1);
        if cruise_mps >= slowest_mps {
            return Ok(());
        }
        let expected = format!(
            "at least {slowest_mps:.1}, the true airspeed of `flight.indicated_airspeed_m_s_min` at `planning.{}`",
            cruise.0
        );
        let help = "raise the cruise speed, or lower the altitude or the slowest speed";
        Err(check.file.error("flight.true_airspeed_m_s_cruise".to_owned(), expected, cruise_mps.to_string(), help))
    }
}

fn check_battery(check: &Checker<'_>, battery: &BatteryModel) -> Result<(), VehicleFileError> {
    let figures = [
        ("capacity_wh", battery.capacity_wh, Rule::Positive),
        ("health_share", battery.health_share, Rule::AboveUpTo(0.0, 1.0)),
        ("discharge_efficiency", battery.discharge_efficiency, Rule::AboveUpTo(0.0, 1.0)),
        ("avionics_w", battery.avionics_w, Rule::Positive),
        ("climb_efficiency", battery.climb_efficiency, Rule::AboveUpTo(0.0, 1.0)),
        ("descent_saving", battery.descent_saving, Rule::Between(0.0, 1.0)),
    ];
    check.each("battery", &figures)?;
    let (at, share) = (&battery.temperature_c, &battery.temperature_share);
    let rising = at.iter().zip(at.iter().skip(1)).all(|(low, high)| low < high);
    if at.is_empty() || !rising || !at.iter().all(|degrees| degrees.is_finite()) {
        let expected = "one or more temperatures, each greater than the one before";
        let help = "list the temperatures in rising order";
        return Err(check.file.error("battery.temperature_c", expected, format!("{at:?}"), help));
    }
    if share.len() != at.len() || !share.iter().all(|share| *share > 0.0 && *share <= 1.0) {
        let expected = format!("{} shares greater than 0 and at most 1", at.len());
        let help = "give one share for each of `temperature_c`";
        return Err(check.file.error("battery.temperature_share", expected, format!("{share:?}"), help));
    }
    match battery.power {
        FlightPower::Rotor { blade_w, induced_w, tip_speed_m_s, induced_speed_m_s, parasite_w_s3_m3 } => {
            let figures = [
                ("blade_w", blade_w, Rule::Positive),
                ("induced_w", induced_w, Rule::Positive),
                ("tip_speed_m_s", tip_speed_m_s, Rule::Positive),
                ("induced_speed_m_s", induced_speed_m_s, Rule::Positive),
                ("parasite_w_s3_m3", parasite_w_s3_m3, Rule::Positive),
            ];
            check.each("battery.rotor", &figures)
        }
        FlightPower::Wing { power_w_reference, speed_m_s_reference, parasite_share } => {
            let figures = [
                ("power_w_reference", power_w_reference, Rule::Positive),
                ("speed_m_s_reference", speed_m_s_reference, Rule::Positive),
                ("parasite_share", parasite_share, Rule::AboveUpTo(0.0, 1.0)),
            ];
            check.each("battery.wing", &figures)
        }
    }
}

/// Checks that the endurance computed from capacity and consumption is near the stated one.
fn check_stated(check: &Checker<'_>, name: &str, stated_min: f64, found_min: f64) -> Result<(), VehicleFileError> {
    if (found_min / stated_min - 1.0).abs() <= ENDURANCE_DEVIATION_MAX {
        return Ok(());
    }
    let percent = ENDURANCE_DEVIATION_MAX * 100.0;
    let expected = format!("within {percent:.0} % of {found_min:.1} minutes, which capacity and consumption give");
    let help = "correct the stated endurance, the capacity or the consumption";
    Err(check.file.error(format!("endurance.{name}"), expected, stated_min.to_string(), help))
}

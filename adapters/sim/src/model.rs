//! Vehicle models as data: what an airframe can do and what it carries.
//!
//! Two come with the product, `predator-b` and `rmax`; a mission may bring its own as data of the same shape.
//! The figures are those of the public literature, rounded; they make a plausible aircraft, not a certified one.

use crate::names::unknown_name;
use serde::{Deserialize, Serialize};

/// How an airframe flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Airframe {
    /// Needs speed: banks to turn, circles to wait.
    FixedWing,
    /// May stop, turn in place and fly in any direction.
    Rotorcraft,
}

/// A vehicle model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleModel {
    /// Its name, for messages.
    pub name: String,
    /// How it flies.
    pub airframe: Airframe,
    /// Slowest indicated airspeed in flight; zero for a rotorcraft.
    pub indicated_airspeed_m_s_min: f64,
    /// True airspeed flown when none is commanded.
    pub true_airspeed_m_s_cruise: f64,
    /// Fastest true airspeed.
    pub true_airspeed_m_s_max: f64,
    /// Greatest change of speed along the path, on the ground and in the air.
    pub acceleration_m_s2_max: f64,
    /// Bank of its turns.
    pub bank_deg_max: f64,
    /// Fastest roll.
    pub roll_rate_deg_s_max: f64,
    /// Fastest turn in place; used by rotorcraft.
    pub yaw_rate_deg_s_max: f64,
    /// Climb rate at sea level; falls linearly to a tenth at the ceiling.
    pub climb_rate_m_s_max: f64,
    /// Fastest descent.
    pub descent_rate_m_s_max: f64,
    /// Highest altitude it can hold.
    pub ceiling_m: f64,
    /// Metres forward for each metre of height without an engine.
    pub glide_ratio: f64,
    /// Fuel.
    pub fuel: FuelModel,
    /// The line scanner, if it carries one.
    pub scanner: Option<ScannerModel>,
    /// The cameras it carries.
    pub cameras: Vec<CameraModel>,
    /// How often it reports.
    pub report: ReportIntervals,
}

/// Fuel capacity and consumption.
///
/// `flow = reference * (share[0] + share[1] x + share[2] x^3) * altitude factor * climb factor` with `x` the true
/// airspeed over `speed_m_s_reference`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FuelModel {
    /// Usable fuel when full.
    pub capacity_kg: f64,
    /// Flow at the reference speed and altitude in level flight, if the shares sum to one.
    pub flow_kg_h_reference: f64,
    /// Speed at which `x` is one.
    pub speed_m_s_reference: f64,
    /// Constant, linear and cubic share of the flow.
    pub share: [f64; 3],
    /// Altitude at which the altitude factor is one.
    pub altitude_m_reference: f64,
    /// How much more (as a share) it burns at sea level than at the reference altitude.
    pub low_altitude_penalty: f64,
    /// How much more it burns in its fastest climb.
    pub climb_penalty: f64,
    /// How much less it burns in its fastest descent.
    pub descent_saving: f64,
}

/// A nadir line scanner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScannerModel {
    /// Full cross-track field of view.
    pub field_of_view_deg: f64,
    /// Lines are valid while the wings are level within this.
    pub roll_deg_max: f64,
}

/// A camera on a tilt, or tilt and pan, mount.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraModel {
    /// Its name in commands and events.
    pub name: String,
    /// Lowest tilt; straight down is -90.
    pub tilt_deg_min: f64,
    /// Highest tilt.
    pub tilt_deg_max: f64,
    /// Pan to either side; zero: the mount tilts only and the aircraft has to turn.
    pub pan_deg_max: f64,
    /// Slew rate of tilt and pan.
    pub slew_rate_deg_s: f64,
    /// Full horizontal field of view.
    pub field_of_view_deg: f64,
    /// From power-up to ready.
    pub power_up_s: f64,
    /// From the command to the image in memory.
    pub picture_s: f64,
}

/// How often state is reported.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReportIntervals {
    /// While the scanner is on or a line is flown.
    pub scanning_s: f64,
    /// While speed, bank or climb change.
    pub manoeuvring_s: f64,
    /// Otherwise.
    pub cruise_s: f64,
}

/// Names of the models that come with the product.
pub const MODEL_NAMES: &[&str] = &["predator-b", "rmax"];

impl VehicleModel {
    /// The model called `name`, in any case.
    ///
    /// # Errors
    /// A sentence that lists the known models when there is none of this name.
    pub fn named(name: &str) -> Result<VehicleModel, String> {
        match name.to_lowercase().as_str() {
            "predator-b" => Ok(VehicleModel::predator_b()),
            "rmax" => Ok(VehicleModel::rmax()),
            _ => Err(unknown_name("vehicle model", name, MODEL_NAMES.iter().copied())),
        }
    }

    /// A turboprop of the Predator B class with a thermal line scanner.
    fn predator_b() -> VehicleModel {
        VehicleModel {
            name: "predator-b".to_owned(),
            airframe: Airframe::FixedWing,
            indicated_airspeed_m_s_min: 44.0,
            true_airspeed_m_s_cruise: 95.2,
            true_airspeed_m_s_max: 118.3,
            acceleration_m_s2_max: 1.2,
            bank_deg_max: 18.0,
            roll_rate_deg_s_max: 6.0,
            yaw_rate_deg_s_max: 3.0,
            climb_rate_m_s_max: 8.0,
            descent_rate_m_s_max: 10.0,
            ceiling_m: 15_240.0,
            glide_ratio: 18.0,
            fuel: FuelModel {
                capacity_kg: 1_769.0,
                flow_kg_h_reference: 64.0,
                speed_m_s_reference: 95.2,
                share: [0.55, 0.0, 0.45],
                altitude_m_reference: 7_010.0,
                low_altitude_penalty: 0.3,
                climb_penalty: 0.6,
                descent_saving: 0.35,
            },
            scanner: Some(ScannerModel { field_of_view_deg: 86.0, roll_deg_max: 3.0 }),
            cameras: vec![CameraModel {
                name: "camera-1".to_owned(),
                tilt_deg_min: -90.0,
                tilt_deg_max: 10.0,
                pan_deg_max: 180.0,
                slew_rate_deg_s: 40.0,
                field_of_view_deg: 20.0,
                power_up_s: 30.0,
                picture_s: 1.0,
            }],
            report: ReportIntervals { scanning_s: 1.0, manoeuvring_s: 5.0, cruise_s: 10.0 },
        }
    }

    /// A helicopter of the Yamaha RMAX class with a tilt camera.
    fn rmax() -> VehicleModel {
        VehicleModel {
            name: "rmax".to_owned(),
            airframe: Airframe::Rotorcraft,
            indicated_airspeed_m_s_min: 0.0,
            true_airspeed_m_s_cruise: 12.0,
            true_airspeed_m_s_max: 20.6,
            acceleration_m_s2_max: 1.5,
            bank_deg_max: 20.0,
            roll_rate_deg_s_max: 30.0,
            yaw_rate_deg_s_max: 30.0,
            climb_rate_m_s_max: 3.0,
            descent_rate_m_s_max: 2.5,
            ceiling_m: 2_500.0,
            glide_ratio: 2.0,
            fuel: FuelModel {
                capacity_kg: 8.2,
                flow_kg_h_reference: 8.0,
                speed_m_s_reference: 20.6,
                share: [1.0, -0.35, 0.2],
                altitude_m_reference: 1_000.0,
                low_altitude_penalty: 0.0,
                climb_penalty: 0.3,
                descent_saving: 0.2,
            },
            scanner: None,
            cameras: vec![CameraModel {
                name: "camera-1".to_owned(),
                tilt_deg_min: -90.0,
                tilt_deg_max: 10.0,
                pan_deg_max: 0.0,
                slew_rate_deg_s: 30.0,
                field_of_view_deg: 40.0,
                power_up_s: 10.0,
                picture_s: 0.5,
            }],
            report: ReportIntervals { scanning_s: 1.0, manoeuvring_s: 1.0, cruise_s: 5.0 },
        }
    }

    /// Checks that the figures describe something that can fly.
    ///
    /// # Errors
    /// A sentence that names the first figure that is wrong.
    pub fn check(&self) -> Result<(), String> {
        let positive = [
            ("true_airspeed_m_s_cruise", self.true_airspeed_m_s_cruise),
            ("true_airspeed_m_s_max", self.true_airspeed_m_s_max),
            ("acceleration_m_s2_max", self.acceleration_m_s2_max),
            ("bank_deg_max", self.bank_deg_max),
            ("roll_rate_deg_s_max", self.roll_rate_deg_s_max),
            ("yaw_rate_deg_s_max", self.yaw_rate_deg_s_max),
            ("climb_rate_m_s_max", self.climb_rate_m_s_max),
            ("descent_rate_m_s_max", self.descent_rate_m_s_max),
            ("ceiling_m", self.ceiling_m),
            ("glide_ratio", self.glide_ratio),
            ("fuel.capacity_kg", self.fuel.capacity_kg),
            ("fuel.flow_kg_h_reference", self.fuel.flow_kg_h_reference),
            ("fuel.speed_m_s_reference", self.fuel.speed_m_s_reference),
            ("fuel.altitude_m_reference", self.fuel.altitude_m_reference),
            ("report.scanning_s", self.report.scanning_s),
            ("report.manoeuvring_s", self.report.manoeuvring_s),
            ("report.cruise_s", self.report.cruise_s),
        ];
        let name = &self.name;
        for (field, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!(
                    "vehicle model `{name}`: {field} is {value}; it must be a number greater than zero"
                ));
            }
        }
        if self.bank_deg_max >= 80.0 {
            return Err(format!("vehicle model `{name}`: bank_deg_max is {}; it must be below 80", self.bank_deg_max));
        }
        if self.airframe == Airframe::FixedWing && self.indicated_airspeed_m_s_min < 5.0 {
            return Err(format!(
                "vehicle model `{name}`: indicated_airspeed_m_s_min is {}; a fixed wing needs at least 5 m/s to stay in the air",
                self.indicated_airspeed_m_s_min
            ));
        }
        if self.true_airspeed_m_s_max < self.true_airspeed_m_s_cruise {
            return Err(format!("vehicle model `{name}`: the cruise speed is above the maximum speed"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_models_pass_their_own_check() {
        for name in MODEL_NAMES {
            VehicleModel::named(name).unwrap().check().unwrap();
        }
    }

    #[test]
    fn an_unknown_model_is_answered_with_the_known_ones() {
        let message = VehicleModel::named("predator").unwrap_err();
        assert!(message.contains("`predator-b`") && message.contains("rmax"), "{message}");
    }

    #[test]
    fn impossible_figures_are_named() {
        let mut model = VehicleModel::named("rmax").unwrap();
        model.fuel.capacity_kg = f64::NAN;
        assert!(model.check().unwrap_err().contains("fuel.capacity_kg"));
    }
}

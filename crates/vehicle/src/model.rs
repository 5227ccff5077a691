//! The types of a vehicle model. Units are part of the names; angles are degrees.

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

/// A vehicle model: airframe, fuel, sensors, and how plans for it are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleModel {
    /// Name, for messages and the flight record.
    pub name: String,
    /// How it flies.
    pub airframe: Airframe,
    /// Slowest indicated airspeed in flight; zero for a rotorcraft.
    pub indicated_airspeed_m_s_min: f64,
    /// True airspeed flown if none is commanded.
    pub true_airspeed_m_s_cruise: f64,
    /// Fastest true airspeed.
    pub true_airspeed_m_s_max: f64,
    /// Greatest change of speed along the path, on the ground and in the air.
    pub acceleration_m_s2_max: f64,
    /// Greatest bank in turns.
    pub bank_deg_max: f64,
    /// Roll angle up to which the wings count as level: lines of a scanner are valid up to it.
    pub level_roll_deg_max: f64,
    /// Fastest roll.
    pub roll_rate_deg_s_max: f64,
    /// Fastest turn in place; used by rotorcraft.
    pub yaw_rate_deg_s_max: f64,
    /// Climb rate at sea level; falls linearly to a tenth at the ceiling.
    pub climb_rate_m_s_max: f64,
    /// Fastest descent.
    pub descent_rate_m_s_max: f64,
    /// Highest altitude it can hold, above mean sea level.
    pub ceiling_m: f64,
    /// Metres forward for each metre of height without an engine.
    pub glide_ratio: f64,
    /// Length of the final approach to a runway; zero for a rotorcraft.
    pub final_approach_m: f64,
    /// Height above the runway at which the final approach begins; zero for a rotorcraft.
    pub final_approach_height_m: f64,
    /// Share of the acceleration that stops are planned with; zero for a fixed wing.
    pub braking_share: f64,
    /// Horizontal acceleration that a tilt must provide against drag, per m/s of airspeed (1/s); zero for a fixed wing.
    pub drag_per_s: f64,
    /// How turns are planned, by the planner and by the simulated autopilot.
    pub turns: TurnModel,
    /// Fuel.
    pub fuel: FuelModel,
    /// The line scanner, if it carries one.
    pub scanner: Option<ScannerModel>,
    /// The cameras that it carries.
    pub cameras: Vec<CameraModel>,
    /// How often it reports.
    pub report: ReportIntervals,
    /// How plans for it are made.
    pub planning: PlanningModel,
}

/// How turns are planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TurnModel {
    /// Share of `bank_deg_max` that turns are planned with; the rest corrects errors.
    pub bank_share: f64,
    /// Radius of circles around a site as a multiple of the tightest planned turn: the wind may exceed the forecast.
    pub circle_width: f64,
}

/// Fuel capacity and consumption.
///
/// `flow = reference * (share[0] + share[1] x + share[2] x^3) * altitude factor * climb factor` with `x` the true
/// airspeed over `speed_m_s_reference`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FuelModel {
    /// Usable fuel when full.
    pub capacity_kg: f64,
    /// Fuel below which `(watch the fuel)` reports low fuel.
    pub low_kg: f64,
    /// Flow at the reference speed and altitude in level flight, if the shares sum to one.
    pub flow_kg_h_reference: f64,
    /// Speed at which `x` is one.
    pub speed_m_s_reference: f64,
    /// Constant, linear and cubic share of the flow.
    pub share: [f64; 3],
    /// Altitude at which the altitude factor is one.
    pub altitude_m_reference: f64,
    /// Additional share of the flow at sea level, compared with the reference altitude.
    pub low_altitude_penalty: f64,
    /// Additional share of the flow in the fastest climb.
    pub climb_penalty: f64,
    /// Share of the flow that the fastest descent saves.
    pub descent_saving: f64,
}

/// A nadir line scanner, and how its lines are planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScannerModel {
    /// Full cross-track field of view.
    pub field_of_view_deg: f64,
    /// Angle of one pixel.
    pub pixel_mrad: f64,
    /// Heights above the ground of the target among which the planner chooses, rising.
    pub heights_m: Vec<f64>,
    /// Planned time to roll level before the first line.
    pub first_join_s: f64,
    /// Planned time from the end of a line to the beginning of the next.
    pub further_join_s: f64,
}

/// A camera on a tilt, or tilt and pan, mount.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraModel {
    /// Name in commands and events.
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

/// Figures that plans are made with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanningModel {
    /// Altitude of flights between targets, above mean sea level.
    pub cruise_altitude_m: f64,
    /// Share of `climb_rate_m_s_max` that climbs are planned with.
    pub climb_share: f64,
    /// Share of `descent_rate_m_s_max` that descents are planned with.
    pub descent_share: f64,
    /// Share of the ceiling up to which targets are observed.
    pub ceiling_share: f64,
    /// Share of endurance and fuel that must remain at the end.
    pub reserve_share: f64,
    /// Height from which a site is visited: above the site for a rotorcraft, which hovers; above the highest site for a fixed
    /// wing, which circles.
    pub visit_height_m: f64,
}

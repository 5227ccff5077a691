//! The types of a vehicle model. Units are part of the names; angles are degrees.

use crate::energy::{EnergyModel, Reserve, StatedEndurance};
use crate::sensor::{CarriedSensor, ScannerMode};
use serde::{Deserialize, Serialize};

/// Kind of airframe with its limits of flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Airframe {
    /// Needs airspeed to fly: it banks to turn and circles to wait.
    FixedWing,
    /// May stop, turn in place and fly in any direction.
    Rotorcraft,
}

/// A vehicle model: airframe, fuel, sensors, and how plans for it are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleModel {
    /// Name, for messages and the flight record.
    pub name: String,
    /// Airframe.
    pub airframe: Airframe,
    /// Mass in flight with sensors and half of the fuel.
    pub mass_kg: f64,
    /// Indicated airspeed at which the wing stalls in level flight; zero for a rotorcraft.
    pub indicated_airspeed_m_s_stall: f64,
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
    /// Highest altitude that the vehicle can hold, above mean sea level.
    pub ceiling_m: f64,
    /// Strongest steady surface wind in which the vehicle may fly.
    pub wind_m_s_max: f64,
    /// Metres forward for each metre of height lost without an engine. Zero: the vehicle falls.
    pub glide_ratio: f64,
    /// Length of the final approach to a runway; zero for a rotorcraft.
    pub final_approach_m: f64,
    /// Height above the runway at which the final approach begins; zero for a rotorcraft.
    pub final_approach_height_m: f64,
    /// Share of the acceleration that stops are planned with; zero for a fixed wing.
    pub braking_share: f64,
    /// Horizontal acceleration that a tilt must provide against drag, per m/s of airspeed (1/s); zero for a fixed wing.
    pub drag_per_s: f64,
    /// Model of turns, for the planner and the simulated autopilot.
    pub turns: TurnModel,
    /// Roll response to turbulence.
    pub attitude_hold: AttitudeHold,
    /// Fuel or battery.
    pub energy: EnergyModel,
    /// Energy that must remain.
    pub reserve: Reserve,
    /// Endurance that the sources state.
    pub endurance: StatedEndurance,
    /// The sensors that it carries.
    pub sensors: Vec<CarriedSensor>,
    /// Recorder of lines over the ground: the line scanner in the mode in use, or a frame camera straight down.
    pub scanner: Option<ScannerMode>,
    /// The cameras among the sensors.
    pub cameras: Vec<CameraModel>,
    /// Intervals between reports.
    pub report: ReportIntervals,
    /// Model for planning.
    pub planning: PlanningModel,
}

/// Model of turns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TurnModel {
    /// Share of `bank_deg_max` used in planned turns; the rest is left for correcting errors.
    pub bank_share: f64,
    /// Radius of circles around a site, as a multiple of the tightest planned turn. The margin is for wind stronger than forecast.
    pub circle_width: f64,
}

/// Roll of an aircraft that holds its attitude in turbulence: a second-order system driven by white noise.
///
/// In turbulence of a constant EDR (cube root of the eddy dissipation rate) the roll angle about the commanded bank is normal
/// with deviation `roll_deg_per_edr * EDR`; its rate has the deviation of the angle times the natural frequency. The share of
/// time within a limit is `erf(limit / (sqrt 2 sigma))`. From the roll-gust spectrum of MIL-F-8785C: for a roll damping time
/// constant tau (s), span b (m) and airspeed V (m/s) the figure is, in radians per unit of EDR,
/// `1/tau sqrt(0.8/0.7987 (pi/(4 b))^(1/3) / V pi/(4 zeta omega^3))`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttitudeHold {
    /// Stationary deviation of the roll angle for each unit of EDR, deg/(m^(2/3)/s).
    pub roll_deg_per_edr: f64,
    /// Undamped natural frequency of the attitude hold, rad/s.
    pub natural_frequency_rad_s: f64,
    /// Damping ratio of the attitude hold.
    pub damping_ratio: f64,
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
    /// Pan to either side. Zero: the mount only tilts, and the aircraft has to turn instead.
    pub pan_deg_max: f64,
    /// Slew rate of tilt and pan.
    pub slew_rate_deg_s: f64,
    /// Full horizontal field of view.
    pub field_of_view_deg: f64,
    /// From power-up to ready.
    pub power_up_s: f64,
    /// From the command to the image in memory.
    pub picture_s: f64,
    /// Least time from one picture to the next.
    pub interval_s_min: f64,
}

/// Intervals between reports of state.
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
    /// Level of flights between targets.
    pub cruise: CruiseLevel,
    /// Share of `climb_rate_m_s_max` that climbs are planned with.
    pub climb_share: f64,
    /// Share of `descent_rate_m_s_max` that descents are planned with.
    pub descent_share: f64,
    /// Share of the ceiling up to which targets are observed.
    pub ceiling_share: f64,
    /// Height from which a site is visited: above the site for a rotorcraft, which hovers; above the highest site for a fixed
    /// wing, which circles.
    pub visit_height_m: f64,
}

/// Level of flights between targets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum CruiseLevel {
    /// Altitude above mean sea level, m.
    Altitude(f64),
    /// Height above the highest ground of the mission, m.
    Height(f64),
}

impl CruiseLevel {
    /// Returns the altitude above mean sea level, m, in a mission whose highest ground is at `ground_m`.
    pub fn altitude_m(self, ground_m: f64) -> f64 {
        match self {
            CruiseLevel::Altitude(altitude_m) => altitude_m,
            CruiseLevel::Height(height_m) => ground_m + height_m,
        }
    }
}

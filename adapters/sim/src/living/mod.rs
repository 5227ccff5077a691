//! The living part of a world, in addition to vehicle, wind and ground: failures, moving weather, fires that break out, and the downlink
//! of images.
//!
//! Plain data as given in a world file, checked as a whole. `docs/reference/world.md` describes every field. Without a world file nothing
//! here is active, and flights are not affected.

mod adrift;
mod check;
pub(crate) mod disturbances;
pub(crate) mod downlink;
pub(crate) mod faults;
pub(crate) mod ignitions;
pub(crate) mod life;
pub(crate) mod navigation;
pub(crate) mod perimeters;
pub(crate) mod readings;
pub(crate) mod sky;
pub(crate) mod suffering;
pub(crate) mod wind_error;

use apex_model::problem::{EventRate, Position};
use serde::{Deserialize, Serialize};

/// The version that a world file must state.
pub const WORLD_FORMAT: &str = "apex-world-1";

/// A world file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LivingWorld {
    /// [`WORLD_FORMAT`].
    pub format: String,
    /// Description of the world for its readers; the simulator ignores it.
    #[serde(default)]
    pub note: String,
    /// Failures, stated by time or by rate.
    #[serde(default)]
    pub faults: Vec<FaultSpec>,
    /// Fires that break out at the mission's structures.
    #[serde(default)]
    pub ignitions: Option<IgnitionSpec>,
    /// Growth of the mission's fires.
    #[serde(default)]
    pub perimeters: Option<PerimeterSpec>,
    /// Cloud fields.
    #[serde(default)]
    pub clouds: Vec<CloudField>,
    /// Convective cells.
    #[serde(default)]
    pub storms: Vec<StormCell>,
    /// Deviation of the true wind from the mission's weather, drawn from the seed.
    #[serde(default)]
    pub wind_error: Option<WindErrorSpec>,
    /// Images on their way to the ground.
    #[serde(default)]
    pub downlink: Option<DownlinkSpec>,
}

/// A subsystem or signal that can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// The engine stops; it runs again after the fault.
    Engine,
    /// The vehicle loses fuel (`by` kg/h) or charge (`by` W) in addition to its consumption.
    Leak,
    /// Cameras and scanner have no power.
    PayloadPower,
    /// The mount of camera `of` does not move.
    Gimbal,
    /// Camera or scanner `of` delivers no images.
    Sensor,
    /// The cooling of camera `of` fails: its detector heats up while it is powered.
    Cooling,
    /// Modem `of` is silent.
    Modem,
    /// The estimated position drifts by `by` m/s to the east; without `by` there is no position, and the autopilot uses dead reckoning.
    Navigation,
    /// State variable `of` of the vehicle keeps its last value.
    Freeze,
    /// State variable `of` of the vehicle is not reported.
    Silence,
    /// `by` is added to the number of state variable `of`, in SI units.
    Bias,
    /// The vehicle obeys commands and does not acknowledge them.
    Acknowledgements,
}

impl FaultKind {
    /// All kinds.
    pub const ALL: [FaultKind; 12] = [
        FaultKind::Engine,
        FaultKind::Leak,
        FaultKind::PayloadPower,
        FaultKind::Gimbal,
        FaultKind::Sensor,
        FaultKind::Cooling,
        FaultKind::Modem,
        FaultKind::Navigation,
        FaultKind::Freeze,
        FaultKind::Silence,
        FaultKind::Bias,
        FaultKind::Acknowledgements,
    ];

    /// Returns the word of world files and messages.
    pub fn word(self) -> &'static str {
        match self {
            FaultKind::Engine => "engine",
            FaultKind::Leak => "leak",
            FaultKind::PayloadPower => "payload-power",
            FaultKind::Gimbal => "gimbal",
            FaultKind::Sensor => "sensor",
            FaultKind::Cooling => "cooling",
            FaultKind::Modem => "modem",
            FaultKind::Navigation => "navigation",
            FaultKind::Freeze => "freeze",
            FaultKind::Silence => "silence",
            FaultKind::Bias => "bias",
            FaultKind::Acknowledgements => "acknowledgements",
        }
    }
}

/// A failure at a stated time, or failures drawn from the seed as a Poisson process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultSpec {
    /// The kind of the failure.
    pub fault: FaultKind,
    /// Name of the camera, modem or state variable.
    #[serde(default)]
    pub of: Option<String>,
    /// Amount, in SI units.
    #[serde(default)]
    pub by: Option<f64>,
    /// Instant at which the failure begins. A failure states either this or `rate_per_h`.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// Mean number of occurrences per hour.
    #[serde(default)]
    pub rate_per_h: Option<f64>,
    /// Duration of the failure; `None` lasts to the end of the flight.
    #[serde(default)]
    pub for_s: Option<f64>,
}

/// Fires that break out at structures with the rates of the mission, and the detection of fires by looks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IgnitionSpec {
    /// Probability that a look sees a fire that burns in clear air, 0 to 1.
    #[serde(default = "one")]
    pub detection: f64,
    /// Smallest area of a visible fire, m2; fires grow with the wind.
    #[serde(default)]
    pub seen_from_m2: f64,
    /// Probability that a look reports a fire where none burns.
    #[serde(default)]
    pub false_alarm: f64,
}

/// Growth of the outlines of the mission's fires.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerimeterSpec {
    /// Hours between reports.
    #[serde(default = "one")]
    pub every_h: f64,
    /// Hour of the mission from which the fires grow.
    #[serde(default)]
    pub from_h: f64,
    /// Hour of the last report; `None` is the end of the flight.
    #[serde(default)]
    pub until_h: Option<f64>,
    /// Rate of spread as a share of the model's: 0.3 to 0.5 by night.
    #[serde(default = "one")]
    pub rate_share: f64,
    /// The growing fires; all fires if none is named.
    #[serde(default)]
    pub targets: Vec<String>,
}

fn one() -> f64 {
    1.0
}

/// A field of clouds that moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CloudField {
    /// Middle at mission time zero.
    pub latitude_deg: f64,
    /// Middle at mission time zero.
    pub longitude_deg: f64,
    /// Half of the field's width.
    pub radius_m: f64,
    /// Lower side above mean sea level.
    pub base_m: f64,
    /// Upper side above mean sea level.
    pub top_m: f64,
    /// Share of the area that clouds cover, 0 to 1.
    pub cover: f64,
    /// Motion to the east.
    #[serde(default)]
    pub east_mps: f64,
    /// Motion to the north.
    #[serde(default)]
    pub north_mps: f64,
    /// Mission time at which the weather begins, hours.
    #[serde(default)]
    pub from_h: f64,
    /// Mission time at which the weather ends, hours; `None` is the end of the flight.
    #[serde(default)]
    pub until_h: Option<f64>,
}

/// A convective cell that moves: rough air, to be flown around.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StormCell {
    /// Middle at mission time zero.
    pub latitude_deg: f64,
    /// Middle at mission time zero.
    pub longitude_deg: f64,
    /// Radius.
    pub radius_m: f64,
    /// Upper side above mean sea level.
    #[serde(default = "storm_top_m")]
    pub top_m: f64,
    /// Turbulence within, m^(2/3)/s.
    #[serde(default = "storm_edr")]
    pub edr: f64,
    /// Motion to the east.
    #[serde(default)]
    pub east_mps: f64,
    /// Motion to the north.
    #[serde(default)]
    pub north_mps: f64,
    /// Mission time at which the weather begins, hours.
    #[serde(default)]
    pub from_h: f64,
    /// Mission time at which the weather ends, hours; `None` is the end of the flight.
    #[serde(default)]
    pub until_h: Option<f64>,
}

fn storm_top_m() -> f64 {
    12_000.0
}

fn storm_edr() -> f64 {
    0.7
}

/// Deviation of the true wind from the wind of the mission's weather: a Gaussian field, correlated in time and space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindErrorSpec {
    /// Standard deviation of each component in still air.
    #[serde(default = "error_mps")]
    pub sigma_mps: f64,
    /// Increase of the standard deviation for each m/s of wind.
    #[serde(default = "error_share")]
    pub sigma_share: f64,
    /// Time after which the correlation is 1/e.
    #[serde(default = "error_h")]
    pub correlation_h: f64,
    /// Distance at which the correlation is 1/e.
    #[serde(default = "error_km")]
    pub correlation_km: f64,
    /// Deviation of the logarithm of the turbulence (EDR).
    #[serde(default)]
    pub edr_log_sigma: f64,
}

fn error_mps() -> f64 {
    1.5
}

fn error_share() -> f64 {
    0.1
}

fn error_h() -> f64 {
    6.0
}

fn error_km() -> f64 {
    200.0
}

/// Bandwidth and store for images on their way to the ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DownlinkSpec {
    /// The modem that carries them.
    pub over: String,
    /// Rate at full signal level; it decreases with the level.
    pub rate_mbit_s: f64,
    /// Size of one picture.
    pub picture_mbit: f64,
    /// Store on board; a picture that does not fit is lost.
    pub store_mbit: f64,
    /// Time that processing on board takes before a picture is sent.
    #[serde(default)]
    pub processing_s: f64,
}

/// A structure at which fires break out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BurnableSite {
    /// The target.
    pub name: String,
    /// Its place.
    pub position: Position,
    /// True rate of ignitions.
    pub rate: EventRate,
    /// Fires that broke out up to this long before the mission count, too.
    pub initial_age_s: f64,
}

/// A fire with an outline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BurningTarget {
    /// The target.
    pub name: String,
    /// Its middle, inside the outline.
    pub middle: Position,
    /// Its outline at mission time zero.
    pub outline: Vec<Position>,
}

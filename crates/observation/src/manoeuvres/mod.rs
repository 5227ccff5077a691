//! At-target manoeuvres: flight path x attitude mode x speed profile x payload x data handling, as one typed value with what
//! it is predicted to see and to cost.
//!
//! Each path has a file with its parameters, its limits by vehicle and sensor, and its geometry. Time, attitude and energy
//! come from one pass over the track (`timing`), coverage, resolution and clarity from the model that also scores flights
//! (`forecast`). Sources: IAMSAR manual volumes II and III for search patterns; Dubins paths in wind for turns
//! (`apex_geo::travel`). Formulas and test values: `docs/reference/manoeuvres.md`.

mod arc;
mod craft;
mod expanding_square;
mod forecast;
mod modes;
mod orbit;
mod pirouette;
mod refusal;
mod scene;
pub mod search_effort;
mod sector_search;
mod spiral;
mod stand_off;
mod strafe;
mod straight_over;
mod sweep;
mod timing;
mod track;
mod vantage_point;

pub use arc::{Arc, ArcFigures, ArcShape};
pub use craft::{Craft, DrainTable, GRAVITY_MPS2, circle_bank_deg};
pub use expanding_square::ExpandingSquare;
pub use forecast::{Forecast, ForecastContext};
pub use modes::{AttitudeMode, DataHandling, PayloadUse, SpeedProfile};
pub use orbit::Orbit;
pub use pirouette::Pirouette;
pub use refusal::Refusal;
pub use scene::{Instrument, Scene};
pub use sector_search::SectorSearch;
pub use spiral::Spiral;
pub use stand_off::{Side, StandOff};
pub use strafe::Strafe;
pub use straight_over::StraightOver;
pub use sweep::{Sweep, turn_s};
pub use timing::{CORNER_DEG, CORNER_S, FlownPath, PacedPoint, PathPose, corner_speed_mps};
pub use track::{Element, Sight, Track, TrackPoint};
pub use vantage_point::{VantageNeeds, VantagePoint, VantageScore};

use serde::{Deserialize, Serialize};

/// Where a manoeuvre leads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlightPath {
    /// One line over the target.
    StraightOver(StraightOver),
    /// One line aside of it.
    StandOff(StandOff),
    /// Circles of growing radius.
    Spiral(Spiral),
    /// Over the target with tilt tracking and reversal.
    Arc(Arc),
    /// Parallel lines.
    Sweep(Sweep),
    /// A turn on the spot.
    Pirouette(Pirouette),
    /// Sideways along a facade.
    Strafe(Strafe),
    /// Circles around the target.
    Orbit(Orbit),
    /// One place to look from.
    VantagePoint(VantagePoint),
    /// A growing square around a datum.
    ExpandingSquare(ExpandingSquare),
    /// Triangles through a datum.
    SectorSearch(SectorSearch),
}

/// A manoeuvre: how a target is observed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// Where it leads.
    pub path: FlightPath,
    /// Which way the vehicle faces.
    pub attitude: AttitudeMode,
    /// How fast it flies.
    pub speed: SpeedProfile,
    /// What the payload records.
    pub payload: PayloadUse,
    /// What becomes of the data.
    pub data: DataHandling,
}

impl FlightPath {
    /// Names of all paths, as PDL writes them.
    pub const NAMES: [&'static str; 11] = [
        StraightOver::NAME,
        StandOff::NAME,
        Spiral::NAME,
        Arc::NAME,
        Sweep::NAME,
        Pirouette::NAME,
        Strafe::NAME,
        Orbit::NAME,
        VantagePoint::NAME,
        ExpandingSquare::NAME,
        SectorSearch::NAME,
    ];

    /// Name in PDL.
    pub fn name(&self) -> &'static str {
        match self {
            FlightPath::StraightOver(_) => StraightOver::NAME,
            FlightPath::StandOff(_) => StandOff::NAME,
            FlightPath::Spiral(_) => Spiral::NAME,
            FlightPath::Arc(_) => Arc::NAME,
            FlightPath::Sweep(_) => Sweep::NAME,
            FlightPath::Pirouette(_) => Pirouette::NAME,
            FlightPath::Strafe(_) => Strafe::NAME,
            FlightPath::Orbit(_) => Orbit::NAME,
            FlightPath::VantagePoint(_) => VantagePoint::NAME,
            FlightPath::ExpandingSquare(_) => ExpandingSquare::NAME,
            FlightPath::SectorSearch(_) => SectorSearch::NAME,
        }
    }

    /// Tightest radius that is observed on a curve; none for paths of straight lines and for standing still.
    pub(crate) fn curve_radius_m(&self) -> Option<f64> {
        match self {
            FlightPath::Spiral(spiral) => Some(spiral.inner_radius_m),
            FlightPath::Orbit(orbit) => Some(orbit.radius_m),
            _ => None,
        }
    }
}

impl Manoeuvre {
    /// Where it leads, for a vehicle and a sensor in a scene.
    ///
    /// # Errors
    /// A limit of vehicle, sensor or wind, with the nearest thing that works.
    pub fn track(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<Track, Refusal> {
        let name = self.path.name();
        let airspeed_mps = self.speed.turn_airspeed_mps(craft);
        self.data.check(name)?;
        self.attitude.check(name, craft, instrument)?;
        self.payload.check(&self.path, craft, instrument)?;
        match &self.path {
            FlightPath::StraightOver(path) => {
                path.check()?;
                path.track(airspeed_mps, craft, instrument, scene)
            }
            FlightPath::StandOff(path) => {
                path.check(instrument)?;
                path.track(airspeed_mps, craft, instrument, scene)
            }
            FlightPath::Spiral(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::Arc(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::Sweep(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::Pirouette(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::Strafe(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::Orbit(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::VantagePoint(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::ExpandingSquare(path) => path.track(airspeed_mps, craft, instrument, scene),
            FlightPath::SectorSearch(path) => path.track(airspeed_mps, craft, instrument, scene),
        }
    }

    /// Its poses over time, with time, length and energy.
    ///
    /// # Errors
    /// As [`Manoeuvre::track`], and a speed that vehicle or wind do not permit.
    pub fn fly(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<FlownPath, Refusal> {
        let track = self.track(craft, instrument, scene)?;
        timing::fly(self.path.name(), &track, (&self.attitude, &self.speed), (craft, instrument), scene)
    }

    /// The points to be followed with their speeds; empty for a manoeuvre that only hovers.
    ///
    /// # Errors
    /// As [`Manoeuvre::fly`].
    pub fn paced_points(
        &self,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<Vec<PacedPoint>, Refusal> {
        let track = self.track(craft, instrument, scene)?;
        timing::pace(self.path.name(), &track, &self.speed, (craft, instrument), scene)
    }
}

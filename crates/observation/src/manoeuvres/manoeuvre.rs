//! The manoeuvre as one value: its path with its modes, checked and timed.

use super::arc::Arc;
use super::craft::Craft;
use super::expanding_square::ExpandingSquare;
use super::modes::{AttitudeMode, DataHandling, PayloadUse, SpeedProfile};
use super::orbit::Orbit;
use super::pirouette::Pirouette;
use super::refusal::Refusal;
use super::scene::{Instrument, Scene};
use super::sector_search::SectorSearch;
use super::spiral::Spiral;
use super::stand_off::StandOff;
use super::strafe::Strafe;
use super::straight_over::StraightOver;
use super::sweep::Sweep;
use super::timing::{self, FlownPath, PacedPoint};
use super::track::{Sight, Track};
use super::vantage_point::VantagePoint;
use serde::{Deserialize, Serialize};

/// Path of a manoeuvre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlightPath {
    /// One line over the target.
    StraightOver(StraightOver),
    /// One line offset from the target.
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
    /// One hover point.
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
    /// Path.
    pub path: FlightPath,
    /// Direction in which the vehicle faces.
    pub attitude: AttitudeMode,
    /// Speed.
    pub speed: SpeedProfile,
    /// Recording by the payload.
    pub payload: PayloadUse,
    /// Handling of the data.
    pub data: DataHandling,
}

/// The poses of a manoeuvre over time, and the direction in which its camera looks.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedTrack {
    /// Direction of the camera.
    pub sight: Sight,
    /// The poses.
    pub flown: FlownPath,
}

impl FlightPath {
    /// Names of all paths in PDL.
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

    /// Returns the name in PDL.
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

    /// Returns the tightest radius that is observed on a curve; `None` for paths of straight lines and for standing still.
    fn curve_radius_m(&self) -> Option<f64> {
        match self {
            FlightPath::Spiral(spiral) => Some(spiral.inner_radius_m),
            FlightPath::Orbit(orbit) => Some(orbit.radius_m),
            _ => None,
        }
    }
}

impl Manoeuvre {
    /// Computes the track of the manoeuvre for a vehicle and a sensor in a scene.
    ///
    /// # Errors
    /// The violated limit of vehicle, sensor or wind, with the nearest possible value.
    pub fn track(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<Track, Refusal> {
        let name = self.path.name();
        let airspeed_mps = self.speed.turn_airspeed_mps(craft);
        self.attitude.check(name, craft, instrument)?;
        self.payload.check((name, self.path.curve_radius_m()), craft, instrument)?;
        match &self.path {
            FlightPath::StraightOver(path) => {
                path.check()?;
                path.track(airspeed_mps, craft, instrument, scene)
            }
            FlightPath::StandOff(path) => {
                path.check(craft, instrument)?;
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

    /// Returns its poses over time, with time, length and energy.
    ///
    /// # Errors
    /// Like [`Manoeuvre::track`], and a speed that vehicle or wind do not permit.
    pub fn fly(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<FlownPath, Refusal> {
        self.timed(craft, instrument, scene).map(|timed| timed.flown)
    }

    /// Returns its track with its poses over time, from which [`Manoeuvre::observe`] predicts the looks.
    ///
    /// # Errors
    /// Like [`Manoeuvre::fly`].
    pub fn timed(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<TimedTrack, Refusal> {
        let track = self.track(craft, instrument, scene)?;
        let flown = timing::fly(self.path.name(), &track, (&self.attitude, &self.speed), (craft, instrument), scene)?;
        let speeds_mps = flown.poses.iter().filter(|pose| pose.is_observed).map(|pose| pose.ground_speed_mps);
        let fastest_mps = speeds_mps.fold(0.0, f64::max);
        self.data.check(self.path.name(), self.payload.interval_s(fastest_mps, instrument))?;
        Ok(TimedTrack { sight: track.sight, flown })
    }

    /// Returns the points to be followed with their speeds; empty for a manoeuvre that only hovers.
    ///
    /// # Errors
    /// Like [`Manoeuvre::fly`].
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

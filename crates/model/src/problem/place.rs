//! Positions, windows of time, wind, airspace and landing places, as plain data.

use serde::{Deserialize, Serialize};

/// A time later than the end of every mission, for windows without end; finite, so that JSON can represent it.
pub const FOREVER_S: f64 = 1e18;

/// A point on the WGS84 ellipsoid.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// Geodetic latitude, north positive.
    pub latitude_deg: f64,
    /// Longitude, east positive.
    pub longitude_deg: f64,
}

impl Position {
    /// Returns the point at `latitude_deg`, `longitude_deg`.
    pub const fn new(latitude_deg: f64, longitude_deg: f64) -> Position {
        Position { latitude_deg, longitude_deg }
    }
}

/// A half-open span of time `[from_s, until_s)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeWindow {
    /// First instant inside.
    pub from_s: f64,
    /// First instant after.
    pub until_s: f64,
}

impl TimeWindow {
    /// All of time.
    pub const ALWAYS: TimeWindow = TimeWindow { from_s: -FOREVER_S, until_s: FOREVER_S };

    /// Returns true if `time_s` is inside.
    pub fn contains(&self, time_s: f64) -> bool {
        self.from_s <= time_s && time_s < self.until_s
    }

    /// Returns true if it shares an instant with `[from_s, until_s]`.
    pub fn overlaps(&self, from_s: f64, until_s: f64) -> bool {
        self.from_s <= until_s && from_s < self.until_s
    }
}

/// A box of latitude and longitude. `west_deg > east_deg` reaches across the 180th meridian.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// Southern edge.
    pub south_deg: f64,
    /// Northern edge.
    pub north_deg: f64,
    /// Western edge.
    pub west_deg: f64,
    /// Eastern edge.
    pub east_deg: f64,
}

impl Area {
    /// Returns true if `position` is inside or on the edge.
    pub fn contains(&self, position: Position) -> bool {
        let longitude_deg = position.longitude_deg;
        let between_meridians = if self.west_deg <= self.east_deg {
            self.west_deg <= longitude_deg && longitude_deg <= self.east_deg
        } else {
            longitude_deg >= self.west_deg || longitude_deg <= self.east_deg
        };
        between_meridians && self.south_deg <= position.latitude_deg && position.latitude_deg <= self.north_deg
    }
}

/// Wind in one layer of air over one area during one interval of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindLayer {
    /// Area of validity; `None` is everywhere.
    pub area: Option<Area>,
    /// Lower face, above mean sea level.
    pub altitude_m_min: f64,
    /// Upper face, above mean sea level.
    pub altitude_m_max: f64,
    /// First instant at which the layer holds.
    pub from_s: f64,
    /// First instant at which it no longer holds; [`FOREVER_S`] if it has no end.
    pub until_s: f64,
    /// Air moves east at this speed.
    pub wind_east_mps: f64,
    /// Air moves north at this speed.
    pub wind_north_mps: f64,
    /// Turbulence: cube root of the eddy dissipation rate (EDR), m^(2/3)/s. Classes of ICAO Annex 3 for large aircraft: below 0.10
    /// none, 0.10 to 0.20 light, 0.20 to 0.45 moderate, above severe.
    pub edr: f64,
}

/// A wind forecast, or the true wind: the later of overlapping layers counts, else the air is still. See `apex_geo::wind`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindField {
    /// The layers.
    pub layers: Vec<WindLayer>,
    /// True if wind is interpolated over altitude between the middles of the layers that hold at the place and time.
    pub blend: bool,
}

/// Demand of a zone of airspace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ZoneKind {
    /// The vehicle must stay outside.
    Restricted,
    /// The vehicle must stay inside: a corridor of permitted operation. With several, inside at least one at every instant.
    Permitted,
}

/// A polygon of airspace with an altitude band and a window of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirspaceZone {
    /// Its name, for example `R-2515`.
    pub name: String,
    /// Keep out or keep in.
    pub kind: ZoneKind,
    /// Corners in order, either sense, not closed; edges are straight in a local projection.
    pub corners: Vec<Position>,
    /// Lower face, above mean sea level.
    pub altitude_m_min: f64,
    /// Upper face, above mean sea level.
    pub altitude_m_max: f64,
    /// Window in which it is active.
    pub active: TimeWindow,
}

/// A place to land in an emergency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandingPlace {
    /// Its name.
    pub name: String,
    /// Position.
    pub position: Position,
}

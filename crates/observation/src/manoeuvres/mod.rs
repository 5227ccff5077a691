//! At-target manoeuvres: flight path, attitude mode, speed profile, payload and data handling as one typed value, with its predicted
//! observations and cost.
//!
//! Each path has a file with its parameters, its limits by vehicle and sensor, and its geometry. Time, attitude and energy
//! come from one pass along the track (`timing`), coverage, resolution and clarity from the model that also scores flights
//! (`forecast`). Sources: IAMSAR manual volumes II and III for search patterns; Dubins paths in wind for turns
//! (`apex_geo::travel`). Formulas and test values: `docs/reference/manoeuvres.md`.

mod arc;
mod craft;
mod expanding_square;
mod forecast;
mod manoeuvre;
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
pub use manoeuvre::{FlightPath, Manoeuvre, TimedTrack};
pub use modes::{AttitudeMode, DataHandling, PayloadUse, SpeedProfile};
pub use orbit::Orbit;
pub use pirouette::Pirouette;
pub use refusal::{Refusal, rounded_down, rounded_up};
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

//! Requirements of a mission: stated once, and used by planning problems, by the watcher in flight, and by the monitors of PDL.
//!
//! `statement` reads them from the application and the vehicle; `watch` compares them with the flight and predicts violations
//! along the commanded route; `readings` computes each margin, `recovery` a way out.

mod clearance;
mod commanded;
mod commanded_route;
mod endurance;
mod exposure;
mod ice;
mod ice_level;
mod landing_distance;
mod mission_end;
mod readings;
mod recovery;
mod response;
mod sensors;
mod start;
mod statement;
mod storms;
mod surface_wind;
mod unjudged;
mod watch;

pub use readings::Reading;
pub use response::Response;
pub use statement::{HeatLimit, LandingReach, Requirements, SunKeepOut};
pub use surface_wind::check_wind_at_start;
pub use watch::{Findings, Watch};

pub(crate) use sensors::sun_margin_deg;
pub(crate) use start::{StartConditions, check_start};
pub(crate) use statement::{Stated, state};

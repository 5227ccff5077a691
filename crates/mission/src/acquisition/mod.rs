//! Data acquisition: manoeuvres for the mission's vehicle and targets in PDL notation, and their synthesis from goals `(acquire TARGET
//! ..)`.
//!
//! Predictions come from `apex_observation::manoeuvres`; a goal is answered with a typed procedure (docs/reference/manoeuvres.md).

mod answer;
mod candidates;
mod checks;
mod data_mode;
mod form;
mod goal;
mod modes;
mod pareto;
mod paths;
mod permitted;
mod predicted;
mod risk;
mod solve;
mod sweep_form;
mod vehicle;

pub(crate) use answer::pose;
pub use answer::synthesised;
pub(crate) use candidates::{ManoeuvreCandidate, at_height, heights_m};
pub(crate) use checks::{closed_by, ground_kept, sun_miss};
pub(crate) use form::form_of;
pub use goal::check_goals;
pub(crate) use goal::is_goal;
pub(crate) use goal::{AcquisitionGoal, ProductKind};
pub(crate) use paths::register;
pub(crate) use predicted::forecast_of;
pub use predicted::{PerformedManoeuvre, forecast};
pub(crate) use vehicle::{craft_of, scene_of};

/// Name of the planner of acquisition goals in missions.
pub(crate) const SOLVER: &str = "acquisition";

//! Bodies and parameters of the flight addresses, and the checks of their values.

use crate::answer::{ApiError, ApiResult};
use apex_model::time::{Duration, Time};
use serde::Deserialize;

/// Maximum pace. A flight as fast as possible has no pace.
const PACE_MAX: f64 = 1e9;
/// Latest end of a requested flight: a year.
const UNTIL_MAX_S: f64 = 366.0 * 86_400.0;
/// The longest time to plan in.
const BUDGET_MAX_S: f64 = 60.0;

/// The body of `POST /api/flights`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FlightRequest {
    /// Name of the mission.
    pub(crate) mission: String,
    /// Seed of the world; default is the mission's own.
    pub(crate) seed: Option<u64>,
    /// Mission time in seconds at which the flight ends at the latest; default is the mission's duration.
    until_s: Option<f64>,
    /// Mission seconds per second of wall time; default is as fast as possible, or 1 for a real-time mission.
    pace: Option<f64>,
}

/// Parameters of `/api/missions/{name}/plan`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanParams {
    /// Time to plan in, in seconds; default is the budget of the mission's first solver.
    budget_s: Option<f64>,
}

impl FlightRequest {
    /// Returns the latest end of the flight.
    ///
    /// # Errors
    /// If it is not a time after the start.
    pub(crate) fn until(&self) -> ApiResult<Option<Time>> {
        let seconds =
            in_range("until_s", self.until_s, UNTIL_MAX_S, "the mission time in seconds at which the flight ends")?;
        Ok(seconds.map(Time::from_seconds))
    }

    /// Returns the pace of the flight.
    ///
    /// # Errors
    /// Mission time would not advance.
    pub(crate) fn pace(&self) -> ApiResult<Option<f64>> {
        in_range("pace", self.pace, PACE_MAX, "the mission seconds per second: 1 is real time")
    }
}

impl PlanParams {
    /// Returns the time to plan in.
    ///
    /// # Errors
    /// If it is not a duration, or too long.
    pub(crate) fn budget(&self) -> ApiResult<Option<Duration>> {
        let seconds = in_range("budget_s", self.budget_s, BUDGET_MAX_S, "the time to plan in, in seconds")?;
        Ok(seconds.map(|seconds| Time::from_seconds(seconds) - Time::ZERO))
    }
}

/// Returns `value` if it is above 0 and at most `max`.
fn in_range(name: &str, value: Option<f64>, max: f64, meaning: &str) -> ApiResult<Option<f64>> {
    match value {
        Some(value) if !(value > 0.0 && value <= max) => Err(ApiError::bad_request(
            format!("`{name}` is {value}, which is not above 0 and at most {max}"),
            format!("write {meaning}, or leave `{name}` out"),
        )),
        other => Ok(other),
    }
}

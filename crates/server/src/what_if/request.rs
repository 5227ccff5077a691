//! The bodies of requests for forks and drafts.

use crate::answer::{ApiError, ApiResult};
use apex_mission::fork::Changes;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_runtime::reserved::{self, Entrance};
use serde::Deserialize;

/// The body of `POST /api/forks`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ForkRequest {
    /// The instant from which the flight differs, nanoseconds of mission time.
    pub(crate) at_ns: i64,
    /// Factor of the wind that blows after the instant.
    pub(crate) wind_factor: Option<f64>,
    /// Seed of turbulence and radio links after the instant.
    pub(crate) seed: Option<u64>,
    /// Visits in this order instead of planning.
    #[serde(default)]
    pub(crate) plan: Vec<String>,
    /// Messages after the instant.
    #[serde(default)]
    inputs: Vec<InputRequest>,
}

/// A message at an instant.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct InputRequest {
    /// Seconds of mission time.
    t: f64,
    /// A form of PDL.
    event: String,
}

impl ForkRequest {
    /// Returns the changes of the mission's inputs and plan.
    ///
    /// # Errors
    /// A message that is not a form, or a factor out of range.
    pub(crate) fn changes(&self, read: &dyn Fn(&str) -> Result<Value, String>) -> ApiResult<Changes> {
        if self.wind_factor.is_some_and(|factor| !(0.0..=100.0).contains(&factor)) {
            return Err(ApiError::bad_request("`wind_factor` is not a number from 0 to 100", "send for example 2"));
        }
        let mut inputs = Vec::with_capacity(self.inputs.len());
        for InputRequest { t, event } in &self.inputs {
            let form = read(event).map_err(|error| {
                ApiError::bad_request(
                    format!("`{event}` is not a form of PDL: {error}"),
                    "write for example `(new-value ahorn 200)`",
                )
            })?;
            let kind = EventKind::Occurrence(form);
            reserved::check(&kind, Entrance::Outside)
                .map_err(|error| ApiError::bad_request(error, "write for example `(new-value ahorn 200)`"))?;
            inputs.push(Input::new(Time::from_seconds(*t), kind));
        }
        Ok(Changes { inputs, plan: self.plan.clone() })
    }

    /// Returns the changes as text; `None` if there are none.
    pub(crate) fn words(&self) -> Option<String> {
        let messages: Vec<&str> = self.inputs.iter().map(|input| input.event.as_str()).collect();
        let parts = [
            self.wind_factor.map(|factor| format!("wind times {factor}")),
            self.seed.map(|seed| format!("seed {seed}")),
            (!messages.is_empty()).then(|| format!("messages {}", messages.join(" "))),
            (!self.plan.is_empty()).then(|| format!("plan {}", self.plan.join(", "))),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// The body of `POST /api/drafts`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DraftRequest {
    /// The instant of the situation, nanoseconds of mission time; none is the record's end, for a flight under way now.
    pub(crate) at_ns: Option<i64>,
    /// Targets in the order of visits.
    pub(crate) visits: Vec<String>,
    /// True if the order is flown again and again.
    #[serde(default)]
    pub(crate) repeat: bool,
}

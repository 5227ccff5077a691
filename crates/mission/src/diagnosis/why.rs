//! Explains the health of a component at an instant of a recorded flight by the outcomes of tests.

use crate::error::MissionResult;
use crate::recorded::{mission_of, situation_at};
use apex_diagnosis::{Diagnoser, explain, explain_json};
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use std::sync::Arc;

/// Explanation of the health of a component.
pub struct ComponentHealth {
    /// As text.
    pub text: String,
    /// As JSON ([`explain_json`]).
    pub json: serde_json::Value,
}

/// Explains the health of `component` after the last step not later than `at`; `None` if no model of the record's mission contains it.
///
/// # Errors
/// A record that cannot be read.
pub fn why(reader: &RecordReader, component: &str, at: Time) -> MissionResult<Option<ComponentHealth>> {
    let Some(mission) = mission_of(reader)? else { return Ok(None) };
    let Some(model) = mission.diagnosis.as_ref().filter(|model| model.component(component).is_some()) else {
        return Ok(None);
    };
    let situation = situation_at(reader, &mission, at)?;
    let mut diagnoser = Diagnoser::new(Arc::clone(model));
    diagnoser.report_all(situation.diagnosis.reports());
    let answer = explain(&diagnoser, component).zip(explain_json(&diagnoser, component));
    Ok(answer.map(|(text, json)| ComponentHealth { text, json }))
}

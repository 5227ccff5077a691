//! Diagnosis by a dependency model: model files, the service that diagnoses in flight, and explanations of a component's health.

mod service;
mod why;

pub use service::DiagnosisService;
pub use why::{ComponentHealth, why};

use crate::error::{MissionError, MissionResult};
use crate::files::read_text;
use apex_diagnosis::{Diagnoser, DiagnosisError, Model, Results, testability};
use std::path::Path;
use std::sync::Arc;

/// Query to a model file, without a flight.
#[derive(Clone, Copy, Debug)]
pub enum ModelQuery<'a> {
    /// Its testability.
    Report,
    /// The diagnosis for the test outcomes in this file.
    Results(&'a Path),
    /// The PDL that is generated from the model.
    Pdl,
}

/// Returns the answer to a query as text or as JSON; PDL is always text.
///
/// # Errors
/// An error that names the model or results file that cannot be read or is invalid.
pub fn answer(path: &Path, wanted: ModelQuery<'_>, json: bool) -> MissionResult<String> {
    let model = parse(&path.display().to_string(), &read_text(path)?)?;
    let shown = |value: serde_json::Value| format!("{value:#}\n");
    Ok(match wanted {
        ModelQuery::Pdl => model.pdl(),
        ModelQuery::Report => {
            let report = testability(&model);
            if json { shown(report.json(&model)) } else { report.text(&model) }
        }
        ModelQuery::Results(results) => {
            let results =
                Results::parse(&results.display().to_string(), &read_text(results)?, &model).map_err(invalid)?;
            let mut diagnoser = Diagnoser::thorough(model);
            diagnoser.set_all(results.outcomes.into_iter().enumerate());
            if json { shown(diagnoser.json()) } else { diagnoser.text() }
        }
    })
}

/// Reads the text of a model file; `file` is its name in errors.
///
/// # Errors
/// Like [`Model::parse`].
pub(crate) fn parse(file: &str, text: &str) -> MissionResult<Arc<Model>> {
    Model::parse(file, text).map(Arc::new).map_err(invalid)
}

fn invalid(error: DiagnosisError) -> MissionError {
    MissionError::data(error.headline()).because(&error.reason).help(error.help)
}

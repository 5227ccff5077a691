//! Blocks about dependency models: `testability MODEL` and `diagnosis MODEL`, for a model that ships with Apex. The block `outcomes`
//! before a diagnosis holds the JSON of a results file.

use apex_diagnosis::{Diagnoser, Model, Results, testability};
use std::path::Path;
use std::sync::Arc;

fn model(name: &str) -> Result<Arc<Model>, String> {
    let file = format!("{name}.json");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../library/diagnosis").join(&file);
    let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    Model::parse(&file, &text).map(Arc::new).map_err(|error| error.to_string())
}

/// Returns the report of a model.
///
/// # Errors
/// An unknown model.
pub fn report(name: &str) -> Result<String, String> {
    let model = model(name)?;
    Ok(testability(&model).text(&model))
}

/// Returns the diagnosis of outcomes.
///
/// # Errors
/// An unknown model, outcomes that cannot be read.
pub fn answer(name: &str, outcomes: &str) -> Result<String, String> {
    let model = model(name)?;
    let results = Results::parse("outcomes", outcomes, &model).map_err(|error| error.to_string())?;
    let mut diagnoser = Diagnoser::new(model);
    diagnoser.set_all(results.outcomes.into_iter().enumerate());
    Ok(diagnoser.text())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_models_and_tests_are_errors() {
        assert!(report("nonsense").is_err());
        assert!(answer("observation-uav", "{\"failed\": [\"nonsense\"]}").is_err());
        assert!(answer("observation-uav", "").is_err());
    }
}

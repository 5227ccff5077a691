//! Reader of results files, which give outcomes of tests by name.

use crate::error::{DiagnosisError, FileName, nearest};
use crate::evidence::Outcome;
use crate::model::Model;
use serde::Deserialize;

/// Outcomes of a model's tests, by index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Results {
    /// One outcome for each test of the model.
    pub outcomes: Vec<Outcome>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[serde(default)]
    passed: Vec<String>,
    #[serde(default)]
    failed: Vec<String>,
    #[serde(default)]
    intermittent: Vec<String>,
    #[serde(default)]
    unknown: Vec<String>,
    #[serde(default)]
    others: Outcome,
}

impl Results {
    /// Reads the text of a results file for `model`; `file` is its name in errors.
    ///
    /// # Errors
    /// Text that is not JSON; members that are unknown, repeated or of the wrong type; a test that the model does not have, or that has
    /// two outcomes; no outcome at all.
    pub fn parse(file: &str, text: &str, model: &Model) -> Result<Results, DiagnosisError> {
        let file = FileName(file);
        let raw: Raw = serde_json::from_str(text).map_err(|error| file.unreadable(&error))?;
        let mut outcomes = vec![None; model.tests.len()];
        let lists = [
            ("passed", &raw.passed, Outcome::Passed),
            ("failed", &raw.failed, Outcome::Failed),
            ("intermittent", &raw.intermittent, Outcome::Intermittent),
            ("unknown", &raw.unknown, Outcome::Unknown),
        ];
        for (list, names, outcome) in lists {
            for (index, name) in names.iter().enumerate() {
                let place = format!("{list}[{index}]");
                let known = || model.tests.iter().map(|test| test.name.as_str());
                let Some(slot) = model.test(name).and_then(|test| outcomes.get_mut(test)) else {
                    let reason = format!("model `{}` has no test `{name}`", model.name);
                    return Err(file.error(place, reason, nearest(name, known())));
                };
                if slot.is_some() {
                    let reason = format!("`{name}` already has an outcome");
                    return Err(file.error(place, reason, "name each test once"));
                }
                *slot = Some(outcome);
            }
        }
        if outcomes.iter().all(Option::is_none) && raw.others == Outcome::Unknown {
            let help = "list tests under `passed`, `failed` or `intermittent`, or write `\"others\": \"passed\"`";
            return Err(file.error("", "it states no outcome of a test", help));
        }
        Ok(Results { outcomes: outcomes.into_iter().map(|outcome| outcome.unwrap_or(raw.others)).collect() })
    }
}

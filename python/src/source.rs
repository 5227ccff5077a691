//! The condition's text, and the library with its declarations.

use crate::errors::ConditionError;
use apex_model::condition::Condition;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_pdl::{CheckOptions, HostSignature, Requirement, Severity, SourceText, Unresolved};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A condition ready to be watched.
pub(crate) struct Ready {
    pub(crate) condition: Condition,
    pub(crate) library: Arc<Library>,
    pub(crate) host: HostFunctions,
    /// Warnings about both, rendered; empty without any.
    pub(crate) warnings: String,
}

/// Reads `condition` in terms of `library`, a name and its text. Files that the library requires are looked for in
/// `folder`.
///
/// # Errors
/// `ConditionError` with the messages as printed by `apex check`.
pub(crate) fn read(condition: &str, library: Option<(String, String)>, folder: Option<PathBuf>) -> PyResult<Ready> {
    let signatures: Vec<HostSignature> =
        apex_geo::functions::host_signatures().into_iter().map(HostSignature::pure).collect();
    let mut resolve = |requirement: Requirement| required(requirement, folder.as_deref());
    let sources = library.into_iter().map(|(name, text)| SourceText { name, text }).collect();
    let text = SourceText { name: "the condition".to_string(), text: condition.to_string() };
    let options = CheckOptions { fragment: false, host: &signatures, resolve: &mut resolve };
    let apex_pdl::CheckedConditions { checked, mut conditions } =
        apex_pdl::check_conditions(sources, vec![text], options);
    let rendered = |severity: Severity| {
        let kept: Vec<_> = checked.diagnostics.iter().filter(|each| each.severity == severity).cloned().collect();
        apex_pdl::render(&kept, &checked.library.sources, false)
    };
    if checked.has_errors() {
        return Err(ConditionError::new_err(rendered(Severity::Error)));
    }
    let warnings = rendered(Severity::Warning);
    match (conditions.pop(), conditions.is_empty()) {
        (Some(condition), true) => {
            let host = apex_geo::functions::host_functions();
            Ok(Ready { condition, library: Arc::new(checked.library), host, warnings })
        }
        (None, _) => Err(ConditionError::new_err("the text holds no condition")),
        (Some(_), false) => Err(ConditionError::new_err(
            "the text holds several conditions; combine them by :and or :or, or watch each by a separate Monitor",
        )),
    }
}

fn required(requirement: Requirement, folder: Option<&Path>) -> std::result::Result<SourceText, Unresolved> {
    match requirement {
        Requirement::File { name, .. } => {
            let Some(folder) = folder else {
                return Err(
                    "the library was handed over as text; hand over its path, so that files next to it are found"
                        .into(),
                );
            };
            let path = folder.join(&name);
            let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
            Ok(SourceText { name: path.display().to_string(), text })
        }
        Requirement::Library(name) => {
            Err(format!("the package ships no library {name:?}; require its file instead").into())
        }
    }
}

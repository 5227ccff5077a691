//! The missions of the folder: names, titles, and the reasons for which some do not load.

use crate::answer::{ApiError, ApiResult, Help};
use apex_mission::Mission;
use apex_mission::error::{ErrorKind, MissionError};
use axum::http::StatusCode;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The longest name of a mission, in bytes.
const NAME_MAX: usize = 100;
/// Maximum number of missions in one answer; the others can still be flown.
const LISTED_MAX: usize = 200;
/// Maximum number of names in the help of an unknown name.
const NAMES_TOLD_MAX: usize = 12;

/// One mission in `/api/missions`.
#[derive(Debug, Serialize)]
pub(crate) struct MissionEntry {
    /// Name of its folder, which identifies the mission.
    name: String,
    /// Title, if it loads.
    title: Option<String>,
    /// True if the mission can be loaded.
    loads: bool,
    /// Failure to load, if any.
    failure: Option<Failure>,
}

/// Failure with reason, place and remedy.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Failure {
    /// Failure.
    pub(crate) message: String,
    /// Reason, if known.
    pub(crate) reason: Option<String>,
    /// Remedy, if known.
    pub(crate) help: Option<String>,
    /// File, line or option with the error, if there is one.
    pub(crate) place: Option<String>,
}

impl From<MissionError> for Failure {
    fn from(error: MissionError) -> Failure {
        let MissionError { place, message, reason, help, .. } = error.first_diagnostic();
        Failure { message, reason, help, place }
    }
}

impl From<MissionError> for ApiError {
    fn from(error: MissionError) -> ApiError {
        let status = match error.kind {
            ErrorKind::Record | ErrorKind::RecordFile | ErrorKind::Output | ErrorKind::Input | ErrorKind::Flight => {
                StatusCode::INTERNAL_SERVER_ERROR
            }
            _ => StatusCode::UNPROCESSABLE_ENTITY,
        };
        let error = error.first_diagnostic();
        let headline = error.headline();
        ApiError {
            status,
            error: error.reason.map_or(headline.clone(), |reason| format!("{headline}: {reason}")),
            help: error.help.map_or_else(|| "`/api/missions` shows which missions load".into(), Help::from),
        }
    }
}

/// Lists the missions of `folder` by name.
///
/// # Errors
/// The folder cannot be read.
pub(crate) fn missions(folder: &Path) -> ApiResult<Vec<MissionEntry>> {
    let entry = |name: String| match Mission::load(&folder.join(&name)) {
        Ok(mission) => MissionEntry { name, title: Some(mission.settings.name), loads: true, failure: None },
        Err(error) => MissionEntry { name, title: None, loads: false, failure: Some(error.into()) },
    };
    Ok(names(folder)?.into_iter().take(LISTED_MAX).map(entry).collect())
}

/// Returns the folder of the mission called `name`.
///
/// # Errors
/// The name is not that of a sub-folder, or the folder has no mission of this name.
pub(crate) fn folder_of(folder: &Path, name: &str) -> ApiResult<PathBuf> {
    if !is_name(name) {
        return Err(ApiError::bad_request(
            "the name of the mission is not the name of a folder",
            format!("write at most {NAME_MAX} bytes, no `/`, `\\` or `:`, and no `.` at the beginning"),
        ));
    }
    let path = folder.join(name);
    if path.join("mission.pdl").is_file() {
        return Ok(path);
    }
    let mut known = names(folder)?;
    known.truncate(NAMES_TOLD_MAX);
    Err(ApiError::not_found(
        format!("there is no mission `{name}` in {}", folder.display()),
        format!("the folder holds: {}", known.join(", ")),
    ))
}

fn names(folder: &Path) -> ApiResult<Vec<String>> {
    let entries = std::fs::read_dir(folder).map_err(|error| ApiError {
        status: StatusCode::INTERNAL_SERVER_ERROR,
        error: format!("the folder of missions {} cannot be read: {error}", folder.display()),
        help: "start the server again with a folder that exists (`--missions`)".into(),
    })?;
    let mut names: Vec<String> = entries
        .flatten()
        .filter(|entry| entry.path().join("mission.pdl").is_file())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| is_name(name))
        .collect();
    names.sort();
    Ok(names)
}

/// Returns true if `name` can only be that of an entry of the folder itself.
fn is_name(name: &str) -> bool {
    let plain = |character: char| !character.is_control() && !matches!(character, '/' | '\\' | ':');
    !name.is_empty() && name.len() <= NAME_MAX && !name.starts_with('.') && name.chars().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_paths_are_no_names() {
        for name in ["structure-watch", "a b", "a..b", "Übung"] {
            assert!(is_name(name), "{name}");
        }
        for name in ["", ".", "..", "../a", "a/b", "a\\b", "c:a", ".git", "a\0b", &"a".repeat(NAME_MAX + 1)] {
            assert!(!is_name(name), "{name}");
        }
    }
}

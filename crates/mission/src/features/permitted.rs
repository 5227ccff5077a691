//! Ids and latitudes that missions permit.

use crate::error::{MissionError, MissionResult};

/// Latitudes of missions are below this, north and south, degrees: nearer to the poles, planners and the checker of turns disagree.
const LATITUDE_DEG_MAX: f64 = 88.0;

/// Checks that an id has the characters of symbols of PDL that need no quotes.
///
/// # Errors
/// The first other character.
pub(super) fn id(id: &str, trouble: impl Fn(String) -> MissionError) -> MissionResult<()> {
    let is_permitted = |letter: char| letter.is_alphanumeric() || matches!(letter, '-' | '_' | '.');
    match id.chars().find(|letter| !is_permitted(*letter)) {
        None => Ok(()),
        Some(wrong) => Err(trouble(format!("the id {id:?} contains {wrong:?}"))
            .because("programs name features by their ids")
            .help("write letters, digits, hyphens, underscores and full stops")),
    }
}

/// Checks that a latitude is not too near to a pole; latitudes that do not exist are left to the caller.
///
/// # Errors
/// The latitude.
pub(super) fn latitude(latitude_deg: f64, trouble: impl Fn(String) -> MissionError) -> MissionResult<()> {
    if !(LATITUDE_DEG_MAX..=90.0).contains(&latitude_deg.abs()) {
        return Ok(());
    }
    Err(trouble(format!("latitude {latitude_deg} is too near to a pole"))
        .because("turns and lines are computed with meridians that are parallel in their neighbourhood")
        .help(format!("latitudes are below {LATITUDE_DEG_MAX} degrees, north and south")))
}

/// Returns the name in lower case, with a hyphen for each run of characters that are not letters or digits, and none at its ends.
pub(super) fn hyphenated(name: &str) -> String {
    let mut id = String::new();
    for character in name.chars().flat_map(char::to_lowercase) {
        if character.is_ascii_alphanumeric() {
            id.push(character);
        } else if !id.is_empty() && !id.ends_with('-') {
            id.push('-');
        }
    }
    id.trim_end_matches('-').to_string()
}

//! A README in every folder of the map: its contents, what is out of scope, where to look next. READMEs are short, so that they are read.

use crate::finding::Finding;
use crate::tree::{self, Text};

/// Maximum lines of a folder's README, without table rows. The index of decisions is longer and is not listed here.
const LINES_MAX: usize = 20;
/// Maximum lines of a mission's README: one screen.
const MISSION_LINES_MAX: usize = 45;
/// Folders of the map; `/*` means every folder directly below.
const FOLDERS: &[&str] =
    &["crates/*", "adapters", "adapters/*", "library", "missions", "spec", "web", "docs", "benches", "fuzz", "xtask"];

/// Checks that every such folder has a README of the right length.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let folders = FOLDERS.iter().flat_map(|folder| match folder.strip_suffix("/*") {
        Some(parent) => tree::folders_below(texts, parent),
        None => vec![folder.to_string()],
    });
    let folders = folders.filter_map(|folder| check_folder(texts, &folder, LINES_MAX));
    let missions = tree::folders_below(texts, "missions");
    let missions = missions.into_iter().filter_map(|mission| check_folder(texts, &mission, MISSION_LINES_MAX));
    folders.chain(missions).collect()
}

fn check_folder(texts: &[Text], folder: &str, lines_max: usize) -> Option<Finding> {
    let path = format!("{folder}/README.md");
    let message =
        match tree::find(texts, &path).map(|text| text.body.lines().filter(|line| !line.starts_with('|')).count()) {
            None => "missing: state contents, what is out of scope, and where to look next".to_string(),
            Some(lines) if lines > lines_max => {
                format!("{lines} lines, more than {lines_max}: move detail to docs/ and keep the signpost")
            }
            Some(_) => return None,
        };
    Some(Finding::new(&path, 1, "readme", message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_without_readme_fails_and_a_long_one_too() {
        let code = Text::sample("crates/geo/src/lib.rs", "//! x\n");
        let found = check(std::slice::from_ref(&code));
        assert!(found.iter().any(|finding| finding.path == "crates/geo/README.md"));
        let long = Text::sample("crates/geo/README.md", &format!("{}| row |\n", "line\n".repeat(21)));
        let found = check(&[code, long]);
        assert!(found.iter().any(|finding| finding.path == "crates/geo/README.md" && finding.message.contains("21")));
    }

    #[test]
    fn a_short_one_passes() {
        assert_eq!(check_folder(&[Text::sample("web/README.md", "# Sherpa\n")], "web", LINES_MAX), None);
    }
}

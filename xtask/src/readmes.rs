//! A README in every room: what lives here, what must not, where next. Short, because long ones are not read.

use crate::finding::Finding;
use crate::tree::{self, Text};

/// Lines of a room's README; rows of tables, such as the list of decisions, do not count.
const LINES_MAX: usize = 20;
/// Lines of a mission's README: one screen.
const MISSION_LINES_MAX: usize = 45;
/// Rooms; `/*` means every folder directly below.
const ROOMS: &[&str] = &[
    "crates/*",
    "adapters",
    "adapters/*",
    "library",
    "missions",
    "spec",
    "web",
    "docs",
    "docs/decisions",
    "benches",
    "xtask",
];

/// Checks that every room has a README of the right length.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let rooms = ROOMS.iter().flat_map(|room| match room.strip_suffix("/*") {
        Some(parent) => tree::folders_below(texts, parent),
        None => vec![room.to_string()],
    });
    let rooms = rooms.filter_map(|room| check_room(texts, &room, LINES_MAX));
    let missions = tree::folders_below(texts, "missions");
    let missions = missions.into_iter().filter_map(|mission| check_room(texts, &mission, MISSION_LINES_MAX));
    rooms.chain(missions).collect()
}

fn check_room(texts: &[Text], room: &str, lines_max: usize) -> Option<Finding> {
    let path = format!("{room}/README.md");
    let message =
        match tree::find(texts, &path).map(|text| text.body.lines().filter(|line| !line.starts_with('|')).count()) {
            None => "missing: say what lives here, what must not, and where to look next".to_string(),
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
        assert_eq!(check_room(&[Text::sample("web/README.md", "# Sherpa\n")], "web", LINES_MAX), None);
    }
}

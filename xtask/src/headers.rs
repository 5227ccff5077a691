//! Headers: every Rust file states its subject; every service of the executive fills in the fixed headings.

use crate::finding::Finding;
use crate::tree::{self, Text};

/// Headings of a service's header, in this order.
pub(crate) const HEADINGS: &[&str] = &["What", "Runs", "Reads", "Writes", "Bound", "PDL", "Paper"];
/// Folders whose files are services.
pub(crate) const FAMILIES: &[&str] = &["phases", "monitoring", "control", "deliberation"];

/// Checks all Rust texts.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for text in texts.iter().filter(|text| text.path.ends_with(".rs")) {
        if !text.body.starts_with("//!") {
            let message = "the first line must begin with `//!` and say what lives in this file";
            findings.push(Finding::new(&text.path, 1, "header", message));
        }
        if let Some((folder, module)) = service(&text.path) {
            findings.extend(check_service(text));
            findings.extend(check_listed(texts, text, folder, module));
        }
    }
    findings
}

/// Returns the folder and module name, if the path is a service of the executive.
pub(crate) fn service(path: &str) -> Option<(&str, &str)> {
    let inside = path.strip_prefix("crates/executive/src/")?;
    let (folder, file) = path.rsplit_once('/')?;
    let module = file.strip_suffix(".rs").filter(|name| *name != "mod")?;
    let is_test = inside.split('/').any(|part| part == "tests");
    (!is_test && family(folder).is_some()).then_some((folder, module))
}

/// Returns the family of a folder of the executive; services may be in folders below it.
pub(crate) fn family(folder: &str) -> Option<&str> {
    let family = folder.strip_prefix("crates/executive/src/")?.split('/').next()?;
    FAMILIES.contains(&family).then_some(family)
}

fn check_service(text: &Text) -> Vec<Finding> {
    let sections = sections(&text.body);
    let mut findings = Vec::new();
    let mut last = 0;
    for heading in HEADINGS {
        let position = sections.iter().position(|(name, _)| name == heading);
        let message = match position {
            None => format!("the header lacks `{heading}:`; a service states {}", HEADINGS.join(", ")),
            Some(index) if sections.get(index).is_none_or(|(_, words)| words.is_empty()) => {
                format!("`{heading}:` is empty: say it in one sentence")
            }
            Some(index) if index < last => {
                format!("`{heading}:` is out of order; the order is {}", HEADINGS.join(", "))
            }
            Some(index) => {
                last = index;
                continue;
            }
        };
        findings.push(Finding::new(&text.path, 1, "service-header", message));
    }
    findings
}

/// Returns a finding for a service that its folder's `mod.rs` does not declare, because the compiler ignores such a file.
fn check_listed(texts: &[Text], text: &Text, folder: &str, module: &str) -> Option<Finding> {
    let list = tree::find(texts, &format!("{folder}/mod.rs")).or_else(|| tree::find(texts, &format!("{folder}.rs")));
    let declared = |body: &str| body.lines().any(|line| line.trim_end().ends_with(&format!("mod {module};")));
    if list.is_some_and(|list| declared(&list.body)) {
        return None;
    }
    let message = format!("no `mod {module};` in {folder}/mod.rs: list the service there or delete the file");
    Some(Finding::new(&text.path, 1, "service-listed", message))
}

/// Returns the title line and the headed parts of a file's `//!` block, in written order.
pub(crate) fn sections(body: &str) -> Vec<(&'static str, String)> {
    let block: Vec<&str> = body.lines().map_while(|line| line.strip_prefix("//!")).skip(1).collect();
    let words = block.iter().flat_map(|line| line.split_whitespace());
    let mut sections: Vec<(&'static str, String)> = Vec::new();
    for word in words {
        let heading = word.strip_suffix(':').and_then(|name| HEADINGS.iter().find(|heading| **heading == name));
        match (heading, sections.last_mut()) {
            (Some(heading), _) => sections.push((heading, String::new())),
            (None, Some((_, text))) => {
                if !text.is_empty() {
                    text.push(' ');
                }
                text.push_str(word);
            }
            (None, None) => {}
        }
    }
    sections
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATH: &str = "crates/executive/src/monitoring/episodes/episode.rs";
    const GOOD: &str = "//! Episode detection (M&I)\n//! What: finds runs.  Runs: on sample.  Reads: History.\n//! Writes: Monitor.\n//! Bound: O(1).  PDL: `:episode`.  Paper: App. B.\n";

    fn with_list(body: &str) -> Vec<Finding> {
        let list =
            Text::sample("crates/executive/src/monitoring/episodes/mod.rs", "//! Services.\npub(crate) mod episode;\n");
        check(&[list, Text::sample(PATH, body)])
    }

    #[test]
    fn a_whole_header_passes() {
        assert_eq!(with_list(GOOD), []);
    }

    #[test]
    fn a_missing_an_empty_and_a_misplaced_heading_fail() {
        assert_eq!(with_list(&GOOD.replace("Bound: O(1).  ", ""))[0].rule, "service-header");
        assert!(with_list(&GOOD.replace("O(1).", ""))[0].message.contains("empty"));
        let swapped = GOOD.replace("Runs: on sample.  Reads: History.", "Reads: History.  Runs: on sample.");
        assert!(with_list(&swapped)[0].message.contains("order"));
    }

    #[test]
    fn a_file_without_header_fails() {
        let found = check(&[Text::sample("crates/geo/src/sun.rs", "fn a() {}\n")]);
        assert_eq!(found[0].rule, "header");
    }

    #[test]
    fn a_service_in_a_folder_of_its_family_is_checked() {
        let path = "crates/executive/src/monitoring/episodes/episode.rs";
        let found = check(&[Text::sample(path, &GOOD.replace("Bound: O(1).  ", ""))]);
        let rules: Vec<&str> = found.iter().map(|finding| finding.rule).collect();
        assert_eq!(rules, ["service-header", "service-listed"]);
        assert_eq!(service("crates/executive/src/monitoring/tests/stories.rs"), None);
    }

    #[test]
    fn an_unlisted_service_fails() {
        assert_eq!(check(&[Text::sample(PATH, GOOD)])[0].rule, "service-listed");
    }
}

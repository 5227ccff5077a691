//! The catalogue of reasoning and control services, generated from the headers of the services.

use crate::finding::Finding;
use crate::headers::{self, FAMILIES};
use crate::tree::{self, Text};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The generated page.
const PAGE: &str = "docs/reference/services.md";

/// Writes the page.
///
/// # Errors
/// A file that could not be read or written.
pub(crate) fn write(root: &Path) -> Result<String, String> {
    let page = render(&tree::read(root)?);
    fs::write(root.join(PAGE), page).map_err(|error| format!("cannot write {PAGE}: {error}"))?;
    Ok(format!("wrote {PAGE}"))
}

/// Checks that the page equals the one made from the headers.
pub(crate) fn check(texts: &[Text]) -> Option<Finding> {
    let current = tree::find(texts, PAGE).is_some_and(|text| text.body == render(texts));
    (!current)
        .then(|| Finding::new(PAGE, 1, "catalogue", "out of date: run `cargo xtask catalogue` and commit the page"))
}

/// Returns the page: one table for each folder of services, made from their headers.
fn render(texts: &[Text]) -> String {
    let mut page = String::from(
        "# Reasoning and control services\n\nGenerated from the headers in `crates/executive/src` by `cargo xtask catalogue`; do not edit.\nThe header of a source says in addition when the service runs, what it reads and writes, and its section of the paper.\n",
    );
    for family in FAMILIES {
        page.push_str(&format!("\n## {}\n", family_title(family)));
        let mut folders: BTreeMap<&str, String> = BTreeMap::new();
        for text in texts {
            if let Some((folder, module)) = headers::service(&text.path)
                && headers::family(folder) == Some(family)
            {
                folders.entry(folder).or_default().push_str(&entry(text, module));
            }
        }
        for (folder, rows) in folders {
            let short = folder.strip_prefix("crates/executive/src/").unwrap_or(folder);
            let head = "| service | what it does | bound | PDL |\n|---|---|---|---|\n";
            page.push_str(&format!("\n### `{short}`\n\n{head}{rows}"));
        }
    }
    page
}

fn family_title(family: &str) -> &'static str {
    match family {
        "phases" => "Phases of a step",
        "monitoring" => "Monitoring and interpretation",
        "control" => "Task control",
        _ => "Deliberation management",
    }
}

/// Returns the row of one service.
fn entry(text: &Text, module: &str) -> String {
    let sections = headers::sections(&text.body);
    let cell = |heading: &str| {
        let words = sections.iter().find(|(name, _)| *name == heading).map_or("", |(_, words)| words.as_str());
        words.replace('|', "\\|")
    };
    format!("| [{module}](../../{}) | {} | {} | {} |\n", text.path, cell("What"), cell("Bound"), cell("PDL"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_lags_behind_a_header_fails() {
        let service =
            Text::sample("crates/executive/src/control/conflicts/conflict.rs", "//! Conflict\n//! What: decides.\n");
        let page = Text::sample(PAGE, &render(std::slice::from_ref(&service)));
        assert!(page.body.contains("conflict.rs) | decides. |"), "{}", page.body);
        assert_eq!(check(&[service.clone(), page.clone()]), None);
        let changed = Text::sample(&service.path, "//! Conflict\n//! What: decides otherwise.\n");
        assert!(check(&[changed, page]).is_some());
        assert!(check(&[service]).is_some());
    }

    #[test]
    fn a_folder_with_files_before_and_after_its_subfolder_has_one_table() {
        let sample = |path: &str| Text::sample(path, "//! Name\n//! What: decides.\n");
        let paths = ["control/cycle.rs", "control/tasks/goal.rs", "control/transition.rs"];
        let texts = paths.map(|path| sample(&format!("crates/executive/src/{path}")));
        let page = render(&texts);
        assert_eq!(page.matches("### `control`").count(), 1, "{page}");
        assert_eq!(page.matches("decides.").count(), 3, "{page}");
    }
}

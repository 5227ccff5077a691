//! The catalogue of reasoning and control services, generated from the services' own headers.

use crate::finding::Finding;
use crate::headers::{self, FAMILIES, HEADINGS};
use crate::tree::{self, Text};
use std::fs;
use std::path::Path;

/// The generated page.
const PAGE: &str = "docs/reference/services.md";

/// Writes the page.
///
/// # Errors
/// What could not be read or written.
pub(crate) fn write(root: &Path) -> Result<String, String> {
    let page = render(&tree::read(root)?);
    fs::write(root.join(PAGE), page).map_err(|error| format!("cannot write {PAGE}: {error}"))?;
    Ok(format!("wrote {PAGE}"))
}

/// Checks that the page is what the headers say.
pub(crate) fn check(texts: &[Text]) -> Option<Finding> {
    let current = tree::find(texts, PAGE).is_some_and(|text| text.body == render(texts));
    (!current)
        .then(|| Finding::new(PAGE, 1, "catalogue", "out of date: run `cargo xtask catalogue` and commit the page"))
}

/// The page as the headers say it.
fn render(texts: &[Text]) -> String {
    let mut page = String::from(
        "# Reasoning and control services\n\nGenerated from the headers in `crates/executive/src` by `cargo xtask catalogue`; do not edit.\n",
    );
    for family in FAMILIES {
        page.push_str(&format!("\n## {}\n", family_title(family)));
        for text in texts {
            if let Some((folder, module)) = headers::service(&text.path)
                && headers::family(folder) == Some(family)
            {
                page.push_str(&entry(text, module));
            }
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

fn entry(text: &Text, module: &str) -> String {
    let title = text.body.lines().next().unwrap_or_default().trim_start_matches("//!").trim();
    let mut entry = format!("\n### {module}\n\n{title} ([source](../../{}))\n\n", text.path);
    let sections = headers::sections(&text.body);
    for heading in HEADINGS {
        if let Some((_, words)) = sections.iter().find(|(name, _)| name == heading) {
            entry.push_str(&format!("- **{heading}:** {words}\n"));
        }
    }
    entry
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_lags_behind_a_header_fails() {
        let service =
            Text::sample("crates/executive/src/control/conflicts/conflict.rs", "//! Conflict\n//! What: decides.\n");
        let page = Text::sample(PAGE, &render(std::slice::from_ref(&service)));
        assert!(page.body.contains("- **What:** decides."), "{}", page.body);
        assert_eq!(check(&[service.clone(), page.clone()]), None);
        let changed = Text::sample(&service.path, "//! Conflict\n//! What: decides otherwise.\n");
        assert!(check(&[changed, page]).is_some());
        assert!(check(&[service]).is_some());
    }
}

//! Lines of Markdown fit on a screen. Code fences, long links and rows of tables, which Markdown cannot wrap, are exempt;
//! rows of the pages that a newcomer reads first are not.

use crate::finding::Finding;
use crate::prose::ALLOW;
use crate::tree::Text;

pub(super) const RULE: &str = "columns";
/// Columns of a line.
pub(crate) const COLUMNS_MAX: usize = 140;
/// Pages whose tables must also fit.
const FIRST_PAGES: &[&str] =
    &["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "docs/README.md", "docs/decisions/README.md"];

/// Checks the lines of a Markdown text outside code fences.
pub(super) fn check(text: &Text) -> Vec<Finding> {
    let mut findings = Vec::new();
    if !text.path.ends_with(".md") {
        return findings;
    }
    let mut is_fenced = false;
    let checks_tables = FIRST_PAGES.contains(&text.path.as_str());
    for (index, line) in text.body.lines().enumerate() {
        let is_fence = line.trim_start().starts_with("```");
        is_fenced ^= is_fence;
        let columns = line.chars().count();
        let is_row = line.starts_with('|');
        let is_exempt = is_fenced || is_fence || is_row && !checks_tables || line.contains(ALLOW);
        let has_breaks = line.trim_start().trim_start_matches("- ").contains(' ');
        if columns > COLUMNS_MAX && !is_exempt && has_breaks {
            findings.push(Finding::new(&text.path, index + 1, RULE, format!("{columns} columns")));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(path: &str, body: &str) -> usize {
        check(&Text::sample(path, body)).len()
    }

    #[test]
    fn long_prose_is_found_and_what_cannot_be_wrapped_is_not() {
        let long = "word ".repeat(29);
        assert_eq!(count("a.md", &long), 1);
        assert_eq!(count("a.md", long.get(..140).unwrap()), 0);
        assert_eq!(count("a.rs", &long), 0);
        assert_eq!(count("a.md", &format!("```\n{long}\n```\n")), 0);
        assert_eq!(count("a.md", &"x".repeat(150)), 0);
        assert_eq!(count("a.md", &format!("| {long}|\n")), 0);
        assert_eq!(count("README.md", &format!("| {long}|\n")), 1);
    }
}

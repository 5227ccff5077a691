//! Texts of error types begin in lower case and end without a full stop, so that they can follow `error: ` or a colon.

use crate::finding::Finding;
use crate::prose::ALLOW;
use crate::tree::Text;

pub(super) const RULE: &str = "errors";
/// Begins the text of a variant (`thiserror`).
const ATTRIBUTE: &str = "#[error(";

/// Checks the texts of `#[error("..")]` in a Rust text, also where the text is in the next line.
pub(super) fn check(text: &Text) -> Vec<Finding> {
    let mut findings = Vec::new();
    if !text.path.ends_with(".rs") {
        return findings;
    }
    let lines: Vec<&str> = text.body.lines().collect();
    for (index, line) in lines.iter().enumerate() {
        let Some(rest) = line.trim_start().strip_prefix(ATTRIBUTE) else { continue };
        let rest = if rest.is_empty() { lines.get(index + 1).map_or("", |next| next.trim_start()) } else { rest };
        let Some(message) = rest.strip_prefix('"').and_then(literal) else { continue };
        let words = message.split(' ').next().unwrap_or_default();
        let is_acronym = words.chars().filter(|c| c.is_uppercase()).count() > 1;
        let begins_large = message.chars().next().is_some_and(char::is_uppercase) && !is_acronym;
        if (begins_large || message.ends_with('.')) && !line.contains(ALLOW) {
            let message = format!("`{message}` begins with a capital letter or ends with a full stop");
            findings.push(Finding::new(&text.path, index + 1, RULE, message));
        }
    }
    findings
}

/// Returns the text up to the closing quote.
fn literal(rest: &str) -> Option<&str> {
    let mut escaped = false;
    let end = rest.find(|c: char| {
        let is_end = c == '"' && !escaped;
        escaped = c == '\\' && !escaped;
        is_end
    })?;
    rest.get(..end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(body: &str) -> usize {
        check(&Text::sample("a.rs", body)).len()
    }

    #[test]
    fn capitals_and_full_stops_are_found() {
        assert_eq!(count("#[error(\"The file is gone\")]\n"), 1);
        assert_eq!(count("    #[error(\"a \\\"file\\\" is gone.\", path.display())]\n"), 1);
        assert_eq!(count("#[error(\n    \"The file is gone\",\n    path\n)]\n"), 1);
    }

    #[test]
    fn lower_case_acronyms_and_other_attributes_pass() {
        assert_eq!(count("#[error(\"the file {0} is gone\")]\n#[error(transparent)]\n"), 0);
        assert_eq!(count("#[error(\"JSON expected\")]\n#[error(\"SQLite failed\")]\n"), 0);
    }
}

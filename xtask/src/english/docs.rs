//! Doc comments state something: they are not questions, and they do not begin with a question word.

use crate::finding::Finding;
use crate::prose::ALLOW;
use crate::tree::Text;

pub(super) const QUESTION: &str = "doc-question";
pub(super) const WH: &str = "doc-wh";
const QUESTION_WORDS: &[&str] = &["What", "Which", "Who", "Whose", "Where", "How", "When", "Why"];

/// Checks all doc comments of a Rust text: every line for a final question mark, every first line for its first word.
pub(super) fn check(text: &Text) -> Vec<Finding> {
    let mut findings = Vec::new();
    if !text.path.ends_with(".rs") {
        return findings;
    }
    let mut previous = None;
    for (index, line) in text.body.lines().enumerate() {
        let comment = doc_comment(line);
        if let Some((kind, words)) = comment
            && !line.contains(ALLOW)
        {
            if words.ends_with('?') {
                findings.push(Finding::new(&text.path, index + 1, QUESTION, format!("`{words}` is a question")));
            }
            let is_first = previous != Some(kind);
            let first = words.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
            if is_first && QUESTION_WORDS.contains(&first) {
                let message = format!("`{words}` begins with a question word");
                findings.push(Finding::new(&text.path, index + 1, WH, message));
            }
        }
        previous = comment.map(|(kind, _)| kind);
    }
    findings
}

/// Returns the marker and the words of a line that is a doc comment.
fn doc_comment(line: &str) -> Option<(&str, &str)> {
    let line = line.trim_start();
    let (marker, words) = line.split_at_checked(3)?;
    (matches!(marker, "///" | "//!") && !words.starts_with('/')).then_some((marker, words.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(body: &str) -> Vec<&'static str> {
        check(&Text::sample("a.rs", body)).into_iter().map(|finding| finding.rule).collect()
    }

    #[test]
    fn a_question_and_a_question_word_are_found() {
        assert_eq!(rules("    /// Is it late?\n"), [QUESTION]);
        assert_eq!(rules("/// What is late.\n"), [WH]);
        assert_eq!(rules("//! Which is it?\n"), [QUESTION, WH]);
        assert_eq!(rules("//! Title.\n/// Where it is.\n"), [WH]);
    }

    #[test]
    fn headings_later_lines_and_other_comments_pass() {
        assert!(rules("//! Title\n//! What: does it.\n").is_empty());
        assert!(rules("// What is it?\n//// What?\nlet a = \"/// What?\";\n/// Whatever it is.\n").is_empty());
        assert!(rules("/// What is it? english: allow\n").is_empty());
        assert!(check(&Text::sample("a.md", "/// What?\n")).is_empty());
    }
}

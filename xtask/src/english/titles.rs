//! Titles of decisions are instructions or statements that can be read without the record.

use crate::finding::Finding;
use crate::tree::Text;

pub(super) const RULE: &str = "decision-title";
const FOLDER: &str = "docs/decisions/";
const INDEX: &str = "docs/decisions/README.md";
/// Characters of a title without its number.
const CHARACTERS_MAX: usize = 80;
/// First words of riddles.
const RIDDLES: &[&str] = &["Who", "Whose", "What", "Which", "Where", "When", "Why", "How", "From", "That"];

/// Checks the title of a decision record.
pub(super) fn check(text: &Text) -> Vec<Finding> {
    if !text.path.starts_with(FOLDER) || !text.path.ends_with(".md") || text.path == INDEX {
        return Vec::new();
    }
    let title = text.body.lines().next().unwrap_or_default();
    problem(title).into_iter().map(|problem| Finding::new(&text.path, 1, RULE, problem)).collect()
}

fn problem(title: &str) -> Option<String> {
    let Some((number, words)) = title.strip_prefix("# ").and_then(|title| title.split_once(' ')) else {
        return Some("the first line must be `# NUMBER Title`".into());
    };
    let first = words.split(' ').next().unwrap_or_default();
    if number.len() != 4 || !number.chars().all(|c| c.is_ascii_digit()) {
        Some(format!("`{number}` must be a number of four digits"))
    } else if RIDDLES.contains(&first) {
        Some(format!("the title begins with `{first}`"))
    } else if words.chars().count() > CHARACTERS_MAX {
        Some(format!("the title has {} characters", words.chars().count()))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(title: &str) -> usize {
        check(&Text::sample("docs/decisions/0001-a.md", title)).len()
    }

    #[test]
    fn riddles_long_titles_and_titles_without_number_are_found() {
        assert_eq!(count("# 0001 What counts as flown\n"), 1);
        assert_eq!(count(&format!("# 0001 Do {}\n", "x".repeat(78))), 1);
        assert_eq!(count("# Do it\n"), 1);
        assert_eq!(count("# 01 Do it\n"), 1);
        assert_eq!(count(""), 1);
    }

    #[test]
    fn instructions_and_the_index_pass() {
        assert_eq!(count("# 0001 Share the text of symbols\n"), 0);
        assert_eq!(check(&Text::sample(INDEX, "# Decisions\n")), []);
        assert_eq!(check(&Text::sample("docs/README.md", "# What\n")), []);
    }
}

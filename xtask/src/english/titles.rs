//! Titles of decisions are instructions or statements that are clear without the record, and the index lists each once.

use crate::finding::Finding;
use crate::tree::Text;

pub(super) const RULE: &str = "decision-title";
const FOLDER: &str = "docs/decisions/";
const INDEX: &str = "docs/decisions/README.md";
/// Characters of a title without its number.
const CHARACTERS_MAX: usize = 80;
/// First words of titles that ask a question or do not name their subject.
const RIDDLES: &[&str] = &["Who", "Whose", "What", "Which", "Where", "When", "Why", "How", "From", "That"];

/// Checks the title of a decision record.
pub(super) fn check(text: &Text) -> Vec<Finding> {
    if !text.path.starts_with(FOLDER) || !text.path.ends_with(".md") || text.path == INDEX {
        return Vec::new();
    }
    let title = text.body.lines().next().unwrap_or_default();
    problem(title).into_iter().map(|problem| Finding::new(&text.path, 1, RULE, problem)).collect()
}

/// Checks that the index links each decision record once, next to its title.
pub(super) fn check_index(texts: &[Text]) -> Vec<Finding> {
    let Some(index) = texts.iter().find(|text| text.path == INDEX) else { return Vec::new() };
    let entries = index.body.split("\n- ").skip(1).map(|entry| entry.split("\n#").next().unwrap_or_default());
    let entries: Vec<String> = entries.map(|entry| entry.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    let listed = |text: &&Text| {
        let file = text.path.strip_prefix(FOLDER).unwrap_or_default();
        let title = text.body.lines().next().unwrap_or_default().trim_start_matches("# ");
        let Some((number, words)) = title.split_once(' ') else { return true };
        entries.iter().filter(|entry| **entry == format!("[{number}]({file}) {words}")).count() == 1
    };
    let records = texts.iter().filter(|text| text.path.starts_with(FOLDER) && text.path != INDEX);
    let missing = records.filter(|text| text.path.ends_with(".md") && !listed(text));
    missing
        .map(|text| Finding::new(&text.path, 1, RULE, format!("{INDEX} must list the record once by its title")))
        .collect()
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
    fn the_index_lists_every_record_once_by_its_title() {
        let record = Text::sample("docs/decisions/0001-do.md", "# 0001 Do it\n");
        let findings = |index: &str| check_index(&[record.clone(), Text::sample(INDEX, index)]).len();
        assert_eq!(findings("# Decisions\n\n- [0001](0001-do.md) Do\n  it\n\n## Other\n"), 0);
        assert_eq!(findings("# Decisions\n\n- [0001](0001-do.md) Do that\n"), 1);
        assert_eq!(findings("# Decisions\n"), 1);
        let twice = "\n- [0001](0001-do.md) Do it";
        assert_eq!(findings(&format!("# Decisions\n{twice}{twice}\n")), 1);
    }

    #[test]
    fn instructions_and_the_index_pass() {
        assert_eq!(count("# 0001 Share the text of symbols\n"), 0);
        assert_eq!(check(&Text::sample(INDEX, "# Decisions\n")), []);
        assert_eq!(check(&Text::sample("docs/README.md", "# What\n")), []);
    }
}

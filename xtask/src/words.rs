//! One word for one thing: words that the glossary forbids, and marks of unfinished work.
//!
//! The list is the last column of the tables in `docs/glossary.md`: every text in backticks there is ruled out.

use crate::finding::Finding;
use crate::tree::{self, Text};

/// Path of the list of banned words.
const GLOSSARY: &str = "docs/glossary.md";
/// Marks of unfinished work, in pieces so that this file does not contain them.
const MARKS: &[&str] = &[concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X")];
/// Texts that must be able to name a banned word.
const EXEMPT: &[&str] = &[GLOSSARY, "xtask/src/words.rs"];

/// Checks all texts except manifests.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let Some(glossary) = tree::find(texts, GLOSSARY) else {
        return vec![Finding::new(GLOSSARY, 1, "words", "missing: it holds the terms and their banned synonyms")];
    };
    let banned = banned_words(&glossary.body);
    let checked = texts.iter().filter(|text| !text.path.ends_with(".toml") && !EXEMPT.contains(&text.path.as_str()));
    checked.flat_map(|text| check_text(text, &banned)).collect()
}

/// Pairs of a forbidden word in lower case and its replacement.
fn banned_words(glossary: &str) -> Vec<(String, String)> {
    let mut banned = Vec::new();
    for line in glossary.lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if let (Some(term), Some(last), 3) = (cells.first(), cells.last(), cells.len()) {
            let term = term.replace('*', "");
            banned.extend(last.split('`').skip(1).step_by(2).map(|word| (word.to_lowercase(), term.clone())));
        }
    }
    banned
}

fn check_text(text: &Text, banned: &[(String, String)]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, line) in text.body.lines().enumerate() {
        for mark in MARKS.iter().filter(|mark| contains_word(line, mark)) {
            let message = format!("`{mark}` marks unfinished work: finish it, or write it down where work is planned");
            findings.push(Finding::new(&text.path, index + 1, "words", message));
        }
        let folded = line.to_lowercase();
        for (word, term) in banned.iter().filter(|(word, _)| contains_word(&folded, word)) {
            let message = format!("`{word}` is ruled out by the glossary: say `{term}`");
            findings.push(Finding::new(&text.path, index + 1, "words", message));
        }
    }
    findings
}

/// Returns true if `word` occurs in `line` as a whole word. Letters, digits, `_` and `-` join words.
fn contains_word(line: &str, word: &str) -> bool {
    let joins = |character: Option<char>| character.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '-');
    line.match_indices(word).any(|(start, _)| {
        let before = line.get(..start).and_then(|text| text.chars().next_back());
        let after = line.get(start + word.len()..).and_then(|text| text.chars().next());
        !joins(before) && !joins(after)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(body: &str) -> Vec<Finding> {
        let glossary = Text::sample(
            GLOSSARY,
            "| term | meaning | do not say |\n|---|---|---|\n| **task** | a commitment | `to-do item` |\n",
        );
        check(&[glossary, Text::sample("a.rs", body)])
    }

    #[test]
    fn a_banned_synonym_is_named_with_the_right_word() {
        let found = findings("//! x\n// A To-do item here.\n");
        assert_eq!((found.len(), found[0].line), (1, 2));
        assert!(found[0].message.contains("say `task`"), "{}", found[0]);
    }

    #[test]
    fn marks_of_unfinished_work_fail_as_words_only() {
        assert_eq!(findings(concat!("// TO", "DO later\n")).len(), 1);
        assert_eq!(findings(concat!("// auTO", "DOcument\n")), []);
    }
}

//! Subjects of new commits: an imperative of at most 72 characters, one change.
//!
//! Checks commits after [`BASE`], or after [`BASE_TIME`] if a shallow clone does not have that commit. A checkout without git, such as an
//! unpacked archive, has no commits to check.

use crate::finding::Finding;
use crate::git;
use std::path::Path;

/// The last commit that is not checked.
const BASE: &str = "93b109cb2aeee49527cfbe7b490e33cc2c5adbb1";
/// Instant of [`BASE`]: older commits of branches that were merged later are not checked.
const BASE_TIME: &str = "2026-11-24T04:03:09Z";
const CHARACTERS_MAX: usize = 72;
/// Imperatives that end like other verb forms.
const IMPERATIVES: &[&str] = &[
    "address", "access", "assess", "bypass", "bring", "compress", "cross", "discuss", "dismiss", "embed", "exceed",
    "express", "feed", "focus", "guess", "miss", "need", "pass", "press", "proceed", "process", "redress", "seed",
    "shed", "speed", "stress", "string", "suppress", "swing", "toss",
];
/// First words that begin a noun phrase.
const ARTICLES: &[&str] = &["a", "an", "the", "what", "who", "which", "where", "when", "how", "why"];

/// Checks the subjects of new commits in the repository at `root`; merges are exempt.
pub(crate) fn check(root: &Path) -> Vec<Finding> {
    if !root.join(".git").exists() {
        return Vec::new();
    }
    let format = "--format=%h%x09%s";
    let since = format!("--since={BASE_TIME}");
    let range = format!("{BASE}..HEAD");
    let log = git::git(root, &["log", "--no-merges", &since, format, &range])
        .or_else(|_| git::git(root, &["log", "--no-merges", &since, format]));
    let log = log.unwrap_or_default();
    log.lines()
        .filter_map(|line| line.split_once('\t'))
        .filter_map(|(commit, subject)| finding(commit, subject))
        .collect()
}

fn finding(commit: &str, subject: &str) -> Option<Finding> {
    let problem = problem(subject)?;
    let message = format!("subject `{subject}`: {problem}; reword the commit");
    Some(Finding::new(&format!("commit {commit}"), 1, "commit-subject", message))
}

/// Returns the first rule that a subject breaks.
fn problem(subject: &str) -> Option<String> {
    let characters = subject.chars().count();
    let (area, words) = subject.split_once(": ").unwrap_or(("", subject));
    let is_area = area.replace(", ", "").split(' ').count() == 1;
    let words = if is_area { words } else { subject };
    let first = words.split(' ').next().unwrap_or_default().to_lowercase();
    if characters > CHARACTERS_MAX {
        Some(format!("{characters} characters, at most {CHARACTERS_MAX} are allowed"))
    } else if subject.contains(';') {
        Some("a semicolon joins two changes: make two commits".into())
    } else if subject.ends_with('.') {
        Some("it ends with a full stop".into())
    } else if !is_imperative(&first) {
        Some(format!("`{first}` is not an imperative"))
    } else {
        None
    }
}

/// Returns true unless the ending shows another form of a verb, or the word begins a noun phrase.
fn is_imperative(word: &str) -> bool {
    let is_word = !word.is_empty() && word.chars().all(|c| c.is_alphabetic() || c == '-');
    let is_form = ["ed", "ing", "s"].iter().any(|ending| word.ends_with(ending));
    is_word && !ARTICLES.contains(&word) && (!is_form || IMPERATIVES.contains(&word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn imperatives_with_and_without_area_pass() {
        for subject in [
            "Reject plans that visit unknown targets",
            "web: take the last interruption in the test of dense windows",
            "Pass the budget to planners",
            "solvers, geo: round several legs at a time",
        ] {
            assert_eq!(problem(subject), None, "{subject}");
        }
    }

    #[test]
    fn long_joined_ended_and_other_forms_fail() {
        for subject in [
            "A proof of few targets does not go back to the fast pass",
            "Fixes the planner",
            "Fixed the planner",
            "Fixing the planner",
            "geo: adds a test",
            "Fix the planner; add a test",
            "Fix the planner.",
            "Fix the planner, which did not stop when the budget of its request was already used up",
            "",
        ] {
            assert!(problem(subject).is_some(), "{subject}");
        }
    }

    #[test]
    fn a_checkout_without_git_has_nothing_to_check() {
        assert_eq!(check(Path::new("/nowhere")), []);
    }
}

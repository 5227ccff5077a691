//! Phrases to avoid in prose, listed in `xtask/phrases.tsv` with their replacements, and counted under a ceiling.
//!
//! A row is a regular expression, an expression for exceptions, and the advice. A line counts once per row. `english: allow` in a line
//! exempts it.

use crate::ceilings::{self, Counts, Keys};
use crate::finding::Finding;
use crate::prose::{self, ALLOW};
use crate::tree::{self, Text};
use regex::{Regex, RegexBuilder, RegexSet, RegexSetBuilder};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const LIST: &str = "xtask/phrases.tsv";
/// Table with the ceiling of each phrase.
pub(crate) const CEILING: &str = "xtask/phrases-ceiling.tsv";
/// Files whose tests name phrases.
const EXEMPT: &[&str] = &["xtask/src/phrases.rs", "xtask/src/prose.rs", "docs/reference/library.md"];
const SET_BYTES_MAX: usize = 1 << 26;

struct Phrases {
    rows: Vec<Phrase>,
    set: RegexSet,
}

struct Phrase {
    pattern: String,
    /// The phrase, and the pattern of its exceptions.
    unless: Option<(Regex, Regex)>,
    write: String,
}

/// A line with a phrase.
struct Hit<'a> {
    path: &'a str,
    line: usize,
    phrase: &'a Phrase,
    prose: String,
}

/// Checks that no phrase is more frequent than its ceiling.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let phrases = match Phrases::read(texts) {
        Ok(phrases) => phrases,
        Err(message) => return vec![Finding::new(LIST, 1, "phrases", message)],
    };
    let advice = |key: &str| {
        let write = phrases.rows.iter().find(|row| row.pattern == key).map_or("", |row| row.write.as_str());
        format!("write \"{write}\"; `cargo xtask phrases` lists the lines that differ from main")
    };
    ceilings::check(texts, CEILING, "phrases", &phrases.counts(texts), advice)
}

/// Returns today's number of lines with each phrase.
///
/// # Errors
/// An error in the list.
pub(crate) fn counts(texts: &[Text]) -> Result<Counts, String> {
    Ok(Phrases::read(texts)?.counts(texts))
}

/// Returns a report of all phrases in the lines that `changed` holds by path.
///
/// # Errors
/// An error in the list.
pub(crate) fn report(texts: &[Text], changed: &BTreeMap<String, BTreeSet<usize>>) -> Result<String, String> {
    let phrases = Phrases::read(texts)?;
    let mut lines = Vec::new();
    for text in texts {
        let Some(touched) = changed.get(&text.path) else { continue };
        for hit in phrases.hits(text).into_iter().filter(|hit| touched.contains(&hit.line)) {
            lines.push(format!("{}:{}: {} (write: {})", hit.path, hit.line, hit.prose.trim(), hit.phrase.write));
        }
    }
    let all: usize = phrases.counts(texts).values().sum();
    lines.push(format!("{} phrases in changed lines; {all} in all", lines.len()));
    Ok(lines.join("\n"))
}

/// Lowers the ceilings.
///
/// # Errors
/// Phrases that have become more frequent; files that cannot be read or written.
pub(crate) fn update(root: &Path, texts: &[Text]) -> Result<String, String> {
    ceilings::lower(root, CEILING, &counts(texts)?, Keys::Fixed)
}

impl Phrases {
    fn read(texts: &[Text]) -> Result<Phrases, String> {
        let list = tree::find(texts, LIST).ok_or("missing: it lists the phrases to avoid")?;
        let mut rows = Vec::new();
        for line in list.body.lines().skip(1) {
            let cells: Vec<&str> = line.split('\t').collect();
            let [pattern, unless, write] = cells.as_slice() else {
                return Err(format!("`{line}` does not have the three cells pattern, unless, write"));
            };
            let compile = |pattern: &str| {
                let built = RegexBuilder::new(pattern).case_insensitive(true).unicode(false).build();
                built.map_err(|error| format!("`{pattern}`: {error}"))
            };
            let unless = if unless.is_empty() { None } else { Some((compile(pattern)?, compile(unless)?)) };
            rows.push(Phrase { pattern: pattern.to_string(), unless, write: write.to_string() });
        }
        let set = RegexSetBuilder::new(rows.iter().map(|row| &row.pattern))
            .case_insensitive(true)
            .unicode(false)
            .size_limit(SET_BYTES_MAX)
            .dfa_size_limit(SET_BYTES_MAX)
            .build()
            .map_err(|error| error.to_string())?;
        Ok(Phrases { rows, set })
    }

    fn hits<'a>(&'a self, text: &'a Text) -> Vec<Hit<'a>> {
        let mut hits = Vec::new();
        if EXEMPT.contains(&text.path.as_str()) {
            return hits;
        }
        for (line, prose) in prose::lines(text) {
            if !self.set.is_match(&prose) || prose.contains(ALLOW) {
                continue;
            }
            for index in &self.set.matches(&prose) {
                if let Some(phrase) = self.rows.get(index)
                    && phrase.counts(&prose)
                {
                    hits.push(Hit { path: &text.path, line, phrase, prose: prose.clone() });
                }
            }
        }
        hits
    }

    fn counts(&self, texts: &[Text]) -> Counts {
        let mut counts: Counts = self.rows.iter().map(|row| (row.pattern.clone(), 0)).collect();
        for hit in texts.iter().flat_map(|text| self.hits(text)) {
            if let Some(count) = counts.get_mut(&hit.phrase.pattern) {
                *count += 1;
            }
        }
        counts
    }
}

impl Phrase {
    /// Returns true if the pattern matches anything except its exceptions.
    fn counts(&self, prose: &str) -> bool {
        self.unless.as_ref().is_none_or(|(pattern, unless)| pattern.is_match(&unless.replace_all(prose, "")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: &str = "pattern\tunless\twrite\n\\bis no\\b\t\\bthere is no\\b\tis not a\n\\btold\\b\t\treported\n";

    fn found(body: &str) -> Vec<Finding> {
        check(&[Text::sample(LIST, ROWS), Text::sample(CEILING, "\\btold\\b\t1\n"), Text::sample("a.rs", body)])
    }

    #[test]
    fn a_phrase_above_its_ceiling_is_named_with_the_advice() {
        assert_eq!(found("// Told once, told twice in a line.\nfn told() {}\n"), []);
        let twice = found("// told\n// Told\n");
        assert_eq!(twice.len(), 1);
        assert!(twice[0].message.contains("write \"reported\""), "{}", twice[0]);
    }

    #[test]
    fn exceptions_and_exempt_lines_do_not_count() {
        assert_eq!(found("// There is no way.\n"), []);
        assert_eq!(found("// This is no way.\n").len(), 1);
        assert_eq!(found("// There is no way, and this is no way.\n").len(), 1);
        assert_eq!(found("// This is no way. english: allow\n"), []);
    }

    #[test]
    fn the_report_shows_changed_lines_only() {
        let texts = [Text::sample(LIST, ROWS), Text::sample("a.rs", "// told\n// told\n")];
        let changed = BTreeMap::from([("a.rs".to_string(), BTreeSet::from([2]))]);
        let report = report(&texts, &changed).unwrap();
        assert!(report.starts_with("a.rs:2: // told (write: reported)\n1 phrases"), "{report}");
    }

    #[test]
    fn a_list_that_cannot_be_read_is_a_finding() {
        assert_eq!(check(&[Text::sample(LIST, "pattern\tunless\twrite\n(\t\tx\n")]).len(), 1);
        assert_eq!(check(&[]).len(), 1);
    }
}

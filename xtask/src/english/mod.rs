//! Rules for texts that need no phrase list: doc comments, type names, errors, titles of decisions, columns.
//!
//! Rules with findings count them by folder, or by type name, under the ceilings of `xtask/english-ceiling.tsv`.
//! `english: allow` in a line exempts it. The rules are explained in `docs/contributing/english.md`.

mod columns;
mod docs;
mod errors;
mod homonyms;
mod titles;

pub(crate) use columns::COLUMNS_MAX;

use crate::ceilings::{self, Counts, Keys};
use crate::finding::Finding;
use crate::git::Changes;
use crate::tree::Text;
use std::path::Path;

const CEILING: &str = "xtask/english-ceiling.tsv";
/// Folders whose subfolders are counted separately.
const SPLIT: &[&str] = &["crates", "adapters", "docs", "spec"];

/// Checks that no rule has more findings than its ceilings allow.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    let advice = |key: &str| {
        let rule = key.split(' ').next().unwrap_or_default();
        format!("{}; `cargo xtask english` lists the lines that differ from main", remedy(rule))
    };
    ceilings::check(texts, CEILING, "english", &counts(texts), advice)
}

/// Returns all findings in the lines that `changed` holds by path.
pub(crate) fn report(texts: &[Text], changed: &Changes) -> String {
    let all = findings(texts);
    let is_touched = |finding: &&Finding| changed.get(&finding.path).is_some_and(|lines| lines.contains(&finding.line));
    let mut lines: Vec<String> = all.iter().filter(is_touched).map(ToString::to_string).collect();
    lines.push(format!("{} findings in changed lines; {} in all", lines.len(), all.len()));
    lines.join("\n")
}

/// Lowers the ceilings.
///
/// # Errors
/// Counts that have risen; files that cannot be read or written.
pub(crate) fn update(root: &Path, texts: &[Text]) -> Result<String, String> {
    ceilings::lower(root, CEILING, &counts(texts), Keys::Fixed)
}

fn findings(texts: &[Text]) -> Vec<Finding> {
    let per_text = [docs::check, errors::check, titles::check, columns::check];
    let mut findings: Vec<Finding> =
        texts.iter().flat_map(|text| per_text.iter().flat_map(|rule| rule(text))).collect();
    findings.extend(homonyms::check(texts));
    findings.extend(titles::check_index(texts));
    findings
}

fn counts(texts: &[Text]) -> Counts {
    let mut counts = Counts::new();
    for finding in findings(texts) {
        *counts.entry(key(&finding)).or_default() += 1;
    }
    counts
}

/// Returns the rule and the folder of a finding; for a homonym the rule and the type name.
fn key(finding: &Finding) -> String {
    if finding.rule == homonyms::RULE {
        let name = finding.message.split('`').nth(1).unwrap_or_default();
        return format!("{} {name}", finding.rule);
    }
    let mut parts = finding.path.split('/');
    let first = parts.next().unwrap_or_default();
    let folder = match parts.next() {
        Some(second) if SPLIT.contains(&first) => format!("{first}/{second}"),
        _ => first.to_string(),
    };
    format!("{} {folder}", finding.rule)
}

fn remedy(rule: &str) -> &'static str {
    match rule {
        docs::QUESTION => "state it instead of asking it",
        docs::WH => "begin with a verb (Returns, Checks, ..) or with a noun",
        errors::RULE => "begin an error in lower case and end it without a full stop",
        homonyms::RULE => "qualify the name by the role of the type",
        titles::RULE => "make the title an instruction or a statement of at most 80 characters",
        _ => "run `cargo xtask wrap` on the file",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn sample(body: &str) -> Text {
        Text::sample("crates/geo/src/a.rs", body)
    }

    #[test]
    fn a_count_above_its_ceiling_is_named_with_its_folder() {
        let ceiling = Text::sample(CEILING, "doc-wh crates/geo\t1\n");
        assert_eq!(check(&[ceiling.clone(), sample("/// What is it\nfn a() {}\n")]), []);
        let found = check(&[ceiling, sample("/// What is it\nfn a() {}\n/// Where it is\nfn b() {}\n")]);
        assert_eq!(found.len(), 1);
        assert!(found[0].message.starts_with("2 of `doc-wh crates/geo`, the ceiling is 1: begin"), "{}", found[0]);
    }

    #[test]
    fn the_report_lists_changed_lines_only() {
        let texts = [sample("/// What\nfn a() {}\n/// Where\nfn b() {}\n")];
        let changed = Changes::from([("crates/geo/src/a.rs".to_string(), BTreeSet::from([3]))]);
        let report = report(&texts, &changed);
        assert!(report.starts_with("crates/geo/src/a.rs:3: [doc-wh]"), "{report}");
        assert!(report.ends_with("1 findings in changed lines; 2 in all"), "{report}");
    }
}

//! Paths named in documents must exist: links and backticks of Markdown that look like a path of the repository.
//!
//! A link is relative to its document. A text in backticks is found if it exists below the top folder, below the document's folder, or as
//! the end of an existing path (`control/selection.rs`). Documents about the past (decisions, the changelog) are left out. Code may name
//! pages of documents outside the repository; such names are counted under the ceilings of `xtask/pages-ceiling.tsv`.

use crate::ceilings::{self, Counts, Keys};
use crate::finding::Finding;
use crate::prose;
use crate::tree::Text;
use regex::Regex;
use std::collections::BTreeSet;
use std::path::Path;

const CEILING: &str = "xtask/pages-ceiling.tsv";
/// Documents that describe the past.
const PAST: &[&str] = &["docs/decisions/", "CHANGELOG.md"];
/// Generated from code: its names of absent pages are counted there.
const GENERATED: &str = "docs/reference/services.md";
/// Documents in these folders are pages that run or data, not descriptions of the repository.
const NOT_CHECKED: &[&str] = &["spec/", "benches/data/"];
/// Endings of files that only the repository has; other files may be the reader's.
const OWN_ENDINGS: &[&str] = &["rs", "md", "toml", "ts", "svelte"];
/// Folders of the repository, from which a path may begin.
const TOP: &[&str] =
    &["adapters", "benches", "crates", "docs", "examples", "library", "missions", "python", "spec", "web", "xtask"];
/// First parts of paths that are built, installed or written by a command.
const MADE: &[&str] = &["target", ".venv", "node_modules", "dist", "~", ".", ".."];

/// All paths of the repository.
pub(crate) struct Paths {
    /// Files and folders, and every end of their paths that begins at a folder's name.
    ends: BTreeSet<String>,
}

impl Paths {
    /// Returns the paths of `files` and of their folders.
    pub(crate) fn new(files: &[String]) -> Paths {
        let mut ends = BTreeSet::new();
        for file in files {
            let parts: Vec<&str> = file.split('/').collect();
            for end in 1..=parts.len() {
                for begin in 0..end {
                    ends.insert(parts.get(begin..end).unwrap_or_default().join("/"));
                }
            }
        }
        Paths { ends }
    }

    fn knows(&self, path: &str) -> bool {
        self.ends.contains(path.trim_end_matches('/'))
    }
}

/// Checks the documents.
pub(crate) fn check(paths: &Paths, texts: &[Text]) -> Vec<Finding> {
    let skipped = |path: &str| PAST.iter().chain(NOT_CHECKED).any(|start| path.starts_with(start));
    let documents = texts.iter().filter(|text| text.path.ends_with(".md") && !skipped(&text.path));
    let mut findings: Vec<Finding> = documents.flat_map(|text| check_document(paths, text)).collect();
    let advice = |page: &str| format!("say what it means here instead of naming {page}, or name a page in docs/");
    findings.extend(ceilings::check(texts, CEILING, "pages", &absent_pages(paths, texts), advice));
    findings
}

/// Lowers the ceilings of absent pages.
///
/// # Errors
/// Counts that have risen; files that cannot be read or written.
pub(crate) fn update(root: &Path, paths: &Paths, texts: &[Text]) -> Result<String, String> {
    ceilings::lower(root, CEILING, &absent_pages(paths, texts), Keys::Fixed)
}

fn check_document(paths: &Paths, text: &Text) -> Vec<Finding> {
    let folder = text.path.rsplit_once('/').map_or("", |(folder, _)| folder);
    let missing = |line: usize, path: &str, from: &str| {
        let message = format!("`{path}` does not exist {from}: name the present path");
        Finding::new(&text.path, line, "paths", message)
    };
    let mut findings = Vec::new();
    for (line, prose) in prose::lines(text) {
        for link in links(&prose) {
            if !joined(folder, link).is_some_and(|path| paths.ends.contains(&path)) {
                findings.push(missing(line, link, "seen from this document"));
            }
        }
        for path in quoted(&prose).into_iter().filter(|path| looks_like_path(path)) {
            let is_near = joined(folder, path).is_some_and(|path| paths.ends.contains(&path));
            let counted = text.path == GENERATED && path.ends_with(".md");
            if !paths.knows(path) && !is_near && !counted {
                findings.push(missing(line, path, "in the repository"));
            }
        }
    }
    findings
}

/// Targets of links to files, without the part after `#`.
fn links(prose: &str) -> Vec<&str> {
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let files = targets.map(|target| target.split('#').next().unwrap_or_default());
    files.filter(|target| !target.is_empty() && !target.contains(':')).collect()
}

/// Texts in single backticks.
fn quoted(prose: &str) -> Vec<&str> {
    prose.split('`').skip(1).step_by(2).collect()
}

/// Returns `path` relative to `folder`, without `.` and `..`; `None` if it leaves the repository.
fn joined(folder: &str, path: &str) -> Option<String> {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in path.split('/').filter(|part| !part.is_empty() && *part != ".") {
        if part == ".." {
            parts.pop()?;
        } else {
            parts.push(part);
        }
    }
    Some(parts.join("/"))
}

/// Returns true for a path with folders, or a file name that only the repository can have; false for patterns, addresses and expressions.
fn looks_like_path(word: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_' | '-');
    let made = |first: &str| MADE.contains(&first);
    let first = word.split('/').next().unwrap_or_default();
    if !word.chars().all(plain) || word.starts_with('/') || made(first) || word.split('/').any(made) {
        return false;
    }
    let ending = word.rsplit('/').next().and_then(|name| name.rsplit_once('.')).map(|(_, ending)| ending);
    let below_top = word.contains('/') && TOP.contains(&first);
    match ending {
        Some(ending) if OWN_ENDINGS.contains(&ending) => word.contains('/') || word.len() > ending.len() + 1,
        Some(_) => below_top,
        None => below_top || word.ends_with('/') && word.len() > 1,
    }
}

/// Returns names of pages in comments of code for which no file exists.
fn absent_pages(paths: &Paths, texts: &[Text]) -> Counts {
    let mut counts = Counts::new();
    let Ok(page) = Regex::new(r"\b[a-z][a-z0-9_/-]*\.md\b") else { return counts };
    let code = texts.iter().filter(|text| text.path.ends_with(".rs") && !text.path.starts_with("xtask/"));
    for (_, prose) in code.flat_map(prose::lines) {
        for found in page.find_iter(&prose).map(|found| found.as_str()).filter(|found| !paths.knows(found)) {
            *counts.entry(found.to_string()).or_default() += 1;
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(document: &str) -> Vec<String> {
        let files = ["crates/geo/src/sun.rs", "docs/guides/a.md", "docs/README.md"].map(str::to_string);
        let texts = [Text::sample("docs/README.md", document), Text::sample(CEILING, "")];
        check(&Paths::new(&files), &texts).into_iter().map(|finding| finding.message).collect()
    }

    #[test]
    fn existing_paths_pass() {
        assert!(found("`crates/geo/src/sun.rs` `geo/src` `sun.rs` `src/` `guides/a.md` [a](guides/a.md#x) [b](../crates/geo)\n").is_empty());
    }

    #[test]
    fn missing_paths_are_named() {
        for document in [
            "`geo/src/moon.rs`",
            "`moon.rs`",
            "`crates/moon/`",
            "`crates/moon`",
            "`docs/a.csv`",
            "[a](a.md)",
            "[a](../../x)",
        ] {
            assert_eq!(found(document).len(), 1, "{document}");
        }
    }

    #[test]
    fn what_is_not_a_path_of_the_repository_is_left_alone() {
        let document = "`m/s` `a / b` `planners/<name>` `*.rs` `flight.ulg` `/api/x` `target/x/` `text/html` [a](https://x.org/a.md)\n```\nmoon.rs\n```\n";
        assert!(found(document).is_empty(), "{:?}", found(document));
    }

    #[test]
    fn absent_pages_in_comments_are_counted() {
        let texts =
            [Text::sample(CEILING, "gone.md\t1\n"), Text::sample("a.rs", "// gone.md says: a.md\n// gone.md\n")];
        let paths = Paths::new(&["docs/a.md".to_string()]);
        let found = check(&paths, &texts);
        assert_eq!(found.len(), 1);
        assert!(found[0].message.starts_with("2 of `gone.md`"), "{}", found[0]);
    }
}

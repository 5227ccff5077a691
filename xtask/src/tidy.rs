//! All rules in one run.

use crate::tree;
use crate::{bans, catalogue, headers, imports, readmes, sizes, words};
use std::path::Path;

/// Checks every rule on the project below `root`; the text says how many files were read.
///
/// # Errors
/// All findings, one a line.
pub(crate) fn run(root: &Path) -> Result<String, String> {
    let texts = tree::read(root)?;
    let rules = [imports::check, sizes::check, headers::check, readmes::check, words::check, bans::check];
    let mut findings: Vec<_> = rules.iter().flat_map(|rule| rule(&texts)).collect();
    findings.extend(catalogue::check(&texts));
    findings.sort();
    if findings.is_empty() {
        return Ok(format!("tidy: {} texts, nothing to mend", texts.len()));
    }
    let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
    Err(format!("{}\ntidy: {} to mend", lines.join("\n"), lines.len()))
}

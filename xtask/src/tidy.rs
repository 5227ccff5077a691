//! All rules in one run.

use crate::tree;
use crate::workspace::Workspace;
use crate::{
    bans, catalogue, commits, english, headers, imports, paths, phrases, readmes, rings, sizes, third_party, words,
};
use std::path::Path;

/// Checks every rule on the project below `root`; the returned text has the number of files and the remaining rings.
///
/// # Errors
/// All findings, one per line.
pub(crate) fn run(root: &Path) -> Result<String, String> {
    let texts = tree::read(root)?;
    let workspace = Workspace::read(root)?;
    let rules =
        [sizes::check, headers::check, readmes::check, words::check, bans::check, phrases::check, english::check];
    let mut findings: Vec<_> = rules.iter().flat_map(|rule| rule(&texts)).collect();
    findings.extend([imports::check, third_party::check].iter().flat_map(|rule| rule(&workspace, &texts)));
    findings.extend(paths::check(&paths::Paths::new(&tree::names(root)?), &texts));
    let (broken, rings) = rings::check(&workspace, &texts);
    findings.extend(broken);
    findings.extend(catalogue::check(&texts));
    findings.extend(commits::check(root));
    findings.sort();
    if findings.is_empty() {
        return Ok(format!("{rings}\ntidy: {} texts, nothing to fix", texts.len()));
    }
    let lines: Vec<String> = findings.iter().map(ToString::to_string).collect();
    Err(format!("{}\ntidy: {} to fix", lines.join("\n"), lines.len()))
}

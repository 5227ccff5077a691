//! Changes against the main branch, as reported by git.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Changed lines by path, both from the new state.
pub(crate) type Changes = BTreeMap<String, BTreeSet<usize>>;

/// Branches for comparison; the first one that exists is used.
const BASES: &[&str] = &["main", "origin/main", "master"];

/// Returns the lines that differ from the last commit shared with main, committed or not, and untracked files. A file with removed lines
/// only has an empty set.
///
/// # Errors
/// Git's own message.
pub(crate) fn changes(root: &Path) -> Result<Changes, String> {
    let base = BASES.iter().find_map(|branch| git(root, &["merge-base", "HEAD", branch]).ok());
    let base = base.map_or_else(|| "HEAD".to_string(), |commit| commit.trim().to_string());
    let mut changes =
        parse(&git(root, &["diff", "--unified=0", "--no-color", "--no-ext-diff", "--no-renames", &base])?);
    for path in git(root, &["ls-files", "--others", "--exclude-standard"])?.lines() {
        let lines = std::fs::read_to_string(root.join(path)).map_or(0, |text| text.lines().count());
        changes.insert(path.to_string(), (1..=lines).collect());
    }
    Ok(changes)
}

/// Runs git with `arguments` in `root` and returns its output.
///
/// # Errors
/// Git's own message.
pub(crate) fn git(root: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new("git")
        .args(arguments)
        .current_dir(root)
        .output()
        .map_err(|error| format!("cannot run git: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("git {} failed: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr).trim()))
    }
}

/// Reads a diff without context lines.
fn parse(diff: &str) -> Changes {
    let mut changes = Changes::new();
    let mut path = String::new();
    for line in diff.lines() {
        if let Some(rest) = line.strip_prefix("diff --git a/") {
            // Without renames both names are equal: the second half is the name.
            path = rest.rsplit_once(" b/").map(|(_, name)| name.to_string()).unwrap_or_default();
            changes.entry(path.clone()).or_default();
        } else if let Some(range) = line.strip_prefix("@@ ").and_then(|rest| rest.split(' ').nth(1)) {
            let (first, count) =
                range.trim_start_matches('+').split_once(',').unwrap_or((range.trim_start_matches('+'), "1"));
            if let (Ok(first), Ok(count)) = (first.parse::<usize>(), count.parse::<usize>()) {
                changes.entry(path.clone()).or_default().extend(first..first + count);
            }
        }
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_lines_are_read_from_a_diff() {
        let diff = "diff --git a/x/a.rs b/x/a.rs\n--- a/x/a.rs\n+++ b/x/a.rs\n@@ -3 +3,2 @@ fn\n-old\n+new\n+new\n@@ -9,2 +9,0 @@\n-gone\ndiff --git a/b.rs b/b.rs\ndeleted file mode 100644\n@@ -1 +0,0 @@\n-x\n";
        let changes = parse(diff);
        assert_eq!(changes.get("x/a.rs"), Some(&BTreeSet::from([3, 4])));
        assert_eq!(changes.get("b.rs"), Some(&BTreeSet::new()));
    }
}

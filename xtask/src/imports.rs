//! The packages of Apex that each package may import. The table is the architecture; a dependency outside it is a finding.

use crate::finding::Finding;
use crate::tree::Text;
use crate::workspace::{self, Workspace};

/// A package's folder and the packages of Apex that it may depend on. Development dependencies are free.
/// Rows of packages that do not exist yet have no effect.
const ALLOWED: &[(&str, &[&str])] = &[
    ("crates/model", &[]),
    ("crates/forms", &["apex-model"]),
    ("crates/pdl", &["apex-model", "apex-forms"]),
    ("crates/geo", &["apex-model"]),
    ("crates/executive", &["apex-model", "apex-forms"]),
    ("crates/vehicle", &[]),
    ("crates/typescript", &[]),
    ("crates/diagnosis", &[]),
    ("crates/observation", &["apex-model", "apex-geo"]),
    ("crates/metrics", &["apex-model", "apex-geo"]),
    ("crates/requirements", &["apex-model", "apex-geo"]),
    ("crates/planning", &["apex-model", "apex-geo", "apex-metrics", "apex-observation"]),
    ("crates/solvers", &["apex-model", "apex-geo", "apex-metrics", "apex-observation", "apex-planning"]),
    ("crates/portfolio", &["apex-model", "apex-geo", "apex-metrics", "apex-observation", "apex-planning"]),
    (
        "crates/mission",
        &[
            "apex-model",
            "apex-pdl",
            "apex-executive",
            "apex-geo",
            "apex-observation",
            "apex-metrics",
            "apex-planning",
            "apex-solvers",
            "apex-portfolio",
            "apex-requirements",
            "apex-vehicle",
            "apex-diagnosis",
            "apex-runtime",
        ],
    ),
    ("crates/simulation", &["apex-model", "apex-mission", "apex-portfolio", "apex-runtime", "apex-sim", "apex-tables"]),
    ("crates/runtime", &["apex-model", "apex-forms", "apex-executive", "apex-planning"]),
    ("adapters/*", &["apex-model", "apex-executive", "apex-runtime", "apex-geo", "apex-vehicle"]),
    (
        "crates/server",
        &["apex-model", "apex-executive", "apex-runtime", "apex-metrics", "apex-mission", "apex-simulation"],
    ),
    (
        "crates/log-monitor",
        &["apex-model", "apex-pdl", "apex-executive", "apex-mission", "apex-runtime", "apex-logs", "apex-tables"],
    ),
    ("crates/cli", &["*"]),
    ("spec", &["*"]),
    // The naive interpreter must share no code with the executive that it checks.
    ("spec/reference", &[]),
    ("spec/random", &["*"]),
    ("spec/definition", &[]),
    ("spec/conditions-random", &["*"]),
    ("fuzz", &["*"]),
    ("benches", &["*"]),
    ("python", &["*"]),
    ("xtask", &[]),
];

/// Checks the dependencies of every package of the workspace against the table.
pub(crate) fn check(workspace: &Workspace, texts: &[Text]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for member in &workspace.members {
        let manifest = format!("{}/Cargo.toml", member.folder);
        let Some(allowed) = allowed_for(&member.folder) else {
            let message = format!("{} is not in the table of imports: add it in xtask/src/imports.rs", member.folder);
            findings.push(Finding::new(&manifest, 1, "imports", message));
            continue;
        };
        let refused = member
            .dependencies
            .iter()
            .filter(|name| name.starts_with("apex-") && !allowed.contains(&"*") && !allowed.contains(&name.as_str()));
        findings.extend(refused.map(|name| {
            let message = format!(
                "{} must not import {name} (it may import: {}): move the code, or pass the value in from outside",
                member.folder,
                if allowed.is_empty() { "nothing".to_string() } else { allowed.join(", ") }
            );
            Finding::new(&manifest, workspace::line_of(texts, &member.folder, name), "imports", message)
        }));
    }
    findings
}

fn allowed_for(folder: &str) -> Option<&'static [&'static str]> {
    let matches = |pattern: &str| match pattern.strip_suffix("/*") {
        Some(parent) => folder.strip_prefix(parent).is_some_and(|rest| rest.starts_with('/')),
        None => pattern == folder,
    };
    ALLOWED.iter().find(|(pattern, _)| matches(pattern)).map(|(_, allowed)| *allowed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::tests::sample;

    #[test]
    fn the_executive_must_not_see_syntax() {
        let manifest = "[dependencies]\napex-model.workspace = true\napex-pdl.workspace = true\n";
        let texts = [Text::sample("crates/executive/Cargo.toml", manifest)];
        let workspace = sample(&[("crates/executive", "apex-executive", &["apex-model", "apex-pdl"])]);
        let found = check(&workspace, &texts);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].line, 3);
        assert!(found[0].message.contains("apex-pdl"), "{}", found[0]);
    }

    #[test]
    fn third_parties_are_free() {
        let workspace = sample(&[("crates/executive", "apex-executive", &["serde"])]);
        assert_eq!(check(&workspace, &[]), []);
    }

    #[test]
    fn a_new_package_must_be_entered_in_the_table() {
        assert_eq!(check(&sample(&[("crates/magic", "apex-magic", &[])]), &[]).len(), 1);
        let adapter = sample(&[("adapters/mavlink", "apex-mavlink", &["apex-pdl"])]);
        assert_eq!(check(&adapter, &[]).len(), 1);
    }
}

//! Who may import whom. The table is the architecture; a manifest that says more is a finding.

use crate::finding::Finding;
use crate::tree::Text;

/// A package's folder and the packages of Apex that its `[dependencies]` may name. Development dependencies are free.
const ALLOWED: &[(&str, &[&str])] = &[
    ("crates/model", &[]),
    ("crates/pdl", &["apex-model"]),
    ("crates/geo", &["apex-model"]),
    ("crates/executive", &["apex-model"]),
    ("crates/metrics", &["apex-model", "apex-geo"]),
    // The simulator lends its vehicle models until these are data.
    (
        "crates/mission",
        &[
            "apex-model",
            "apex-pdl",
            "apex-executive",
            "apex-geo",
            "apex-metrics",
            "apex-planning",
            "apex-solvers",
            "apex-portfolio",
            "apex-runtime",
            "apex-sim",
        ],
    ),
    ("crates/planning", &["apex-model", "apex-geo", "apex-metrics"]),
    ("crates/solvers", &["apex-model", "apex-geo", "apex-metrics", "apex-planning"]),
    ("crates/portfolio", &["apex-model", "apex-geo", "apex-metrics", "apex-planning"]),
    // Solver processes: the contract, and no planner.
    ("crates/runtime", &["apex-model", "apex-executive", "apex-planning"]),
    ("adapters/*", &["apex-model", "apex-executive", "apex-runtime", "apex-geo"]),
    ("crates/server", &["apex-model", "apex-executive", "apex-runtime", "apex-metrics"]),
    ("crates/cli", &["*"]),
    ("spec", &["*"]),
    // The second witness shares nothing with the first.
    ("spec/reference", &[]),
    ("spec/random", &["*"]),
    ("spec/definition", &[]),
    ("spec/conditions-random", &["*"]),
    ("benches", &["*"]),
    ("python", &["*"]),
    ("xtask", &[]),
];

/// Checks every package's manifest against the table.
pub(crate) fn check(texts: &[Text]) -> Vec<Finding> {
    texts.iter().filter(|text| text.path.ends_with("/Cargo.toml")).flat_map(check_manifest).collect()
}

fn check_manifest(manifest: &Text) -> Vec<Finding> {
    let folder = manifest.path.trim_end_matches("/Cargo.toml");
    let Some(allowed) = allowed_for(folder) else {
        let message = format!("{folder} is not in the table of who may import whom: add it in xtask/src/imports.rs");
        return vec![Finding::new(&manifest.path, 1, "imports", message)];
    };
    dependencies(&manifest.body)
        .into_iter()
        .filter(|(_, name)| name.starts_with("apex-") && !allowed.contains(&"*") && !allowed.contains(&name.as_str()))
        .map(|(line, name)| {
            let message = format!(
                "{folder} must not import {name} (it may import: {}): move the code, or pass the value in from outside",
                if allowed.is_empty() { "nothing".to_string() } else { allowed.join(", ") }
            );
            Finding::new(&manifest.path, line, "imports", message)
        })
        .collect()
}

fn allowed_for(folder: &str) -> Option<&'static [&'static str]> {
    let matches = |pattern: &str| match pattern.strip_suffix("/*") {
        Some(parent) => folder.strip_prefix(parent).is_some_and(|rest| rest.starts_with('/')),
        None => pattern == folder,
    };
    ALLOWED.iter().find(|(pattern, _)| matches(pattern)).map(|(_, allowed)| *allowed)
}

/// Line and name of each entry under `[dependencies]`, `[build-dependencies]` and their target-specific forms.
fn dependencies(manifest: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut inside = false;
    for (index, line) in manifest.lines().enumerate() {
        let line = line.trim();
        if let Some(header) = line.strip_prefix('[') {
            let header = header.trim_end_matches(']');
            let normal = header.rsplit_once("dependencies").filter(|(before, _)| !before.ends_with("dev-"));
            inside = normal.is_some_and(|(_, after)| after.is_empty());
            if let Some(name) = normal.and_then(|(_, after)| after.strip_prefix('.')) {
                found.push((index + 1, name.to_string()));
            }
        } else if inside && !line.starts_with('#') {
            let name = line.split(['=', '.', ' ']).next().unwrap_or_default().trim_matches('"');
            if !name.is_empty() {
                found.push((index + 1, name.to_string()));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(path: &str, body: &str) -> Vec<Finding> {
        check(&[Text::sample(path, body)])
    }

    #[test]
    fn the_executive_must_not_see_syntax() {
        let found = findings(
            "crates/executive/Cargo.toml",
            "[dependencies]\napex-model.workspace = true\napex-pdl.workspace = true\n",
        );
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].line, 3);
        assert!(found[0].message.contains("apex-pdl"), "{}", found[0]);
    }

    #[test]
    fn dotted_and_target_tables_count_too() {
        let body = "[target.'cfg(unix)'.dependencies]\napex-pdl = { path = \"x\" }\n[dependencies.apex-geo]\nworkspace = true\n";
        assert_eq!(findings("crates/model/Cargo.toml", body).len(), 2);
    }

    #[test]
    fn development_dependencies_are_free() {
        let body = "[dependencies]\n[dev-dependencies]\napex-pdl.workspace = true\n[dev-dependencies.apex-geo]\n";
        assert_eq!(findings("crates/executive/Cargo.toml", body), []);
    }

    #[test]
    fn a_new_package_must_be_entered_in_the_table() {
        assert_eq!(findings("crates/magic/Cargo.toml", "").len(), 1);
        assert_eq!(findings("adapters/mavlink/Cargo.toml", "[dependencies]\napex-pdl = \"1\"\n").len(), 1);
    }
}

//! Third-party packages: licences, sources and duplicate versions, checked against the lists of `deny.toml`.
//!
//! `cargo deny` checks the same lists and advisories, but compiling it takes minutes; this rule takes little time and therefore runs on
//! every change.

use crate::finding::Finding;
use crate::tree::{self, Text};
use crate::workspace::{Foreign, PLATFORM, Workspace};
use serde::Deserialize;
use spdx::{Expression, ParseMode};
use std::collections::{BTreeMap, BTreeSet};

const LISTS: &str = "deny.toml";

/// The part of `deny.toml` that is checked here.
#[derive(Debug, Deserialize)]
struct Lists {
    graph: Graph,
    licenses: Licenses,
    sources: Sources,
    bans: Bans,
}

#[derive(Debug, Deserialize)]
struct Graph {
    targets: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Licenses {
    allow: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Sources {
    #[serde(rename = "allow-registry")]
    allow_registry: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Bans {
    skip: Vec<Skip>,
}

#[derive(Debug, Deserialize)]
struct Skip {
    #[serde(rename = "crate")]
    package: String,
}

/// Checks all third-party packages that the workspace resolves.
pub(crate) fn check(workspace: &Workspace, texts: &[Text]) -> Vec<Finding> {
    let Some(text) = tree::find(texts, LISTS) else {
        return vec![finding(1, "missing: it lists the licences, sources and doubled versions that are accepted")];
    };
    let lists: Lists = match toml::from_str(&text.body) {
        Ok(lists) => lists,
        Err(error) => return vec![finding(1, &format!("cannot be read: {error}"))],
    };
    let mut findings = Vec::new();
    if lists.graph.targets != [PLATFORM] {
        findings.push(finding(1, &format!("`graph.targets` must be [\"{PLATFORM}\"], as in xtask/src/workspace.rs")));
    }
    findings.extend(workspace.foreign.iter().filter_map(|package| check_license(package, &lists.licenses.allow)));
    findings.extend(workspace.foreign.iter().filter_map(|package| check_source(package, &lists.sources)));
    findings.extend(check_versions(workspace, &lists.bans.skip, &text.body));
    findings
}

fn check_license(package: &Foreign, allow: &[String]) -> Option<Finding> {
    let name = format!("{} {}", package.name, package.version);
    let Some(license) = &package.license else {
        return Some(finding(1, &format!("{name} states no licence: replace the package")));
    };
    let expression = match Expression::parse_mode(license, ParseMode::LAX) {
        Ok(expression) => expression,
        Err(error) => return Some(finding(1, &format!("{name} has the licence `{license}`: {}", error.reason))),
    };
    let allowed = expression.evaluate(|requirement| allow.contains(&requirement.to_string()));
    (!allowed)
        .then(|| finding(1, &format!("{name} has the licence `{license}`, which `licenses.allow` does not cover")))
}

fn check_source(package: &Foreign, sources: &Sources) -> Option<Finding> {
    let known = sources.allow_registry.iter().any(|registry| package.source == format!("registry+{registry}"));
    let message = || {
        format!(
            "{} {} comes from {}: only registries of `sources.allow-registry`",
            package.name, package.version, package.source
        )
    };
    (!known).then(|| finding(1, &message()))
}

/// Checks that all versions of a package but the newest are listed, as `name@version`, and that each row is needed.
fn check_versions(workspace: &Workspace, skip: &[Skip], body: &str) -> Vec<Finding> {
    let listed: BTreeSet<&str> = skip.iter().map(|row| row.package.as_str()).collect();
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in &workspace.foreign {
        versions.entry(&package.name).or_default().push(&package.version);
    }
    let mut doubled = BTreeSet::new();
    for (name, mut versions) in versions {
        versions.sort_by_key(|version| numbers(version));
        versions.pop();
        doubled.extend(versions.into_iter().map(|version| format!("{name}@{version}")));
    }
    let unlisted = doubled.iter().filter(|package| !listed.contains(package.as_str())).map(|package| {
        finding(1, &format!("{package} is there next to a newer version: raise what needs it (`cargo tree --invert {package}`), or list it in `bans.skip`"))
    });
    let unneeded = listed.iter().filter(|package| !doubled.contains(**package)).map(|package| {
        let line = body.lines().position(|line| line.contains(&format!("\"{package}\""))).map_or(1, |index| index + 1);
        finding(line, &format!("{package} is not doubled: remove its row from `bans.skip`"))
    });
    unlisted.chain(unneeded).collect()
}

/// Returns the numbers of a version, for sorting.
fn numbers(version: &str) -> Vec<u64> {
    version.split(['.', '-', '+']).map_while(|part| part.parse().ok()).collect()
}

fn finding(line: usize, message: &str) -> Finding {
    Finding::new(LISTS, line, "third-party", message)
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

    fn found(packages: &[(&str, &str, Option<&str>, &str)], skip: &str) -> Vec<String> {
        let lists = format!(
            "[graph]\ntargets = [\"{PLATFORM}\"]\n[licenses]\nallow = [\"MIT\", \"Apache-2.0\", \"Apache-2.0 WITH LLVM-exception\"]\n[sources]\nallow-registry = [\"https://github.com/rust-lang/crates.io-index\"]\n[bans]\nskip = [{skip}]\n"
        );
        let foreign = packages.iter().map(|(name, version, license, source)| Foreign {
            name: name.to_string(),
            version: version.to_string(),
            license: license.map(str::to_string),
            source: source.to_string(),
        });
        let workspace = Workspace { members: Vec::new(), foreign: foreign.collect() };
        check(&workspace, &[Text::sample(LISTS, &lists)]).into_iter().map(|finding| finding.message).collect()
    }

    #[test]
    fn licences_are_evaluated_as_expressions() {
        for license in ["MIT", "GPL-3.0-only OR MIT", "MIT/Apache-2.0", "Apache-2.0 WITH LLVM-exception"] {
            assert!(found(&[("a", "1.0.0", Some(license), REGISTRY)], "").is_empty(), "{license}");
        }
        for license in [Some("GPL-3.0-only"), Some("MIT AND GPL-3.0-only"), Some("what"), None] {
            assert_eq!(found(&[("a", "1.0.0", license, REGISTRY)], "").len(), 1, "{license:?}");
        }
    }

    #[test]
    fn other_sources_fail() {
        assert!(found(&[("a", "1.0.0", Some("MIT"), "git+https://example.org/a")], "")[0].contains("git+https"));
    }

    #[test]
    fn doubled_versions_are_listed_one_by_one() {
        let both = [("a", "1.9.0", Some("MIT"), REGISTRY), ("a", "1.10.0", Some("MIT"), REGISTRY)];
        assert!(found(&both, "")[0].starts_with("a@1.9.0"));
        assert!(found(&both, "{ crate = \"a@1.9.0\", reason = \"b needs it\" }").is_empty());
        assert!(found(&both[..1], "{ crate = \"a@1.9.0\", reason = \"b needs it\" }")[0].contains("remove its row"));
    }

    #[test]
    fn a_missing_or_broken_list_fails() {
        let workspace = Workspace { members: Vec::new(), foreign: Vec::new() };
        assert_eq!(check(&workspace, &[]).len(), 1);
        assert_eq!(check(&workspace, &[Text::sample(LISTS, "[graph")]).len(), 1);
    }
}

//! `cargo xtask quick`: the checks needed before a commit, in the dev profile, so that builds are incremental.
//!
//! Always: formatting, the rules of the repository, and lints of all libraries and binaries, where cargo checks only those affected by
//! the change. For packages changed against main: lints of the tests, and the tests. Changes that affect the contents of specification
//! pages also run these pages.

use crate::git::{self, Changes};
use crate::testing;
use crate::workspace::Workspace;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Paths whose changes also require tests of other packages.
const ALSO: &[(&str, &[&str])] = &[
    ("crates/model/", &["apex-spec"]),
    ("crates/pdl/", &["apex-spec"]),
    ("crates/executive/", &["apex-spec"]),
    ("spec/", &["apex-spec"]),
    ("library/", &["apex-spec", "apex-mission"]),
    ("missions/", &["apex-mission"]),
    ("web/src/record/", &["apex-server"]),
];
/// Files that affect every package.
const EVERYTHING: &[&str] = &["Cargo.lock", "rust-toolchain.toml", ".cargo/config.toml"];

/// Runs all steps and reports how long each took.
///
/// # Errors
/// The first step that fails, or an error of git or cargo.
pub(crate) fn run(root: &Path) -> Result<String, String> {
    let packages = packages(&Workspace::read(root)?, &git::changes(root)?);
    let begin = Instant::now();
    for arguments in steps(&packages) {
        let shown = arguments.join(" ");
        println!("cargo {shown}");
        let begin = Instant::now();
        let status = Command::new("cargo").args(&arguments).current_dir(root).status();
        let status = status.map_err(|error| format!("cannot run cargo {shown}: {error}"))?;
        if !status.success() {
            return Err(format!("quick: `cargo {shown}` failed"));
        }
        println!("  {:.1} s", begin.elapsed().as_secs_f64());
    }
    let arguments = tests(&packages);
    if !arguments.is_empty() {
        println!("cargo xtask test {}", arguments.join(" "));
        let begin = Instant::now();
        println!("{}", testing::run(root, &arguments)?);
        println!("  {:.1} s", begin.elapsed().as_secs_f64());
    }
    let tested: Vec<&str> = packages.iter().map(String::as_str).collect();
    let tested = if tested.is_empty() { "no package".to_string() } else { tested.join(", ") };
    Ok(format!("quick: {:.1} s; tested {tested}", begin.elapsed().as_secs_f64()))
}

/// Returns the packages whose tests a change requires; `xtask` only if it has changed, because `make test` runs its tests.
fn packages(workspace: &Workspace, changes: &Changes) -> BTreeSet<String> {
    let mut packages = BTreeSet::new();
    for path in changes.keys() {
        if EVERYTHING.contains(&path.as_str()) {
            return workspace.members.iter().map(|member| member.name.clone()).collect();
        }
        let owner = workspace.owner(path).filter(|_| !path.ends_with(".md"));
        packages.extend(owner.map(|member| member.name.clone()));
        let also = ALSO.iter().filter(|(prefix, _)| path.starts_with(prefix)).flat_map(|(_, packages)| *packages);
        let known = also.filter(|name| workspace.members.iter().any(|member| member.name == **name));
        packages.extend(known.map(ToString::to_string));
    }
    packages
}

fn steps(packages: &BTreeSet<String>) -> Vec<Vec<&str>> {
    let mut steps = vec![
        vec!["fmt", "--all", "--check"],
        vec!["xtask", "tidy"],
        vec!["clippy", "--locked", "--quiet", "--workspace", "--lib", "--bins", "--", "-D", "warnings"],
    ];
    if !packages.is_empty() {
        steps.push(
            [&["clippy", "--locked", "--quiet"], &*chosen(packages), &["--all-targets", "--", "-D", "warnings"]]
                .concat(),
        );
    }
    steps
}

/// Returns the arguments of cargo for the tests of these packages; empty without packages.
fn tests(packages: &BTreeSet<String>) -> Vec<&str> {
    if packages.is_empty() {
        return Vec::new();
    }
    [&["--locked", "--quiet"], &*chosen(packages), &["--lib", "--bins", "--tests"]].concat()
}

fn chosen(packages: &BTreeSet<String>) -> Vec<&str> {
    packages.iter().flat_map(|name| ["--package", name.as_str()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::tests::sample;

    fn tested(paths: &[&str]) -> Vec<String> {
        let workspace = sample(&[
            ("crates/executive", "apex-executive", &[]),
            ("crates/geo", "apex-geo", &[]),
            ("spec", "apex-spec", &[]),
        ]);
        let changes = paths.iter().map(|path| (path.to_string(), BTreeSet::new())).collect();
        packages(&workspace, &changes).into_iter().collect()
    }

    #[test]
    fn a_change_is_tested_by_its_package_and_by_the_pages_that_show_it() {
        assert_eq!(tested(&["crates/geo/src/sun.rs"]), ["apex-geo"]);
        assert_eq!(tested(&["crates/executive/src/step.rs"]), ["apex-executive", "apex-spec"]);
        assert_eq!(tested(&["library/camera.pdl"]), ["apex-spec"]);
        assert_eq!(tested(&["Cargo.lock"]).len(), 3);
        assert!(tested(&["docs/README.md", "crates/geo/README.md"]).is_empty());
    }

    #[test]
    fn without_changed_packages_nothing_is_tested() {
        assert_eq!(steps(&BTreeSet::new()).len(), 3);
        assert!(tests(&BTreeSet::new()).is_empty());
        let packages = BTreeSet::from(["apex-geo".to_string()]);
        assert_eq!(
            steps(&packages)[3].join(" "),
            "clippy --locked --quiet --package apex-geo --all-targets -- -D warnings"
        );
        assert_eq!(tests(&packages).join(" "), "--locked --quiet --package apex-geo --lib --bins --tests");
    }
}

//! The workspace as described by `cargo metadata`: packages, their folders, dependencies and licences.

use crate::tree::{self, Text};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// The platform for which dependencies are resolved; `deny.toml` names the same one.
pub(crate) const PLATFORM: &str = "x86_64-unknown-linux-gnu";

/// The packages of the workspace and their dependencies.
#[derive(Clone, Debug)]
pub(crate) struct Workspace {
    /// Packages of the project, in order of folder.
    pub(crate) members: Vec<Member>,
    /// Packages of third parties that a build of the workspace compiles, in order of name and version.
    pub(crate) foreign: Vec<Foreign>,
}

/// A package of the project.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    /// Package name, for example `apex-model`.
    pub(crate) name: String,
    /// Folder below the project's top folder, with `/`.
    pub(crate) folder: String,
    /// Names of all dependencies except development dependencies.
    pub(crate) dependencies: BTreeSet<String>,
    /// Root files of libraries and binaries, from the project's top folder.
    pub(crate) roots: Vec<String>,
}

/// A package of a third party.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Foreign {
    /// Package name.
    pub(crate) name: String,
    /// Version.
    pub(crate) version: String,
    /// SPDX expression, if the manifest states one.
    pub(crate) license: Option<String>,
    /// Registry or repository of origin.
    pub(crate) source: String,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
    workspace_root: String,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<ResolvedNode>,
}

#[derive(Deserialize)]
struct ResolvedNode {
    id: String,
}

#[derive(Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    source: Option<String>,
    manifest_path: String,
    dependencies: Vec<Dependency>,
    targets: Vec<CargoTarget>,
}

#[derive(Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
}

#[derive(Deserialize)]
struct CargoTarget {
    kind: Vec<String>,
    src_path: String,
}

impl Workspace {
    /// Reads the workspace below `root` from cargo.
    ///
    /// # Errors
    /// Cargo's own message, or the field of its answer that cannot be read.
    pub(crate) fn read(root: &Path) -> Result<Workspace, String> {
        let answer = cargo(root, &["metadata", "--format-version", "1", "--locked", "--filter-platform", PLATFORM])?;
        let mut workspace = Workspace::parse(&answer)?;
        // The metadata also resolve optional dependencies that no feature enables; `cargo tree` lists the compiled ones.
        let tree = ["tree", "--locked", "--workspace", "--target", PLATFORM, "--prefix", "none", "--format", "{p}"];
        let compiled = String::from_utf8_lossy(&cargo(root, &tree)?).into_owned();
        workspace.keep_compiled(&compiled);
        Ok(workspace)
    }

    /// Drops packages of third parties that `tree` does not name; its lines begin with name and version.
    fn keep_compiled(&mut self, tree: &str) {
        let compiled: BTreeSet<(&str, &str)> = tree
            .lines()
            .filter_map(|line| line.split_once(" v"))
            .map(|(name, rest)| (name, rest.split(' ').next().unwrap_or_default()))
            .collect();
        self.foreign.retain(|package| compiled.contains(&(package.name.as_str(), package.version.as_str())));
    }

    /// Reads the answer of `cargo metadata --format-version 1`.
    ///
    /// # Errors
    /// The field that is missing or has another type.
    pub(crate) fn parse(answer: &[u8]) -> Result<Workspace, String> {
        let metadata: Metadata = serde_json::from_slice(answer)
            .map_err(|error| format!("cannot read the answer of cargo metadata: {error}"))?;
        let resolved: BTreeSet<&str> = metadata.resolve.nodes.iter().map(|node| node.id.as_str()).collect();
        let top = format!("{}/", metadata.workspace_root);
        let mut workspace = Workspace { members: Vec::new(), foreign: Vec::new() };
        for package in metadata.packages.iter().filter(|package| resolved.contains(package.id.as_str())) {
            match &package.source {
                None => workspace.members.push(member(package, &top)),
                Some(source) => workspace.foreign.push(Foreign {
                    name: package.name.clone(),
                    version: package.version.clone(),
                    license: package.license.clone(),
                    source: source.clone(),
                }),
            }
        }
        workspace.members.sort_by(|a, b| a.folder.cmp(&b.folder));
        workspace.foreign.sort();
        Ok(workspace)
    }

    /// Returns the member whose folder contains the file at `path`; the deepest one if folders are nested.
    pub(crate) fn owner(&self, path: &str) -> Option<&Member> {
        let holds = |member: &&Member| path.strip_prefix(&member.folder).is_some_and(|rest| rest.starts_with('/'));
        self.members.iter().filter(holds).max_by_key(|member| member.folder.len())
    }
}

/// Returns the output of cargo for `arguments`.
fn cargo(root: &Path, arguments: &[&str]) -> Result<Vec<u8>, String> {
    let program = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_string());
    let name = arguments.first().copied().unwrap_or_default();
    let output = Command::new(program)
        .args(arguments)
        .current_dir(root)
        .output()
        .map_err(|error| format!("cannot run cargo {name}: {error}"))?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    Err(format!("cargo {name} failed: {}", String::from_utf8_lossy(&output.stderr).trim()))
}

fn member(package: &Package, top: &str) -> Member {
    let relative = |path: &str| path.strip_prefix(top).unwrap_or(path).to_string();
    let dependencies = package.dependencies.iter().filter(|each| each.kind.as_deref() != Some("dev"));
    let builds = |target: &&CargoTarget| {
        target.kind.iter().any(|kind| matches!(kind.as_str(), "lib" | "rlib" | "cdylib" | "proc-macro" | "bin"))
    };
    Member {
        name: package.name.clone(),
        folder: relative(&package.manifest_path).trim_end_matches("Cargo.toml").trim_end_matches('/').to_string(),
        dependencies: dependencies.map(|each| each.name.clone()).collect(),
        roots: package.targets.iter().filter(builds).map(|target| relative(&target.src_path)).collect(),
    }
}

/// Returns the line of a member's manifest that names `dependency`; 1 if none does.
pub(crate) fn line_of(texts: &[Text], folder: &str, dependency: &str) -> usize {
    let manifest = tree::find(texts, &format!("{folder}/Cargo.toml"));
    let names = |line: &str| {
        let name = line.trim_start().trim_start_matches('[').trim_start_matches("dependencies.");
        name.trim_start_matches('"').strip_prefix(dependency).is_some_and(|rest| {
            rest.chars().next().is_none_or(|next| !next.is_alphanumeric() && !matches!(next, '-' | '_'))
        })
    };
    manifest.and_then(|manifest| manifest.body.lines().position(names)).map_or(1, |index| index + 1)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Returns a workspace for the tests of rules: folder, name, dependencies.
    pub(crate) fn sample(members: &[(&str, &str, &[&str])]) -> Workspace {
        let names = |list: &[&str]| list.iter().map(ToString::to_string).collect();
        let members = members.iter().map(|(folder, name, dependencies)| Member {
            name: name.to_string(),
            folder: folder.to_string(),
            dependencies: names(dependencies),
            roots: vec![format!("{folder}/src/lib.rs")],
        });
        Workspace { members: members.collect(), foreign: Vec::new() }
    }

    #[test]
    fn the_answer_of_cargo_is_read() {
        let answer = r#"{"workspace_root": "/top", "resolve": {"nodes": [{"id": "a"}, {"id": "s"}]}, "packages": [
            {"id": "a", "name": "apex-a", "version": "0.1.0", "license": null, "source": null, "manifest_path": "/top/crates/a/Cargo.toml",
             "dependencies": [{"name": "serde", "kind": null}, {"name": "insta", "kind": "dev"}],
             "targets": [{"kind": ["lib"], "src_path": "/top/crates/a/src/lib.rs"}, {"kind": ["test"], "src_path": "/top/crates/a/tests/t.rs"}]},
            {"id": "s", "name": "serde", "version": "1.0.0", "license": "MIT", "source": "registry+x", "manifest_path": "/x/Cargo.toml", "dependencies": [], "targets": []},
            {"id": "u", "name": "unused", "version": "1.0.0", "license": null, "source": "registry+x", "manifest_path": "/x/Cargo.toml", "dependencies": [], "targets": []}]}"#;
        let read = Workspace::parse(answer.as_bytes()).unwrap();
        assert_eq!(read.members.len(), 1);
        assert_eq!(read.members[0].folder, "crates/a");
        assert_eq!(read.members[0].roots, ["crates/a/src/lib.rs"]);
        assert!(read.members[0].dependencies.contains("serde") && !read.members[0].dependencies.contains("insta"));
        assert_eq!(read.foreign.len(), 1, "what the graph does not resolve is left out");
        let mut compiled = read.clone();
        compiled.keep_compiled("apex-a v0.1.0 (/top/crates/a)\nserde v1.0.0\n");
        assert_eq!(compiled.foreign.len(), 1);
        compiled.keep_compiled("serde v1.0.1 (*)\n");
        assert_eq!(compiled.foreign.len(), 0, "another version is compiled");
    }

    #[test]
    fn a_nested_package_owns_its_files() {
        let read = sample(&[("spec", "apex-spec", &[]), ("spec/random", "apex-random", &[])]);
        assert_eq!(read.owner("spec/random/src/lib.rs").map(|member| member.name.as_str()), Some("apex-random"));
        assert_eq!(read.owner("spec/src/lib.rs").map(|member| member.name.as_str()), Some("apex-spec"));
        assert!(read.owner("specification.md").is_none());
    }
}

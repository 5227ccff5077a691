//! Rings of imports between the files of a crate.
//!
//! The graph has an edge from file to file if code names an item defined in the other file (`modules.rs`). A file belongs to its folder;
//! `foo.rs` next to `foo/` is outside `foo/`. A ring is a set of files that all import each other, directly or indirectly. Rings across
//! folders and rings inside a folder are counted by crate, in files, under the ceilings of `xtask/rings-ceiling.tsv`. In addition,
//! folders directly below `src/` that import each other are counted, even if no two of their files do.

mod components;
mod modules;
mod uses;

use crate::ceilings::{self, Counts, Keys};
use crate::finding::Finding;
use crate::tree::Text;
use crate::workspace::{Member, Workspace};
use components::Graph;
use modules::{Edge, Modules};
use std::collections::BTreeSet;
use std::path::Path;

const CEILING: &str = "xtask/rings-ceiling.tsv";

/// The rings of one crate.
struct Rings {
    /// Package name.
    name: String,
    edges: Vec<Edge>,
    across: Vec<Vec<String>>,
    inside: Vec<Vec<String>>,
    /// Sets of folders directly below `src/` that import each other.
    folders: Vec<Vec<String>>,
}

/// Checks all crates of the workspace, and names the remaining rings in one line.
pub(crate) fn check(workspace: &Workspace, texts: &[Text]) -> (Vec<Finding>, String) {
    match all(workspace, texts) {
        Err(finding) => (vec![finding], String::new()),
        Ok(rings) => {
            let counts = counts(&rings);
            let advice =
                |_: &str| "move what both sides need below both; `cargo xtask rings` lists the imports".to_string();
            let shown: Vec<String> = counts.iter().map(|(key, count)| format!("{key} {count}")).collect();
            let summary = if shown.is_empty() { "none".to_string() } else { shown.join(", ") };
            (ceilings::check(texts, CEILING, "rings", &counts, advice), format!("rings: {summary}"))
        }
    }
}

/// Lists all rings with an example of each.
///
/// # Errors
/// A file that cannot be parsed.
pub(crate) fn report(workspace: &Workspace, texts: &[Text]) -> Result<String, String> {
    let rings = all(workspace, texts).map_err(|finding| finding.to_string())?;
    let lines: Vec<String> = rings.iter().map(Rings::describe).filter(|text| !text.is_empty()).collect();
    Ok(if lines.is_empty() { "no rings".to_string() } else { lines.join("\n") })
}

/// Lowers the ceilings to today's counts.
///
/// # Errors
/// Counts that have risen; files that cannot be read or written.
pub(crate) fn update(root: &Path, workspace: &Workspace, texts: &[Text]) -> Result<String, String> {
    let rings = all(workspace, texts).map_err(|finding| finding.to_string())?;
    ceilings::lower(root, CEILING, &counts(&rings), Keys::Movable)
}

fn all(workspace: &Workspace, texts: &[Text]) -> Result<Vec<Rings>, Finding> {
    workspace.members.iter().map(|member| Rings::of(member, texts)).collect()
}

fn counts(rings: &[Rings]) -> Counts {
    let mut counts = Counts::new();
    for each in rings {
        for (kind, sets) in [("across", &each.across), ("inside", &each.inside), ("folders", &each.folders)] {
            let size: usize = sets.iter().map(Vec::len).sum();
            if size > 0 {
                counts.insert(format!("{} {kind}", each.name), size);
            }
        }
    }
    counts
}

impl Rings {
    fn of(member: &Member, texts: &[Text]) -> Result<Rings, Finding> {
        let source = format!("{}/src/", member.folder);
        let mut edges = BTreeSet::new();
        for root in member.roots.iter().filter(|root| root.starts_with(&source)) {
            let modules = Modules::read(texts, root)?;
            let files = modules.files();
            edges.extend(modules.edges().into_iter().filter(|edge| files.contains(edge.to.as_str())));
        }
        let edges: Vec<Edge> = edges.into_iter().collect();
        let owned = |ring: Vec<&str>| ring.into_iter().map(str::to_string).collect::<Vec<String>>();
        let files = components::rings(&graph(&edges, |path| path));
        let (inside, across) = files
            .into_iter()
            .map(owned)
            .partition(|ring: &Vec<String>| ring.iter().map(|path| folder(path)).collect::<BTreeSet<_>>().len() == 1);
        let in_folders =
            |edge: &&Edge| [&edge.from, &edge.to].into_iter().all(|path| top_folder(path, &source) != path);
        let between: Vec<Edge> = edges.iter().filter(in_folders).cloned().collect();
        let folders =
            components::rings(&graph(&between, |path| top_folder(path, &source))).into_iter().map(owned).collect();
        Ok(Rings { name: member.name.clone(), edges, across, inside, folders })
    }

    fn describe(&self) -> String {
        let mut lines = Vec::new();
        for (kind, rings) in [("across folders", &self.across), ("inside a folder", &self.inside)] {
            for ring in rings {
                lines.push(format!("{}: ring of {} files {kind}: {}", self.name, ring.len(), ring.join(" ")));
                lines.extend(self.example(ring, kind == "across folders"));
            }
        }
        for ring in &self.folders {
            lines.push(format!("{}: folders that import each other: {}", self.name, ring.join(" ")));
        }
        lines.join("\n")
    }

    /// Returns the shortest ring within a set; with `across`, the shortest one that leaves a folder.
    fn example(&self, ring: &[String], across: bool) -> Option<String> {
        let members: BTreeSet<&str> = ring.iter().map(String::as_str).collect();
        let inner: Vec<Edge> = self
            .edges
            .iter()
            .filter(|edge| members.contains(edge.from.as_str()) && members.contains(edge.to.as_str()))
            .cloned()
            .collect();
        let graph = graph(&inner, |path| path);
        let leaves = inner.iter().filter(|edge| !across || folder(&edge.from) != folder(&edge.to));
        let ways = leaves.map(|edge| components::way_back(&graph, &edge.from, &edge.to));
        let shortest = ways.min_by_key(Vec::len)?;
        let closed = shortest.iter().chain(shortest.first());
        let steps: Vec<&str> = closed.copied().collect();
        let shown = steps.windows(2).filter_map(|pair| {
            let [from, to] = pair else { return None };
            let edge = inner.iter().find(|edge| edge.from == *from && edge.to == *to)?;
            Some(format!("    {from}:{} imports {to}", edge.line))
        });
        Some(shown.collect::<Vec<_>>().join("\n"))
    }
}

fn graph<'a>(edges: &'a [Edge], node: impl Fn(&'a str) -> &'a str) -> Graph<'a> {
    let mut graph = Graph::new();
    for edge in edges {
        let (from, to) = (node(&edge.from), node(&edge.to));
        graph.entry(from).or_default();
        if from != to {
            graph.entry(from).or_default().insert(to);
        }
    }
    graph
}

fn folder(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// Returns the folder directly below `source` that contains the file; the file itself if it is directly below `source`.
fn top_folder<'a>(path: &'a str, source: &str) -> &'a str {
    let below = path.strip_prefix(source).and_then(|rest| rest.find('/'));
    below.and_then(|length| path.get(..source.len() + length)).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::tests::sample;

    fn project(ceiling: &str, helper: &str) -> Vec<Text> {
        let file = |path: &str, body: &str| Text::sample(&format!("crates/x/src/{path}"), body);
        vec![
            Text::sample(CEILING, ceiling),
            file("lib.rs", "mod a;\nmod b;\n"),
            file("a/mod.rs", "pub mod one;\npub mod two;\n"),
            file("a/one.rs", "use super::two::f;\npub fn g() { f() }\n"),
            file("a/two.rs", helper),
            file("b/mod.rs", "pub fn h() { crate::a::one::g() }\n"),
        ]
    }

    fn found(ceiling: &str, helper: &str) -> Vec<String> {
        let workspace = sample(&[("crates/x", "apex-x", &[])]);
        check(&workspace, &project(ceiling, helper)).0.iter().map(|finding| finding.message.clone()).collect()
    }

    #[test]
    fn a_ring_across_folders_is_refused_above_its_ceiling() {
        let helper = "pub fn f() { crate::b::h() }\n";
        assert_eq!(found("", helper).len(), 2);
        assert!(found("", helper)[0].starts_with("3 of `apex-x across`"));
        assert!(found("", helper)[1].starts_with("2 of `apex-x folders`"));
        assert!(found("apex-x across\t3\napex-x folders\t2\n", helper).is_empty());
        let workspace = sample(&[("crates/x", "apex-x", &[])]);
        let report = report(&workspace, &project("", helper)).unwrap();
        assert!(report.contains("crates/x/src/a/two.rs:1 imports crates/x/src/b/mod.rs"), "{report}");
        assert!(report.contains("folders that import each other: crates/x/src/a crates/x/src/b"), "{report}");
    }

    #[test]
    fn a_ring_inside_a_folder_is_counted_apart() {
        assert!(found("", "pub fn f() { super::one::g() }\n")[0].starts_with("2 of `apex-x inside`"));
        assert!(found("", "pub fn f() {}\n").is_empty());
    }

    #[test]
    fn a_file_that_cannot_be_parsed_is_a_finding() {
        assert_eq!(found("", "fn (").len(), 1);
    }
}

//! The modules of one crate: the file and the definitions of each, and the targets of paths.
//!
//! A path is followed through imports and re-exports to the file that defines the item, so that a `mod.rs` with `pub use` lines is not
//! taken for the place of definition.

use super::uses::{self, Content, Import};
use crate::finding::Finding;
use crate::tree::{self, Text};
use std::collections::{BTreeMap, BTreeSet};

type ModuleId = usize;

/// The modules of a crate; the first one is the root.
pub(crate) struct Modules {
    all: Vec<Module>,
    /// Path of the file that defines each macro.
    macros: BTreeMap<String, String>,
}

struct Module {
    file: String,
    parent: Option<ModuleId>,
    children: BTreeMap<String, ModuleId>,
    items: BTreeSet<String>,
    imports: Vec<Import>,
    paths: BTreeMap<Vec<String>, usize>,
}

/// Target of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
enum PathTarget {
    Module(ModuleId),
    /// An item of this file.
    Item(String),
}

/// An import of one file by another, with its line.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Edge {
    pub(crate) from: String,
    pub(crate) to: String,
    pub(crate) line: usize,
}

/// Lookups in progress, so that circular imports end.
type Visited = BTreeSet<(ModuleId, String, bool)>;

impl Modules {
    /// Reads the modules that `root` declares, directly and indirectly.
    ///
    /// # Errors
    /// The file that cannot be parsed.
    pub(crate) fn read(texts: &[Text], root: &str) -> Result<Modules, Finding> {
        let mut modules = Modules { all: Vec::new(), macros: BTreeMap::new() };
        let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder).to_string();
        modules.add_file(texts, root, folder, None)?;
        Ok(modules)
    }

    fn add_file(
        &mut self,
        texts: &[Text],
        path: &str,
        folder: String,
        parent: Option<ModuleId>,
    ) -> Result<ModuleId, Finding> {
        let body = tree::find(texts, path).map_or("", |text| text.body.as_str());
        let content = uses::read(body).map_err(|(line, message)| Finding::new(path, line, "rings", message))?;
        self.add_module(texts, path, &folder, parent, content)
    }

    /// Adds a module; its child modules in files are in `folder`.
    fn add_module(
        &mut self,
        texts: &[Text],
        path: &str,
        folder: &str,
        parent: Option<ModuleId>,
        content: Content,
    ) -> Result<ModuleId, Finding> {
        let id = self.all.len();
        let Content { items, macros, imports, paths, modules } = content;
        self.macros.extend(macros.into_iter().map(|name| (name, path.to_string())));
        let children = BTreeMap::new();
        self.all.push(Module { file: path.to_string(), parent, children, items, imports, paths });
        for (name, inner) in modules {
            let below = format!("{folder}/{name}");
            let child = match inner {
                Some(inner) => self.add_module(texts, path, &below, Some(id), inner)?,
                None => {
                    let files = [format!("{below}.rs"), format!("{below}/mod.rs")];
                    let Some(file) = files.iter().find(|file| tree::find(texts, file).is_some()) else { continue };
                    self.add_file(texts, file, below, Some(id))?
                }
            };
            if let Some(module) = self.all.get_mut(id) {
                module.children.insert(name, child);
            }
        }
        Ok(id)
    }

    /// Returns the imports between files, each pair once with its first line.
    ///
    /// A private `use` of an item is an import; a `use` of a module, or a re-export, counts as an import where its name occurs in code.
    pub(crate) fn edges(&self) -> Vec<Edge> {
        let mut edges: BTreeMap<(&str, String), usize> = BTreeMap::new();
        for (id, module) in self.all.iter().enumerate() {
            let imports = module.imports.iter().filter(|import| !import.is_public);
            let imported = imports.map(|import| (self.follow(id, &import.path, &mut Visited::new()), import.line));
            let named = module.paths.iter().map(|(path, line)| (self.follow(id, path, &mut Visited::new()), *line));
            for (place, line) in imported.chain(named) {
                if let Some(PathTarget::Item(to)) = place
                    && to != module.file
                {
                    let first = edges.entry((&module.file, to)).or_insert(line);
                    *first = line.min(*first);
                }
            }
        }
        edges.into_iter().map(|((from, to), line)| Edge { from: from.to_string(), to, line }).collect()
    }

    /// Files of the crate.
    pub(crate) fn files(&self) -> BTreeSet<&str> {
        self.all.iter().map(|module| module.file.as_str()).collect()
    }

    /// Returns the target of `path`, seen from module `from`; `None` if it is outside the crate or a local name.
    fn follow(&self, from: ModuleId, path: &[String], visited: &mut Visited) -> Option<PathTarget> {
        let (first, rest) = path.split_first()?;
        let mut place = match first.as_str() {
            "crate" => PathTarget::Module(0),
            "self" => PathTarget::Module(from),
            "super" => PathTarget::Module(self.all.get(from)?.parent?),
            name => self.lookup(from, name, rest.is_empty(), visited)?,
        };
        for (index, name) in rest.iter().enumerate() {
            let PathTarget::Module(id) = place else { return Some(place) };
            place = if name == "super" {
                PathTarget::Module(self.all.get(id)?.parent?)
            } else {
                let found = self.lookup(id, name, index + 1 == rest.len(), visited);
                found.or_else(|| self.macros.get(name).map(|file| PathTarget::Item(file.clone())))?
            };
        }
        Some(place)
    }

    /// Returns the meaning of `name` within module `id`. For the last name of a path, an item has precedence over a module of the same
    /// name.
    fn lookup(&self, id: ModuleId, name: &str, is_last: bool, visited: &mut Visited) -> Option<PathTarget> {
        if !visited.insert((id, name.to_string(), is_last)) {
            return None;
        }
        let module = self.all.get(id)?;
        let child = module.children.get(name).map(|child| PathTarget::Module(*child));
        let item = module.items.contains(name).then(|| PathTarget::Item(module.file.clone()));
        let imports: Vec<&Import> = module.imports.iter().filter(|each| each.name.as_deref() == Some(name)).collect();
        let imported = || {
            let places: Vec<PathTarget> =
                imports.iter().filter_map(|each| self.follow(id, &each.path, visited)).collect();
            let wanted = places.iter().find(|place| matches!(place, PathTarget::Item(_)) == is_last);
            wanted.or(places.first()).cloned()
        };
        let found = if is_last { item.or_else(imported).or(child) } else { child.or_else(imported).or(item) };
        found.or_else(|| {
            let globs = module.imports.iter().filter(|import| import.name.is_none());
            globs.map(|glob| &glob.path).find_map(|path| match self.follow(id, path, visited)? {
                PathTarget::Module(other) => self.lookup(other, name, is_last, visited),
                PathTarget::Item(_) => None,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(files: &[(&str, &str)]) -> Vec<String> {
        let texts: Vec<Text> = files.iter().map(|(path, body)| Text::sample(&format!("src/{path}"), body)).collect();
        let modules = Modules::read(&texts, "src/lib.rs").unwrap();
        let shown = |edge: &Edge| format!("{}:{} {}", edge.from, edge.line, edge.to).replace("src/", "");
        modules.edges().iter().map(shown).collect()
    }

    #[test]
    fn imports_and_inline_paths_lead_to_files() {
        let found = edges(&[
            ("lib.rs", "mod a;\nmod b;\n"),
            ("a.rs", "pub fn f() { crate::b::c::g() }\n"),
            ("b/mod.rs", "pub mod c;\npub struct B;\n"),
            ("b/c.rs", "use super::B;\nuse std::fmt;\npub fn g() {}\n"),
        ]);
        assert_eq!(found, ["a.rs:1 b/c.rs", "b/c.rs:1 b/mod.rs"]);
    }

    #[test]
    fn a_re_export_leads_to_the_file_that_defines_the_item() {
        let found = edges(&[
            ("lib.rs", "mod a;\nmod b;\npub use b::*;\n"),
            ("a.rs", "use crate::{G, b::H};\nfn f(_: G, _: H) {}\n"),
            ("b/mod.rs", "mod c;\npub use c::{G, K as H};\n"),
            ("b/c.rs", "pub struct G;\npub struct K;\nfn f() { crate::a::f() }\n"),
        ]);
        assert_eq!(found, ["a.rs:1 b/c.rs", "b/c.rs:3 a.rs"]);
    }

    #[test]
    fn a_re_export_that_is_used_is_an_import() {
        let found = edges(&[
            ("lib.rs", "mod b;\n"),
            ("b/mod.rs", "mod c;\npub use c::g;\nfn f() { g() }\n"),
            ("b/c.rs", "pub fn g() {}\n"),
        ]);
        assert_eq!(found, ["b/mod.rs:3 b/c.rs"]);
    }

    #[test]
    fn an_imported_module_counts_where_it_is_used() {
        let found = edges(&[
            ("lib.rs", "mod a;\nmod b;\n"),
            ("a.rs", "use crate::b;\nfn f() { b::c::g(); vec![b::c::g(), super::b::h()]; }\n"),
            ("b/mod.rs", "pub mod c;\npub fn h() {}\n"),
            ("b/c.rs", "pub fn g() {}\n"),
        ]);
        assert_eq!(found, ["a.rs:2 b/c.rs", "a.rs:2 b/mod.rs"]);
    }

    #[test]
    fn names_of_a_glob_count_where_they_are_used() {
        let found = edges(&[
            ("lib.rs", "mod a;\nmod b;\n"),
            ("a.rs", "use crate::b::*;\nfn f(_: G) {}\n"),
            ("b.rs", "pub mod c;\npub use c::G;\n"),
            ("b/c.rs", "pub struct G;\n"),
        ]);
        assert_eq!(found, ["a.rs:2 b/c.rs"]);
    }

    #[test]
    fn inline_modules_belong_to_their_file() {
        let found = edges(&[
            ("lib.rs", "mod a { pub mod b; pub fn f() {} }\nmod c;\n"),
            ("a/b.rs", "use super::super::c::g;\n"),
            ("c.rs", "pub fn g() { crate::a::f() }\nmacro_rules! m { () => {} }\n"),
        ]);
        assert_eq!(found, ["a/b.rs:1 c.rs", "c.rs:1 lib.rs"]);
    }

    #[test]
    fn a_function_named_like_its_module_is_found() {
        let found = edges(&[
            ("lib.rs", "mod a;\nmod b;\n"),
            ("a.rs", "use crate::b::c;\nfn f() { c() }\n"),
            ("b.rs", "mod c;\npub use c::c;\n"),
            ("b/c.rs", "pub fn c() {}\n"),
        ]);
        assert_eq!(found, ["a.rs:1 b/c.rs"]);
    }

    #[test]
    fn imports_in_a_circle_end() {
        assert!(
            edges(&[
                ("lib.rs", "mod a;\nmod b;\n"),
                ("a.rs", "pub use crate::b::x;\n"),
                ("b.rs", "pub use crate::a::x;\nfn f() { x() }\n")
            ])
            .is_empty()
        );
    }
}

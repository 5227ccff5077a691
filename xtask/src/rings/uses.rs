//! Names in the code of one module: its items, its imports, and every path in its code.
//!
//! Tests are ignored: items under `#[cfg(test)]` or `#[test]` contribute nothing.

use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, Macro, Meta, UseTree, Visibility};

/// The content of a module.
#[derive(Debug, Default)]
pub(crate) struct Content {
    /// Names of items that the module defines, without modules.
    pub(crate) items: BTreeSet<String>,
    /// Names of the macros defined in the module.
    pub(crate) macros: BTreeSet<String>,
    /// Imports of single names.
    pub(crate) imports: Vec<Import>,
    /// Paths in code, with the line of their first occurrence.
    pub(crate) paths: BTreeMap<Vec<String>, usize>,
    /// Modules declared here: inline ones with their content; the others are files.
    pub(crate) modules: Vec<(String, Option<Content>)>,
}

/// One name imported by a `use`, or all names of a module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Import {
    /// Name in this module; `None` for `*`.
    pub(crate) name: Option<String>,
    /// Path as written.
    pub(crate) path: Vec<String>,
    /// True if other modules may import the name from here.
    pub(crate) is_public: bool,
    /// Line, from 1.
    pub(crate) line: usize,
}

/// Reads the text of a file.
///
/// # Errors
/// A syntax error of Rust, with its line.
pub(crate) fn read(body: &str) -> Result<Content, (usize, String)> {
    let file = syn::parse_file(body).map_err(|error| (error.span().start().line, error.to_string()))?;
    Ok(content(&file.items))
}

fn content(items: &[Item]) -> Content {
    let mut content = Content::default();
    for item in items.iter().filter(|item| !is_test(attributes(item))) {
        if let Item::Mod(module) = item {
            let inner = module.content.as_ref().map(|(_, items)| self::content(items));
            content.modules.push((module.ident.to_string(), inner));
            continue;
        }
        content.define(item);
        content.visit_item(item);
    }
    content
}

impl Content {
    fn define(&mut self, item: &Item) {
        let name = match item {
            Item::Const(item) => &item.ident,
            Item::Enum(item) => &item.ident,
            Item::Fn(item) => &item.sig.ident,
            Item::Static(item) => &item.ident,
            Item::Struct(item) => &item.ident,
            Item::Trait(item) => &item.ident,
            Item::TraitAlias(item) => &item.ident,
            Item::Type(item) => &item.ident,
            Item::Union(item) => &item.ident,
            Item::Macro(item) => {
                self.macros.extend(item.ident.iter().map(ToString::to_string));
                return;
            }
            _ => return,
        };
        self.items.insert(name.to_string());
    }

    fn add_path(&mut self, path: Vec<String>, line: usize) {
        self.paths.entry(path).or_insert(line);
    }

    fn add_import(&mut self, tree: &UseTree, prefix: &[String], is_public: bool) {
        let joined = |name: &syn::Ident| {
            let mut path = prefix.to_vec();
            path.push(name.to_string());
            path
        };
        let (name, ident, path) = match tree {
            UseTree::Path(inner) => return self.add_import(&inner.tree, &joined(&inner.ident), is_public),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.add_import(tree, prefix, is_public));
            }
            UseTree::Glob(glob) => {
                let line = glob.star_token.spans.first().map_or(1, |span| span.start().line);
                return self.imports.push(Import { name: None, path: prefix.to_vec(), is_public, line });
            }
            // `use a::b::{self}` brings in `b`.
            UseTree::Name(name) if name.ident == "self" => (prefix.last().cloned(), &name.ident, prefix.to_vec()),
            UseTree::Name(name) => (Some(name.ident.to_string()), &name.ident, joined(&name.ident)),
            UseTree::Rename(rename) if rename.ident == "self" => {
                (Some(rename.rename.to_string()), &rename.ident, prefix.to_vec())
            }
            UseTree::Rename(rename) => (Some(rename.rename.to_string()), &rename.ident, joined(&rename.ident)),
        };
        self.imports.push(Import { name, path, is_public, line: ident.span().start().line });
    }

    /// Paths within the tokens of a macro call, which the parser cannot know.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let (mut line, mut colons) = (1, 0);
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.add_token_path(&mut path, line);
                        line = ident.span().start().line;
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(point) if point.as_char() == ':' && !path.is_empty() => colons += 1,
                TokenTree::Group(group) => {
                    self.add_token_path(&mut path, line);
                    colons = 0;
                    self.add_tokens(group.stream());
                }
                TokenTree::Punct(_) | TokenTree::Literal(_) => {
                    self.add_token_path(&mut path, line);
                    colons = 0;
                }
            }
        }
        self.add_token_path(&mut path, line);
    }

    fn add_token_path(&mut self, path: &mut Vec<String>, line: usize) {
        if !path.is_empty() {
            self.add_path(std::mem::take(path), line);
        }
    }
}

impl<'a> Visit<'a> for Content {
    fn visit_item(&mut self, item: &'a Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'a syn::ImplItemFn) {
        if !is_test(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        self.add_import(&item.tree, &[], !matches!(item.vis, Visibility::Inherited));
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        let line = path.segments.first().map_or(1, |segment| segment.ident.span().start().line);
        self.add_path(names, line);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'a Macro) {
        self.visit_path(&call.path);
        self.add_tokens(call.tokens.clone());
    }

    // Attributes and visibilities such as `pub(in crate::a)` import nothing.
    fn visit_attribute(&mut self, _: &'a Attribute) {}

    fn visit_visibility(&mut self, _: &'a Visibility) {}
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Returns true for `#[test]` and for `#[cfg(..)]` that names `test` other than in `not(test)`.
fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("cfg") => {
            let words = list.tokens.to_string();
            let mut words = words.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty());
            words.clone().any(|word| word == "test") && words.all(|word| word != "not")
        }
        Meta::List(_) | Meta::NameValue(_) => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(body: &str) -> Vec<String> {
        read(body).unwrap().paths.keys().map(|path| path.join("::")).collect()
    }

    #[test]
    fn imports_are_flattened() {
        let content = read("use a::{self, b as c, d::*};\npub(crate) use super::e;\nfn f() { use g::h; }\n").unwrap();
        let shown: Vec<String> = content
            .imports
            .iter()
            .map(|each| {
                format!(
                    "{} {} {} {}",
                    each.name.as_deref().unwrap_or("*"),
                    each.path.join("::"),
                    each.is_public,
                    each.line
                )
            })
            .collect();
        assert_eq!(shown, ["a a false 1", "c a::b false 1", "* a::d false 1", "e super::e true 2", "h g::h false 3"]);
    }

    #[test]
    fn paths_are_found_in_code_and_macro_calls_but_not_in_texts() {
        let body = "// crate::comment\nfn f(a: crate::a::A) -> B { print!(\"{} crate::text\", super::c::d(1)); }\n";
        let found = paths(body);
        for path in ["crate::a::A", "B", "print", "super::c::d"] {
            assert!(found.contains(&path.to_string()), "{path} in {found:?}");
        }
        assert!(!found.iter().any(|path| path.contains("text") || path.contains("comment")), "{found:?}");
    }

    #[test]
    fn tests_are_left_out() {
        let body = "#[cfg(test)]\nmod tests;\n#[test]\nfn t() { crate::a(); }\n#[cfg(test)]\nuse crate::b;\n#[cfg(not(test))]\nfn g() { crate::c(); }\n#[cfg(all(test, unix))]\nimpl A { fn h() { crate::d() } }\n";
        let content = read(body).unwrap();
        assert!(content.modules.is_empty() && content.imports.is_empty());
        assert_eq!(paths(body), ["crate::c"]);
    }

    #[test]
    fn what_is_not_rust_is_reported_with_its_line() {
        assert_eq!(read("fn a() {}\nfn (\n").unwrap_err().0, 2);
    }
}

//! A program's text as a tree of lists and atoms, sufficient to find places for mistakes.

use std::ops::Range;

/// Kind of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    List,
    Atom,
    Text,
}

/// A list, an atom or a string with its place in the text. Prefixes belong to the item after them.
#[derive(Clone, Debug)]
pub struct Node {
    pub kind: NodeKind,
    /// The text itself, without prefixes.
    pub range: Range<usize>,
    pub quoted: bool,
    pub parent: Option<usize>,
    pub children: Vec<usize>,
}

/// The nodes of a text in text order, and its top-level forms.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    pub nodes: Vec<Node>,
    pub forms: Vec<usize>,
}

impl Tree {
    /// Reads a text without mistakes.
    pub fn new(text: &str) -> Tree {
        let bytes = text.as_bytes();
        let mut tree = Tree::default();
        let mut open: Vec<usize> = Vec::new();
        let mut quoted = false;
        let mut at = 0;
        while at < bytes.len() {
            let start = at;
            match bytes[at] {
                b';' => at = text[at..].find('\n').map_or(text.len(), |length| at + length),
                b'(' => {
                    let index = tree.add(NodeKind::List, start..start, quoted, open.last().copied());
                    open.push(index);
                    at += 1;
                }
                b')' => {
                    at += 1;
                    let index = open.pop().unwrap();
                    tree.nodes[index].range.end = at;
                }
                b'"' => {
                    at += 2 + text[at + 1..].find('"').unwrap();
                    tree.add(NodeKind::Text, start..at, quoted, open.last().copied());
                }
                b'\'' | b',' | b'`' | b'#' => at += 1,
                byte if byte.is_ascii_whitespace() => at += 1,
                _ => {
                    let ends = |c: char| c.is_whitespace() || "()';\",`".contains(c);
                    at = text[at..].find(ends).map_or(text.len(), |length| at + length);
                    tree.add(NodeKind::Atom, start..at, quoted, open.last().copied());
                }
            }
            quoted = bytes[start] == b'\'';
        }
        tree
    }

    fn add(&mut self, kind: NodeKind, range: Range<usize>, quoted: bool, parent: Option<usize>) -> usize {
        let index = self.nodes.len();
        match parent {
            Some(parent) => self.nodes[parent].children.push(index),
            None => self.forms.push(index),
        }
        self.nodes.push(Node { kind, range, quoted, parent, children: Vec::new() });
        index
    }

    /// Returns the atom that a list begins with.
    pub fn head<'t>(&self, list: usize, text: &'t str) -> &'t str {
        let first = self.nodes[list].children.first().filter(|first| self.nodes[**first].kind == NodeKind::Atom);
        first.map_or("", |first| &text[self.nodes[*first].range.clone()])
    }

    /// Returns the items of a list after the first.
    pub fn tail(&self, list: usize) -> &[usize] {
        self.nodes[list].children.get(1..).unwrap_or_default()
    }
}

/// Returns the line of an offset, from 1.
pub fn line_of(text: &str, offset: usize) -> u32 {
    1 + u32::try_from(text[..offset].matches('\n').count()).unwrap()
}

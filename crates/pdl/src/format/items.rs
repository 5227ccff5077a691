//! The lossless tree without its white space: the input of the layout.

use crate::syntax::{SyntaxElement, SyntaxKind, SyntaxNode};

/// A datum or comment in its list.
pub(super) struct Entry {
    pub(super) piece: Piece,
    /// True if an empty line precedes it.
    pub(super) blank_before: bool,
    /// True if it is the first item of its line.
    pub(super) own_line: bool,
}

/// Kind of an entry.
pub(super) enum Piece {
    Datum(DatumNode),
    /// A `;` comment: the line ends after it.
    LineComment(String),
    /// A `#| |#` comment.
    BlockComment(String),
}

/// A datum.
pub(super) enum DatumNode {
    Atom(String),
    /// A prefix and its datum.
    Prefixed(String, Box<DatumNode>),
    /// A list with its width on one line, if it fits on one.
    List(Vec<Entry>, Option<usize>),
}

impl Entry {
    /// Returns its number of characters on one line; `None` if it does not fit on one line, or nothing can follow it.
    pub(super) fn flat_width(&self) -> Option<usize> {
        match &self.piece {
            Piece::Datum(node) => node.flat_width(),
            Piece::LineComment(_) => None,
            Piece::BlockComment(text) => one_line_width(text),
        }
    }

    pub(super) fn node(&self) -> Option<&DatumNode> {
        match &self.piece {
            Piece::Datum(node) => Some(node),
            _ => None,
        }
    }
}

impl DatumNode {
    pub(super) fn flat_width(&self) -> Option<usize> {
        match self {
            DatumNode::Atom(text) => one_line_width(text),
            DatumNode::Prefixed(prefix, inner) => inner.flat_width().map(|width| width + prefix.len()),
            DatumNode::List(_, width) => *width,
        }
    }

    /// Returns the text of an atom.
    pub(super) fn atom(&self) -> Option<&str> {
        match self {
            DatumNode::Atom(text) => Some(text),
            _ => None,
        }
    }

    /// Returns the folded name that a list begins with.
    pub(super) fn head(&self) -> Option<String> {
        match self {
            DatumNode::List(entries, _) => entries.first()?.node()?.atom().map(str::to_lowercase),
            _ => None,
        }
    }

    pub(super) fn is_keyword(&self) -> bool {
        self.atom().is_some_and(|text| text.starts_with(':') && text.len() > 1)
    }
}

fn one_line_width(text: &str) -> Option<usize> {
    (!text.contains('\n')).then(|| text.chars().count())
}

/// Returns the entries of a list or of the whole text.
pub(super) fn entries(node: &SyntaxNode) -> Vec<Entry> {
    let mut collected = Vec::new();
    let mut lines = 0;
    for element in node.children_with_tokens() {
        let piece = match &element {
            SyntaxElement::Token(token) => match token.kind() {
                SyntaxKind::WhiteSpace => {
                    lines += token.text().bytes().filter(|byte| *byte == b'\n').count();
                    continue;
                }
                SyntaxKind::LineComment => Piece::LineComment(token.text().trim_end().to_string()),
                SyntaxKind::BlockComment => Piece::BlockComment(token.text().to_string()),
                SyntaxKind::Atom | SyntaxKind::Text => Piece::Datum(DatumNode::Atom(token.text().to_string())),
                _ => continue,
            },
            SyntaxElement::Node(inner) if inner.kind() == SyntaxKind::List => Piece::Datum(list(inner)),
            SyntaxElement::Node(inner) => match prefixed(inner, &mut collected, &mut lines) {
                Some(node) => Piece::Datum(node),
                None => continue,
            },
        };
        let blank_before = lines >= 2 && !collected.is_empty();
        collected.push(Entry { piece, blank_before, own_line: lines > 0 });
        lines = 0;
    }
    collected
}

fn list(node: &SyntaxNode) -> DatumNode {
    let entries = entries(node);
    let widths: Option<Vec<usize>> = entries.iter().map(Entry::flat_width).collect();
    let width = widths.map(|widths| 2 + widths.iter().sum::<usize>() + widths.len().saturating_sub(1));
    DatumNode::List(entries, width)
}

/// Returns a prefix with its datum. Comments between the two move before the prefix, into `outer`.
fn prefixed(node: &SyntaxNode, outer: &mut Vec<Entry>, lines: &mut usize) -> Option<DatumNode> {
    let prefix = node.first_token().map(|token| token.text().to_string())?;
    for mut entry in entries(node) {
        match entry.piece {
            Piece::Datum(inner) => return Some(DatumNode::Prefixed(prefix, Box::new(inner))),
            _ => {
                entry.own_line |= *lines > 0;
                *lines = 1;
                outer.push(entry);
            }
        }
    }
    None
}

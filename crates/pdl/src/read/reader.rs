//! Walks the lossless tree in text order and builds data, counting lines and columns on the way.

use super::{Atom, Datum, DatumKind, classify};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::{Flaw, FlawKind, SyntaxElement, SyntaxKind, SyntaxNode, SyntaxToken, parse};
use apex_model::limits::{READ_DEPTH_MAX, SOURCE_BYTES_MAX};
use apex_model::quantity::{Dimension, Quantity, unit_named};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use std::sync::Arc;

/// The data of one source text.
pub(crate) struct ReadFile {
    /// Top-level data in order.
    pub(crate) data: Vec<Datum>,
    /// What is wrong with the text as text.
    pub(crate) diagnostics: Vec<Diagnostic>,
}

/// Reads the source text with number `file`.
pub(crate) fn read_file(file: u32, text: &str) -> ReadFile {
    if text.len() > SOURCE_BYTES_MAX {
        let span = Span { file, start: 0, end: 0, line: 1, column: 1 };
        let message = format!("this text has {} bytes; the limit is {SOURCE_BYTES_MAX}", text.len());
        let diagnostic = Diagnostic::error(codes::TOO_LARGE, span, message).help("split it into several files");
        return ReadFile { data: Vec::new(), diagnostics: vec![diagnostic] };
    }
    let parse = parse(text);
    let mut reader = Reader { file, line: 1, column: 1, offset: 0, diagnostics: Vec::new() };
    let data = reader.children(&parse.root);
    let mut diagnostics: Vec<Diagnostic> = parse.flaws.iter().map(|flaw| describe(file, text, flaw)).collect();
    diagnostics.append(&mut reader.diagnostics);
    ReadFile { data, diagnostics }
}

struct Reader {
    file: u32,
    line: u32,
    column: u32,
    offset: u32,
    diagnostics: Vec<Diagnostic>,
}

impl Reader {
    fn here(&self) -> Span {
        Span { file: self.file, start: self.offset, end: self.offset, line: self.line, column: self.column }
    }

    fn children(&mut self, node: &SyntaxNode) -> Vec<Datum> {
        node.children_with_tokens().filter_map(|element| self.element(&element)).collect()
    }

    fn element(&mut self, element: &SyntaxElement) -> Option<Datum> {
        match element {
            SyntaxElement::Token(token) => self.token(token),
            SyntaxElement::Node(node) if node.kind() == SyntaxKind::List => {
                let start = self.here();
                let items = self.children(node);
                let span = Span { end: self.offset, ..start };
                Some(Datum { kind: list_kind(items), span })
            }
            SyntaxElement::Node(node) => self.prefixed(node),
        }
    }

    fn prefixed(&mut self, node: &SyntaxNode) -> Option<Datum> {
        let prefix = node.first_token().map(|token| token.kind());
        let start = self.here();
        let inner = Box::new(self.children(node).into_iter().next()?);
        let kind = match prefix {
            Some(SyntaxKind::Quote) => DatumKind::Quote(inner),
            Some(SyntaxKind::Backquote) => DatumKind::Quasi(inner),
            Some(SyntaxKind::Comma) => DatumKind::Unquote(inner),
            Some(SyntaxKind::CommaAt) => DatumKind::Splice(inner),
            _ => DatumKind::Function(inner),
        };
        Some(Datum { kind, span: Span { end: self.offset, ..start } })
    }

    fn token(&mut self, token: &SyntaxToken) -> Option<Datum> {
        let start = self.here();
        let text = token.text();
        self.advance(text);
        let span = Span { end: self.offset, ..start };
        let kind = match token.kind() {
            SyntaxKind::Text => DatumKind::Text(unescape(text)),
            SyntaxKind::Atom => self.atom(text, span),
            _ => return None,
        };
        Some(Datum { kind, span })
    }

    fn atom(&mut self, text: &str, span: Span) -> DatumKind {
        match classify(text) {
            Atom::Integer(integer) => DatumKind::Integer(integer),
            Atom::Real(real) => DatumKind::Real(real),
            Atom::Quantity(quantity) => DatumKind::Quantity(quantity),
            Atom::Duration(duration) => DatumKind::Duration(duration),
            Atom::Symbol(symbol) if symbol.is("nil") => DatumKind::List(Vec::new()),
            Atom::Symbol(symbol) => DatumKind::Symbol(symbol),
            Atom::Variable(name) => DatumKind::Variable(name),
            Atom::Bound(name) => DatumKind::Bound(name),
            Atom::Anonymous => DatumKind::Anonymous,
            Atom::Indexical(name) => DatumKind::Indexical(name),
            Atom::OutOfRange => {
                let message = format!("`{text}` is too large for a number");
                let help = "write a smaller number, or the same quantity in a larger unit";
                self.diagnostics.push(Diagnostic::error(codes::NUMBER_RANGE, span, message).help(help));
                DatumKind::Symbol(Symbol::new(text))
            }
        }
    }

    fn advance(&mut self, text: &str) {
        let size = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        self.offset = self.offset.saturating_add(size(text.len()));
        match text.rsplit_once('\n') {
            Some((before, last_line)) => {
                let lines = 1 + before.bytes().filter(|byte| *byte == b'\n').count();
                self.line = self.line.saturating_add(size(lines));
                self.column = size(1 + last_line.chars().count());
            }
            None => self.column = self.column.saturating_add(size(text.chars().count())),
        }
    }
}

/// A list of numbers each followed by a unit is a quantity or duration; any other list is a list.
fn list_kind(items: Vec<Datum>) -> DatumKind {
    measured_list(&items).unwrap_or(DatumKind::List(items))
}

fn measured_list(items: &[Datum]) -> Option<DatumKind> {
    let mut total = 0.0;
    let mut unit = None;
    let mut rest = items;
    while let [number, name, after @ ..] = rest {
        let number = match number.kind {
            DatumKind::Integer(integer) => integer as f64,
            DatumKind::Real(real) => real,
            _ => return None,
        };
        let this = unit_named(name.as_symbol()?.printed())?;
        if unit.is_some_and(|first: &apex_model::quantity::Unit| first.dimension != this.dimension) {
            return None;
        }
        unit = unit.or(Some(this));
        total += number * this.factor;
        rest = after;
    }
    let unit = unit.filter(|_| rest.is_empty())?;
    if unit.dimension == Dimension::TIME {
        return Some(DatumKind::Duration(Duration::from_seconds(total)));
    }
    let quantity = match items {
        [Datum { kind: DatumKind::Integer(integer), .. }, _] => Quantity::of(*integer as f64, unit),
        [Datum { kind: DatumKind::Real(real), .. }, _] => Quantity::of(*real, unit),
        _ => Quantity { si: total, ..Quantity::of(0.0, unit) },
    };
    Some(DatumKind::Quantity(quantity))
}

/// The characters of a string token: `\x` is x.
fn unescape(token: &str) -> Arc<str> {
    let inner = token.strip_prefix('"').unwrap_or(token);
    if !inner.contains('\\') {
        return Arc::from(inner.strip_suffix('"').unwrap_or(inner));
    }
    let mut text = String::new();
    let mut characters = inner.chars();
    while let Some(character) = characters.next() {
        match character {
            '\\' => text.extend(characters.next()),
            '"' => break,
            other => text.push(other),
        }
    }
    Arc::from(text)
}

/// The place of a byte range. Costs a walk over the text before it: for flaws only, which are few.
fn locate(file: u32, text: &str, start: usize, end: usize) -> Span {
    let before = text.get(..start).unwrap_or(text);
    let line = 1 + before.bytes().filter(|byte| *byte == b'\n').count();
    let column = 1 + before.rsplit('\n').next().map_or(0, |last| last.chars().count());
    let size = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    Span { file, start: size(start), end: size(end), line: size(line), column: size(column) }
}

fn describe(file: u32, text: &str, flaw: &Flaw) -> Diagnostic {
    let span = locate(file, text, flaw.start, flaw.end);
    match flaw.kind {
        FlawKind::UnmatchedClose => Diagnostic::error(codes::UNMATCHED_CLOSE, span, "unmatched )")
            .reason("every list before it is closed already")
            .help("remove it, or add the `(` that it should close"),
        FlawKind::UnclosedList { suspect, next } => {
            let mut diagnostic = Diagnostic::error(codes::UNCLOSED_LIST, span, "this ( is never closed");
            if let Some(suspect) = suspect {
                let place = locate(file, text, suspect, suspect + 1);
                diagnostic = diagnostic.label(place, "by the indentation, this list lacks its `)`");
            }
            match next {
                Some(next) => {
                    let place = locate(file, text, next, next + 1);
                    diagnostic.label(place, "a new form begins here").help("add `)` before the new form")
                }
                None => diagnostic.reason("the text ends inside this list").help("add the missing `)`"),
            }
        }
        FlawKind::UnclosedText => Diagnostic::error(codes::UNCLOSED_STRING, span, "this string is never closed")
            .help("add the closing `\"`; a `\"` inside a string is written `\\\"`"),
        FlawKind::UnclosedComment => {
            Diagnostic::error(codes::UNCLOSED_COMMENT, span, "this comment is never closed").help("add `|#`")
        }
        FlawKind::DanglingPrefix => {
            let mark = text.get(flaw.start..flaw.end).unwrap_or("'");
            Diagnostic::error(codes::DANGLING_PREFIX, span, format!("nothing follows this {mark}"))
                .help("remove it, or write what it applies to")
        }
        FlawKind::TooDeep => {
            Diagnostic::error(codes::TOO_DEEP, span, format!("lists are nested deeper than {READ_DEPTH_MAX}"))
                .help("split the form into several procedures or functions")
        }
    }
}

//! Builds data from the structure of a text.

use super::{Atom, Datum, DatumKind, classify, flaws};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::syntax::{Position, Sink, SyntaxKind, brackets, parse_into, with_parentheses};
use apex_model::limits::SOURCE_BYTES_MAX;
use apex_model::quantity::{Dimension, Quantity, unit_named};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The data of one source text.
pub(crate) struct ReadFile {
    /// Top-level data in order.
    pub(crate) data: Vec<Datum>,
    /// Defects of the text as text.
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
    let bracketed = brackets(text);
    if bracketed.is_empty() {
        return read_parenthesised(file, text);
    }
    // Brackets are read as the parentheses that were meant, so that they cause no further errors.
    let mended = with_parentheses(text, &bracketed);
    let mut read = read_parenthesised(file, &mended);
    read.diagnostics.splice(0..0, flaws::brackets(file, text, &bracketed));
    read
}

fn read_parenthesised(file: u32, text: &str) -> ReadFile {
    let (reader, flaws) = parse_into(text, || Reader::new(file));
    let mut diagnostics = flaws::describe(file, text, &flaws);
    diagnostics.extend(reader.diagnostics);
    ReadFile { data: reader.data, diagnostics }
}

/// Builds data from the structure of a text.
struct Reader<'t> {
    file: u32,
    /// Top-level data, followed by the parts of open lists, outer ones first: each list is then created with its final size.
    data: Vec<Datum>,
    open: Vec<OpenList>,
    /// End of the last token, in bytes.
    end: usize,
    /// The symbol of each name that has occurred: equal names share one symbol, which makes their comparison fast.
    symbols: FxHashMap<&'t str, Symbol>,
    diagnostics: Vec<Diagnostic>,
}

/// A list or a prefixed datum whose end has not been seen.
struct OpenList {
    at: Position,
    prefix: Option<SyntaxKind>,
    /// Number of data before its parts.
    before: usize,
}

impl<'t> Sink<'t> for Reader<'t> {
    fn open(&mut self, _: SyntaxKind, at: Position) {
        self.open.push(OpenList { at, prefix: None, before: self.data.len() });
    }

    fn token(&mut self, kind: SyntaxKind, text: &'t str, at: Position) {
        self.end = at.offset + text.len();
        let kind = match kind {
            SyntaxKind::Atom => self.atom(text, at),
            SyntaxKind::Text => DatumKind::Text(unescape(text)),
            SyntaxKind::Quote
            | SyntaxKind::Backquote
            | SyntaxKind::Comma
            | SyntaxKind::CommaAt
            | SyntaxKind::HashQuote => {
                if let Some(open) = self.open.last_mut() {
                    open.prefix = Some(kind);
                }
                return;
            }
            _ => return,
        };
        self.push(kind, at);
    }

    fn close(&mut self) {
        let Some(open) = self.open.pop() else { return };
        let items: Vec<Datum> = self.data.drain(open.before.min(self.data.len())..).collect();
        let Some(prefix) = open.prefix else {
            return self.push(list_kind(items), open.at);
        };
        // A prefix without a datum has been reported.
        let Some(inner) = items.into_iter().next().map(Box::new) else { return };
        let kind = match prefix {
            SyntaxKind::Quote => DatumKind::Quote(inner),
            SyntaxKind::Backquote => DatumKind::Quasi(inner),
            SyntaxKind::Comma => DatumKind::Unquote(inner),
            SyntaxKind::CommaAt => DatumKind::Splice(inner),
            _ => DatumKind::Function(inner),
        };
        self.push(kind, open.at);
    }
}

impl<'t> Reader<'t> {
    fn new(file: u32) -> Reader<'t> {
        Reader {
            file,
            data: Vec::new(),
            open: Vec::new(),
            end: 0,
            symbols: FxHashMap::default(),
            diagnostics: Vec::new(),
        }
    }

    fn push(&mut self, kind: DatumKind, at: Position) {
        let span = self.span(at);
        self.data.push(Datum { kind, span });
    }

    /// Returns the span from `at` to the end of the last token.
    fn span(&self, at: Position) -> Span {
        Span {
            file: self.file,
            start: size(at.offset),
            end: size(self.end),
            line: size(at.line),
            column: size(at.column),
        }
    }

    fn symbol(&mut self, name: &'t str) -> Symbol {
        self.symbols.entry(name).or_insert_with(|| Symbol::new(name)).clone()
    }

    fn atom(&mut self, text: &'t str, at: Position) -> DatumKind {
        match classify(text) {
            Atom::Integer(integer) => DatumKind::Integer(integer),
            Atom::Real(real) => DatumKind::Real(real),
            Atom::Quantity(quantity) => DatumKind::Quantity(quantity),
            Atom::Duration(duration) => DatumKind::Duration(duration),
            Atom::Symbol(name) if name.eq_ignore_ascii_case("nil") => DatumKind::List(Vec::new()),
            Atom::Symbol(name) => {
                if !name.is_ascii() {
                    self.diagnostics.extend(flaws::typographic_quote(name, self.span(at)));
                }
                DatumKind::Symbol(self.symbol(name))
            }
            Atom::Variable(name) => DatumKind::Variable(self.symbol(name)),
            Atom::Bound(name) => DatumKind::Bound(self.symbol(name)),
            Atom::Anonymous => DatumKind::Anonymous,
            Atom::Indexical(name) => DatumKind::Indexical(self.symbol(name)),
            Atom::OutOfRange => {
                let message = format!("`{text}` is too large for a number");
                let help = "write a smaller number, or the same quantity in a larger unit";
                self.diagnostics.push(Diagnostic::error(codes::NUMBER_RANGE, self.span(at), message).help(help));
                DatumKind::Symbol(self.symbol(text))
            }
        }
    }
}

/// Converts a byte offset or a column. It fits, because a source text has at most `SOURCE_BYTES_MAX` bytes.
fn size(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// Returns the kind of a list: numbers each followed by a unit are a quantity or duration, any other list is a list.
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

/// Returns the characters of a string token: `\x` is x.
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

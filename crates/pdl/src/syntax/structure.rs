//! Matching of opening and closing tokens, without recursion, so that nesting uses no stack.

use super::lexer::{Token, tokens};
use super::{Flaw, FlawKind, Position, Sink, SyntaxKind};
use apex_model::limits::READ_DEPTH_MAX;

/// Maximum number of flaws reported for one text.
const FLAWS_MAX: usize = 50;

/// Passes the structure of `text` to a sink; returns the sink and the flaws of the text. Never fails.
///
/// A text that is cut short is reported a second time, to a new sink.
pub(crate) fn parse_into<'t, S: Sink<'t>>(text: &'t str, sink: impl Fn() -> S) -> (S, Vec<Flaw>) {
    let mut balanced = run(text, sink(), false);
    let swallowed = |flaw: &Flaw| matches!(flaw.kind, FlawKind::UnclosedText | FlawKind::UnclosedComment);
    if balanced.1.iter().any(swallowed) {
        // The open string or comment has swallowed the closing parentheses: they are not missing.
        balanced.1.retain(|flaw| !matches!(flaw.kind, FlawKind::UnclosedList { .. }));
    }
    let cut_short = balanced.1.iter().any(|flaw| matches!(flaw.kind, FlawKind::UnclosedList { .. }));
    // Only a text that lacks a `)` is cut where a new form starts in the first column.
    if cut_short { run(text, sink(), true) } else { balanced }
}

#[derive(Clone, Copy)]
struct OpenForm {
    is_list: bool,
    start: usize,
    column: usize,
}

struct Structure<S> {
    sink: S,
    flaws: Vec<Flaw>,
    stack: Vec<OpenForm>,
    /// Open parentheses beyond the depth limit.
    overflow: usize,
    /// An inner list that probably lacks its `)`.
    suspect: Option<usize>,
    at: Position,
    first_on_line: bool,
}

fn run<'t, S: Sink<'t>>(text: &'t str, sink: S, cut: bool) -> (S, Vec<Flaw>) {
    let mut structure = Structure {
        sink,
        flaws: Vec::new(),
        stack: Vec::new(),
        overflow: 0,
        suspect: None,
        at: Position { offset: 0, line: 1, column: 1 },
        first_on_line: true,
    };
    for token in tokens(text) {
        if cut && token.kind == SyntaxKind::Open && structure.at.column == 1 && !structure.stack.is_empty() {
            structure.close_all(Some(structure.at.offset));
        }
        structure.take(&token);
        structure.advance(&token);
    }
    structure.close_all(None);
    (structure.sink, structure.flaws)
}

impl<'t, S: Sink<'t>> Structure<S> {
    fn take(&mut self, token: &Token<'t>) {
        match token.kind {
            SyntaxKind::WhiteSpace | SyntaxKind::LineComment => self.push(token.kind, token.text),
            SyntaxKind::BlockComment => {
                if token.unclosed {
                    self.flaw(FlawKind::UnclosedComment, self.at.offset, self.at.offset + 2);
                }
                self.push(token.kind, token.text);
            }
            SyntaxKind::Open => self.open(token.text),
            SyntaxKind::Close => self.close(token.text),
            SyntaxKind::Quote
            | SyntaxKind::Backquote
            | SyntaxKind::Comma
            | SyntaxKind::CommaAt
            | SyntaxKind::HashQuote => self.prefix(token),
            _ => {
                if token.unclosed {
                    self.flaw(FlawKind::UnclosedText, self.at.offset, self.at.offset + 1);
                }
                self.push(token.kind, token.text);
                self.finish_prefixes();
            }
        }
    }

    fn open(&mut self, text: &'t str) {
        if self.too_deep() {
            self.overflow += 1;
            self.push(SyntaxKind::Stray, text);
            return;
        }
        let enclosing = self.stack.iter().rev().find(|open| open.is_list);
        if let Some(enclosing) = enclosing
            && self.first_on_line
            && self.at.column <= enclosing.column
            && self.suspect.is_none()
        {
            self.suspect = Some(enclosing.start);
        }
        self.sink.open(SyntaxKind::List, self.at);
        self.push(SyntaxKind::Open, text);
        self.stack.push(OpenForm { is_list: true, start: self.at.offset, column: self.at.column });
    }

    fn close(&mut self, text: &'t str) {
        if self.overflow > 0 {
            self.overflow -= 1;
            self.push(SyntaxKind::Stray, text);
            return;
        }
        self.drop_dangling_prefixes();
        if self.stack.pop().is_none() {
            self.flaw(FlawKind::UnmatchedClose, self.at.offset, self.at.offset + 1);
            self.push(SyntaxKind::Stray, text);
            return;
        }
        self.push(SyntaxKind::Close, text);
        self.sink.close();
        self.finish_prefixes();
        if self.stack.is_empty() {
            self.suspect = None;
        }
    }

    fn prefix(&mut self, token: &Token<'t>) {
        if self.too_deep() {
            self.push(SyntaxKind::Stray, token.text);
            return;
        }
        self.sink.open(SyntaxKind::Prefixed, self.at);
        self.push(token.kind, token.text);
        self.stack.push(OpenForm { is_list: false, start: self.at.offset, column: self.at.column });
    }

    fn too_deep(&mut self) -> bool {
        let deep = self.stack.len() >= READ_DEPTH_MAX;
        if deep && !self.flaws.iter().any(|flaw| flaw.kind == FlawKind::TooDeep) {
            self.flaw(FlawKind::TooDeep, self.at.offset, self.at.offset + 1);
        }
        deep
    }

    /// Ends the prefixes whose datum was just read.
    fn finish_prefixes(&mut self) {
        while self.stack.last().is_some_and(|open| !open.is_list) {
            self.stack.pop();
            self.sink.close();
        }
    }

    /// Ends prefixes that found no datum.
    fn drop_dangling_prefixes(&mut self) {
        while let Some(open) = self.stack.last().copied().filter(|open| !open.is_list) {
            self.flaw(FlawKind::DanglingPrefix, open.start, open.start + 1);
            self.stack.pop();
            self.sink.close();
        }
    }

    fn close_all(&mut self, next: Option<usize>) {
        self.drop_dangling_prefixes();
        let outermost = self.stack.iter().find(|open| open.is_list).map(|open| open.start);
        if let Some(start) = outermost {
            let suspect = self.suspect.filter(|suspect| *suspect != start);
            self.flaw(FlawKind::UnclosedList { suspect, next }, start, start + 1);
        }
        for _ in 0..self.stack.len() {
            self.sink.close();
        }
        self.stack.clear();
        self.suspect = None;
        self.overflow = 0;
    }

    fn push(&mut self, kind: SyntaxKind, text: &'t str) {
        self.sink.token(kind, text, self.at);
    }

    fn flaw(&mut self, kind: FlawKind, start: usize, end: usize) {
        if self.flaws.len() < FLAWS_MAX {
            self.flaws.push(Flaw { kind, start, end });
        }
    }

    fn advance(&mut self, token: &Token<'t>) {
        let text = token.text;
        self.at.offset += text.len();
        // Only these tokens may extend over several lines; the others make up most of a text.
        let many_lines = matches!(token.kind, SyntaxKind::WhiteSpace | SyntaxKind::BlockComment | SyntaxKind::Text);
        let lines = if many_lines { text.rsplit_once('\n') } else { None };
        match lines {
            Some((before, last_line)) => {
                self.at.line += 1 + before.bytes().filter(|byte| *byte == b'\n').count();
                self.at.column = 1 + last_line.chars().count();
                self.first_on_line = token.kind == SyntaxKind::WhiteSpace;
            }
            None => {
                // A byte order mark has no width.
                self.at.column += if text == "\u{feff}" { 0 } else { text.chars().count() };
                self.first_on_line &= token.kind == SyntaxKind::WhiteSpace;
            }
        }
    }
}

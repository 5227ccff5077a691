//! Tokens to a tree of lists. No recursion: nesting costs no stack here.

use super::lexer::{Token, tokens};
use super::{Flaw, FlawKind, Parse, Pdl, SyntaxKind, SyntaxNode};
use apex_model::limits::READ_DEPTH_MAX;
use rowan::{GreenNodeBuilder, Language};

/// Flaws reported of one text; more would not be read.
const FLAWS_MAX: usize = 50;

/// The tree of `text`. Never fails.
pub(crate) fn parse(text: &str) -> Parse {
    let tokens = tokens(text);
    let mut balanced = run(&tokens, false);
    let swallowed = |flaw: &Flaw| matches!(flaw.kind, FlawKind::UnclosedText | FlawKind::UnclosedComment);
    if balanced.1.iter().any(swallowed) {
        // The open string or comment has swallowed the closing parentheses: they are not missing.
        balanced.1.retain(|flaw| !matches!(flaw.kind, FlawKind::UnclosedList { .. }));
    }
    let cut_short = balanced.1.iter().any(|flaw| matches!(flaw.kind, FlawKind::UnclosedList { .. }));
    // Only a text that lacks a `)` is cut where a new form starts in the first column.
    let (root, flaws) = if cut_short { run(&tokens, true) } else { balanced };
    Parse { root, flaws }
}

#[derive(Clone, Copy)]
struct Open {
    is_list: bool,
    start: usize,
    column: usize,
}

struct TreeBuilder {
    green: GreenNodeBuilder<'static>,
    flaws: Vec<Flaw>,
    stack: Vec<Open>,
    /// Open parentheses beyond the depth limit.
    overflow: usize,
    /// An inner list that probably lacks its `)`.
    suspect: Option<usize>,
    offset: usize,
    column: usize,
    first_on_line: bool,
}

fn run(tokens: &[Token<'_>], cut: bool) -> (SyntaxNode, Vec<Flaw>) {
    let mut builder = TreeBuilder {
        green: GreenNodeBuilder::new(),
        flaws: Vec::new(),
        stack: Vec::new(),
        overflow: 0,
        suspect: None,
        offset: 0,
        column: 1,
        first_on_line: true,
    };
    builder.green.start_node(Pdl::kind_to_raw(SyntaxKind::Root));
    for token in tokens {
        if cut && token.kind == SyntaxKind::Open && builder.column == 1 && !builder.stack.is_empty() {
            builder.close_all(Some(builder.offset));
        }
        builder.take(token);
        builder.advance(token);
    }
    builder.close_all(None);
    builder.green.finish_node();
    (SyntaxNode::new_root(builder.green.finish()), builder.flaws)
}

impl TreeBuilder {
    fn take(&mut self, token: &Token<'_>) {
        match token.kind {
            SyntaxKind::WhiteSpace | SyntaxKind::LineComment => self.push(token.kind, token.text),
            SyntaxKind::BlockComment => {
                if token.unclosed {
                    self.flaw(FlawKind::UnclosedComment, self.offset, self.offset + 2);
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
                    self.flaw(FlawKind::UnclosedText, self.offset, self.offset + 1);
                }
                self.push(token.kind, token.text);
                self.finish_prefixes();
            }
        }
    }

    fn open(&mut self, text: &str) {
        if self.too_deep() {
            self.overflow += 1;
            self.push(SyntaxKind::Stray, text);
            return;
        }
        let enclosing = self.stack.iter().rev().find(|open| open.is_list);
        if let Some(enclosing) = enclosing
            && self.first_on_line
            && self.column <= enclosing.column
            && self.suspect.is_none()
        {
            self.suspect = Some(enclosing.start);
        }
        self.green.start_node(Pdl::kind_to_raw(SyntaxKind::List));
        self.push(SyntaxKind::Open, text);
        self.stack.push(Open { is_list: true, start: self.offset, column: self.column });
    }

    fn close(&mut self, text: &str) {
        if self.overflow > 0 {
            self.overflow -= 1;
            self.push(SyntaxKind::Stray, text);
            return;
        }
        self.drop_dangling_prefixes();
        if self.stack.pop().is_none() {
            self.flaw(FlawKind::UnmatchedClose, self.offset, self.offset + 1);
            self.push(SyntaxKind::Stray, text);
            return;
        }
        self.push(SyntaxKind::Close, text);
        self.green.finish_node();
        self.finish_prefixes();
        if self.stack.is_empty() {
            self.suspect = None;
        }
    }

    fn prefix(&mut self, token: &Token<'_>) {
        if self.too_deep() {
            self.push(SyntaxKind::Stray, token.text);
            return;
        }
        self.green.start_node(Pdl::kind_to_raw(SyntaxKind::Prefixed));
        self.push(token.kind, token.text);
        self.stack.push(Open { is_list: false, start: self.offset, column: self.column });
    }

    fn too_deep(&mut self) -> bool {
        let deep = self.stack.len() >= READ_DEPTH_MAX;
        if deep && !self.flaws.iter().any(|flaw| flaw.kind == FlawKind::TooDeep) {
            self.flaw(FlawKind::TooDeep, self.offset, self.offset + 1);
        }
        deep
    }

    /// Ends prefixes whose datum has just been read.
    fn finish_prefixes(&mut self) {
        while self.stack.last().is_some_and(|open| !open.is_list) {
            self.stack.pop();
            self.green.finish_node();
        }
    }

    /// Ends prefixes that found no datum.
    fn drop_dangling_prefixes(&mut self) {
        while let Some(open) = self.stack.last().copied().filter(|open| !open.is_list) {
            self.flaw(FlawKind::DanglingPrefix, open.start, open.start + 1);
            self.stack.pop();
            self.green.finish_node();
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
            self.green.finish_node();
        }
        self.stack.clear();
        self.suspect = None;
        self.overflow = 0;
    }

    fn push(&mut self, kind: SyntaxKind, text: &str) {
        self.green.token(Pdl::kind_to_raw(kind), text);
    }

    fn flaw(&mut self, kind: FlawKind, start: usize, end: usize) {
        if self.flaws.len() < FLAWS_MAX {
            self.flaws.push(Flaw { kind, start, end });
        }
    }

    fn advance(&mut self, token: &Token<'_>) {
        self.offset += token.text.len();
        match token.text.rsplit_once('\n') {
            Some((_, last_line)) => {
                self.column = 1 + last_line.chars().count();
                self.first_on_line = token.kind == SyntaxKind::WhiteSpace;
            }
            None => {
                self.column += token.text.chars().count();
                self.first_on_line &= token.kind == SyntaxKind::WhiteSpace;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lossless(text: &str) -> Vec<FlawKind> {
        let parse = parse(text);
        assert_eq!(parse.root.text().to_string(), text);
        parse.flaws.into_iter().map(|flaw| flaw.kind).collect()
    }

    #[test]
    fn every_text_has_a_tree_with_the_same_text() {
        assert_eq!(lossless("(a #| x #| y |# |# 'b ; c\n \"s\\\"\")"), []);
        assert_eq!(lossless("a))"), [FlawKind::UnmatchedClose, FlawKind::UnmatchedClose]);
        assert_eq!(lossless("(a ')"), [FlawKind::DanglingPrefix]);
        assert_eq!(lossless("\"abc"), [FlawKind::UnclosedText]);
    }

    #[test]
    fn an_unclosed_form_ends_where_the_next_one_starts_in_the_first_column() {
        let text = "(a (b\n  (c))\n(d)\n(e)";
        assert_eq!(lossless(text), [FlawKind::UnclosedList { suspect: Some(3), next: Some(13) }]);
        assert_eq!(lossless("(a\n(d))"), []);
    }

    #[test]
    fn depth_is_limited_once() {
        let text = "(".repeat(1000) + &")".repeat(1000);
        assert_eq!(lossless(&text), [FlawKind::TooDeep]);
    }
}

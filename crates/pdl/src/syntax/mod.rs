//! Structure of text. Every text has one; no character is lost, and flaws are listed separately.
//!
//! One walk over the text passes its structure to a [`Sink`]: the formatter keeps all of it as a lossless tree, the checker only its
//! data, which is faster.

mod balance;
mod brackets;
mod lexer;
mod shape;
mod structure;
mod tree;

pub(crate) use balance::{Repair, Repaired, repairs};
pub(crate) use brackets::{Bracketed, brackets, with_parentheses};
pub(crate) use structure::parse_into;
pub(crate) use tree::parse;

/// Kinds of tokens and nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u16)]
pub(crate) enum SyntaxKind {
    /// Blanks and line ends.
    WhiteSpace,
    /// `;` to the end of the line, the line end not included.
    LineComment,
    /// `#| .. |#`, nestable.
    BlockComment,
    /// `(`
    Open,
    /// `)`
    Close,
    /// `'`
    Quote,
    /// A backquote.
    Backquote,
    /// `,`
    Comma,
    /// `,@`
    CommaAt,
    /// `#'`
    HashQuote,
    /// A string with its quotes.
    Text,
    /// A number, quantity, symbol, variable or indexical.
    Atom,
    /// A parenthesis that has no part in any list.
    Stray,
    /// A list with its parentheses.
    List,
    /// A prefix (one of five) with its datum.
    Prefixed,
    /// The whole text.
    Root,
}

const KINDS: &[SyntaxKind] = &[
    SyntaxKind::WhiteSpace,
    SyntaxKind::LineComment,
    SyntaxKind::BlockComment,
    SyntaxKind::Open,
    SyntaxKind::Close,
    SyntaxKind::Quote,
    SyntaxKind::Backquote,
    SyntaxKind::Comma,
    SyntaxKind::CommaAt,
    SyntaxKind::HashQuote,
    SyntaxKind::Text,
    SyntaxKind::Atom,
    SyntaxKind::Stray,
    SyntaxKind::List,
    SyntaxKind::Prefixed,
    SyntaxKind::Root,
];

/// PDL for `rowan`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Pdl {}

impl rowan::Language for Pdl {
    type Kind = SyntaxKind;

    fn kind_from_raw(raw: rowan::SyntaxKind) -> SyntaxKind {
        KINDS.get(usize::from(raw.0)).copied().unwrap_or(SyntaxKind::Stray)
    }

    fn kind_to_raw(kind: SyntaxKind) -> rowan::SyntaxKind {
        rowan::SyntaxKind(kind as u16)
    }
}

pub(crate) type SyntaxNode = rowan::SyntaxNode<Pdl>;
pub(crate) type SyntaxElement = rowan::SyntaxElement<Pdl>;

/// Beginning of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Position {
    /// In bytes.
    pub(crate) offset: usize,
    /// From 1.
    pub(crate) line: usize,
    /// From 1, in characters.
    pub(crate) column: usize,
}

/// Receives the structure of a text, in text order. Opens and closes are balanced.
pub(crate) trait Sink<'t> {
    /// Begins a list or a prefixed datum.
    fn open(&mut self, kind: SyntaxKind, at: Position);
    /// Adds the next token; the texts of all tokens joined are the text.
    fn token(&mut self, kind: SyntaxKind, text: &'t str, at: Position);
    /// Ends the innermost open list or prefixed datum after the last token.
    fn close(&mut self);
}

/// Defect of a text as text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FlawKind {
    /// `)` closes nothing.
    UnmatchedClose,
    /// `(` is never closed.
    UnclosedList {
        /// Place at which an inner list probably lacks its `)`.
        suspect: Option<usize>,
        /// Beginning of the next form, if the text was cut there.
        next: Option<usize>,
    },
    /// A string is never closed.
    UnclosedText,
    /// A block comment is never closed.
    UnclosedComment,
    /// A prefix without datum.
    DanglingPrefix,
    /// Nested too deeply.
    TooDeep,
}

/// One flaw with its byte offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Flaw {
    pub(crate) kind: FlawKind,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

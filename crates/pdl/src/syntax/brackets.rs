//! Brackets and braces used instead of parentheses: `[waitfor ?s1]`.
//!
//! PDL does not use brackets, and as parts of words each would damage its context. A bracket inside a word that also ends there, as in
//! `cell[3]`, is part of the word.

use super::SyntaxKind;
use super::lexer::{Token, tokens};

/// Maximum number of brackets reported for one text.
const BRACKETS_MAX: usize = 50;

/// A bracket and its partner, as byte offsets; at least one of them is not a parenthesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bracketed {
    /// Place of the opening bracket, unless it is `(` or absent.
    pub(crate) open: Option<usize>,
    /// Place of the closing bracket, unless it is `)` or absent.
    pub(crate) close: Option<usize>,
}

/// Returns the forms written with brackets, in the order of the opening ones. Fast for texts without brackets.
pub(crate) fn brackets(text: &str) -> Vec<Bracketed> {
    if !text.bytes().any(|byte| matches!(byte, b'[' | b']' | b'{' | b'}')) {
        return Vec::new();
    }
    let mut search = BracketMatcher { stack: Vec::new(), found: Vec::new() };
    let mut at = 0;
    for token in tokens(text) {
        search.take(&token, at);
        at += token.text.len();
    }
    search.finish()
}

/// Returns the text with parentheses in place of these brackets; all other characters keep their offsets.
pub(crate) fn with_parentheses(text: &str, found: &[Bracketed]) -> String {
    let mut places: Vec<(usize, char)> = found
        .iter()
        .flat_map(|pair| pair.open.map(|at| (at, '(')).into_iter().chain(pair.close.map(|at| (at, ')'))))
        .collect();
    places.sort_unstable();
    let mut mended = String::with_capacity(text.len());
    let mut from = 0;
    for (at, parenthesis) in places {
        mended.push_str(text.get(from..at).unwrap_or_default());
        mended.push(parenthesis);
        from = at + 1;
    }
    mended.push_str(text.get(from..).unwrap_or_default());
    mended
}

struct BracketMatcher {
    /// Open brackets: the place of a bracket, `None` for a parenthesis.
    stack: Vec<Option<usize>>,
    found: Vec<Bracketed>,
}

impl BracketMatcher {
    fn take(&mut self, token: &Token<'_>, at: usize) {
        match token.kind {
            SyntaxKind::Open => self.stack.push(None),
            SyntaxKind::Close => {
                if let Some(open) = self.stack.pop().flatten() {
                    self.found.push(Bracketed { open: Some(open), close: None });
                }
            }
            SyntaxKind::Atom => self.atom(token.text, at),
            _ => {}
        }
    }

    fn atom(&mut self, text: &str, at: usize) {
        let mut part_of_word = false;
        let last_close = text.rfind([']', '}']);
        for (offset, character) in text.char_indices() {
            let place = at + offset;
            match character {
                '[' | '{' => {
                    let ends_here = last_close.is_some_and(|last| last > offset);
                    part_of_word = offset > 0 && ends_here && !text.starts_with(['[', '{']);
                    if !part_of_word {
                        self.stack.push(Some(place));
                    }
                }
                ']' | '}' if part_of_word => part_of_word = false,
                ']' | '}' => {
                    let open = self.stack.pop().flatten();
                    self.found.push(Bracketed { open, close: Some(place) });
                }
                _ => {}
            }
        }
    }

    fn finish(mut self) -> Vec<Bracketed> {
        let unclosed = self.stack.iter().flatten().map(|open| Bracketed { open: Some(*open), close: None });
        self.found.extend(unclosed);
        self.found.sort_unstable_by_key(|pair| pair.open.or(pair.close));
        self.found.truncate(BRACKETS_MAX);
        self.found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mended(text: &str) -> String {
        with_parentheses(text, &brackets(text))
    }

    #[test]
    fn brackets_become_parentheses_and_nothing_else_moves() {
        assert_eq!(mended("(index [look ?x])"), "(index (look ?x))");
        assert_eq!(mended("(index[look {at ?x}])"), "(index(look (at ?x)))");
        assert_eq!(mended("[a] (b] [c)"), "(a) (b) (c)");
        assert_eq!(mended("(a \u{e9}[b ?\u{e9}])"), "(a \u{e9}(b ?\u{e9}))");
        assert_eq!(brackets("(a] ]").len(), 2);
        assert_eq!(brackets("[a"), [Bracketed { open: Some(0), close: None }]);
    }

    #[test]
    fn words_strings_and_comments_keep_theirs() {
        for text in ["(cell[3] a{b}c)", "\"[a]\" ; [b]\n #| {c} |#", "(plain)"] {
            assert_eq!(brackets(text), [], "{text}");
        }
    }
}

//! Splits text into tokens. Every character belongs to exactly one token.

use super::SyntaxKind;

/// One token: its kind, its text, and true if its closing mark is missing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'t> {
    pub(super) kind: SyntaxKind,
    pub(super) text: &'t str,
    pub(super) unclosed: bool,
}

/// Returns the tokens of `text` in order; their texts joined are `text`.
pub(super) fn tokens(text: &str) -> impl Iterator<Item = Token<'_>> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let first = rest.chars().next()?;
        let (kind, length, unclosed) = first_token(rest, first);
        let length = length.clamp(first.len_utf8(), rest.len());
        let (token, after) = rest.split_at_checked(length)?;
        rest = after;
        Some(Token { kind, text: token, unclosed })
    })
}

/// Returns the kind and the length in bytes of the first token of `rest`.
fn first_token(rest: &str, first: char) -> (SyntaxKind, usize, bool) {
    let single = |kind| (kind, 1, false);
    match first {
        '(' => single(SyntaxKind::Open),
        ')' => single(SyntaxKind::Close),
        '\'' => single(SyntaxKind::Quote),
        '`' => single(SyntaxKind::Backquote),
        ',' if rest.starts_with(",@") => (SyntaxKind::CommaAt, 2, false),
        ',' => single(SyntaxKind::Comma),
        '"' => string(rest),
        ';' => (SyntaxKind::LineComment, rest.find('\n').unwrap_or(rest.len()), false),
        '#' if rest.starts_with("#|") => block_comment(rest),
        '#' if rest.starts_with("#'") => (SyntaxKind::HashQuote, 2, false),
        // A byte order mark.
        '\u{feff}' => (SyntaxKind::WhiteSpace, first.len_utf8(), false),
        blank if blank.is_whitespace() => (SyntaxKind::WhiteSpace, length_until(rest, |c| !c.is_whitespace()), false),
        _ => (SyntaxKind::Atom, length_until(rest, ends_atom), false),
    }
}

/// Returns the number of bytes before the first character that satisfies `wanted`. Most texts are ASCII, whose characters are single
/// bytes.
fn length_until(rest: &str, wanted: impl Fn(char) -> bool) -> usize {
    let is_end = |byte: &u8| !byte.is_ascii() || wanted(char::from(*byte));
    let ascii = rest.as_bytes().iter().position(is_end).unwrap_or(rest.len());
    let after = rest.get(ascii..).unwrap_or_default();
    ascii + after.find(wanted).unwrap_or(after.len())
}

/// Returns true for characters that cannot be part of an atom.
pub(crate) fn ends_atom(character: char) -> bool {
    character.is_whitespace() || matches!(character, '(' | ')' | '\'' | '`' | ',' | '"' | ';')
}

fn string(rest: &str) -> (SyntaxKind, usize, bool) {
    let mut escaped = false;
    for (offset, character) in rest.char_indices().skip(1) {
        match character {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return (SyntaxKind::Text, offset + 1, false),
            _ => {}
        }
    }
    (SyntaxKind::Text, rest.len(), true)
}

fn block_comment(rest: &str) -> (SyntaxKind, usize, bool) {
    let mut depth = 0_usize;
    let mut previous = ' ';
    for (offset, character) in rest.char_indices() {
        match (previous, character) {
            ('#', '|') => {
                depth += 1;
                previous = ' ';
            }
            ('|', '#') => {
                depth = depth.saturating_sub(1);
                previous = ' ';
                if depth == 0 {
                    return (SyntaxKind::BlockComment, offset + 1, false);
                }
            }
            _ => previous = character,
        }
    }
    (SyntaxKind::BlockComment, rest.len(), true)
}

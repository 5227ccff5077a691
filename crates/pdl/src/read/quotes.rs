//! Finds forgotten quotation marks. Strings seldom extend over several lines, so a line with an odd number of marks contains the error,
//! and the text directly next to a mark shows which of two is missing.

use crate::syntax::{Position, Sink, SyntaxKind, parse_into};

/// A forgotten `"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Forgotten {
    /// Place of the missing mark, in bytes.
    pub(super) at: usize,
    /// True if the text as a whole is well formed with the added mark.
    pub(super) is_certain: bool,
}

/// Maximum number of closing parentheses at the end of a line that may have stood outside of the string.
const CLOSERS_MAX: usize = 12;

/// Returns the place of the forgotten mark; `None` if no line is suspect.
pub(super) fn forgotten(text: &str) -> Option<Forgotten> {
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        if let Some(places) = in_line(line) {
            let all = places.iter().map(|at| start + at);
            let mended = all.clone().find(|at| is_in_order(text, *at));
            let at = mended.or_else(|| all.clone().next())?;
            return Some(Forgotten { at, is_certain: mended.is_some() });
        }
        start += line.len();
    }
    None
}

/// Returns the places in a line with an odd number of marks where another one may belong, likelier ones first.
fn in_line(line: &str) -> Option<Vec<usize>> {
    let is_word = |letter: char| !letter.is_whitespace() && !matches!(letter, '(' | ')' | '"' | '\'' | ';');
    let mut opened: Option<usize> = None;
    let mut odd: Option<Vec<usize>> = None;
    let mut previous = ' ';
    let mut word = 0;
    for (at, letter) in line.char_indices() {
        match (letter, opened) {
            ('"', _) if previous == '\\' && opened.is_some() => {}
            ('"', None) => {
                if is_word(previous) && odd.is_none() {
                    odd = Some(vec![word]);
                }
                opened = Some(at);
            }
            ('"', Some(from)) => {
                let after = line.get(at + 1..).and_then(|rest| rest.chars().next()).unwrap_or(' ');
                if is_word(after) && odd.is_none() {
                    odd = Some(ends_of(line, from, at));
                }
                opened = None;
            }
            (';', None) => break,
            _ => {}
        }
        if is_word(letter) && !is_word(previous) {
            word = at;
        }
        previous = letter;
    }
    // Marks next to words are suspect only in lines with an odd number of marks.
    opened.map(|from| odd.unwrap_or_else(|| ends_of(line, from, line.len())))
}

/// Returns the places at which a string that begins at `from` may end before `to`: without the blanks, then without parentheses.
fn ends_of(line: &str, from: usize, to: usize) -> Vec<usize> {
    let mut inside = line.get(from..to).unwrap_or_default().trim_end();
    let mut places = vec![from + inside.len()];
    while let Some(shorter) = inside.strip_suffix(')').filter(|_| places.len() <= CLOSERS_MAX) {
        inside = shorter.trim_end();
        places.push(from + inside.len());
    }
    places
}

/// Returns true if the text has no flaw with a mark at this place.
fn is_in_order(text: &str, at: usize) -> bool {
    let (Some(before), Some(after)) = (text.get(..at), text.get(at..)) else { return false };
    let mended = format!("{before}\"{after}");
    parse_into(&mended, || Nothing).1.is_empty()
}

/// A sink that ignores the structure of a text.
struct Nothing;

impl<'t> Sink<'t> for Nothing {
    fn open(&mut self, _: SyntaxKind, _: Position) {}
    fn token(&mut self, _: SyntaxKind, _: &'t str, _: Position) {}
    fn close(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mended(text: &str) -> String {
        let found = forgotten(text).unwrap();
        assert!(found.is_certain, "{text}");
        let (before, after) = text.split_at(found.at);
        format!("{before}\"{after}")
    }

    #[test]
    fn either_mark_of_a_string_is_found() {
        assert_eq!(mended("(a \"b)\n(c \"d\")\n"), "(a \"b\")\n(c \"d\")\n");
        assert_eq!(mended("(a b\")\n(c \"d\")\n"), "(a \"b\")\n(c \"d\")\n");
        assert_eq!(mended("(a \"b \"c\" \"d\")\n"), "(a \"b\" \"c\" \"d\")\n");
        assert_eq!(mended("(a \"b\" c\" \"d\")\n"), "(a \"b\" \"c\" \"d\")\n");
        assert_eq!(mended("(a \"b c d\n  :e \"f\")\n"), "(a \"b c d\"\n  :e \"f\")\n");
    }
}

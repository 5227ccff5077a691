//! Repair of unbalanced parentheses: finds the missing or superfluous `)` by the indentation and the known shapes of forms.
//!
//! Each form that begins in the first column is repaired separately. Every place at which one parenthesis could be added or removed is
//! tried, and the least implausible result is chosen.

use super::SyntaxKind;
use super::lexer::tokens;
use super::shape::{Piece, PieceKind, clause_meant, cost, is_form};

/// A change of one parenthesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Repair {
    /// `)` is missing at this offset, and closes the list that begins at the other.
    Close { at: usize, opened: usize },
    /// The `)` at this offset is superfluous.
    Remove { at: usize },
    /// `(` is missing at this offset.
    Open { at: usize },
}

/// A repaired form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Repaired {
    /// Byte range of the form, up to the next one.
    pub(crate) start: usize,
    pub(crate) end: usize,
    pub(crate) repair: Repair,
    /// True if the repaired form has no implausible part.
    pub(crate) is_certain: bool,
}

/// Greatest product of a form's tokens and tried places in one text; above it no repair is proposed.
const WORK_MAX: usize = 20_000_000;

/// Returns the repairs of all forms that lack one parenthesis or have one too many.
pub(crate) fn repairs(text: &str) -> Vec<Repaired> {
    let pieces = pieces(text);
    let begins =
        |piece: &Piece<'_>| piece.first_column == Some(1) && (piece.kind == PieceKind::Open || is_form(piece.text));
    let mut starts: Vec<usize> =
        pieces.iter().enumerate().filter(|(_, piece)| begins(piece)).map(|(at, _)| at).collect();
    starts.push(pieces.len());
    let mut work = WORK_MAX;
    let mut repaired = Vec::new();
    for pair in starts.windows(2) {
        let (Some(from), Some(to)) = (pair.first(), pair.last()) else { continue };
        let Some(form) = pieces.get(*from..*to) else { continue };
        let lacking = balance(form);
        if lacking == Balance::Even {
            continue;
        }
        let Some(left) = work.checked_sub(form.len().saturating_mul(form.len()).saturating_mul(2)) else { break };
        work = left;
        let start = form.first().map_or(0, |piece| piece.start);
        let end = pieces.get(*to).map_or(text.len(), |next| next.start);
        if let Some((repair, is_certain)) = best(form, lacking) {
            repaired.push(Repaired { start, end, repair, is_certain });
        }
    }
    repaired
}

fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let (mut offset, mut line, mut column, mut first) = (0, 1, 1, true);
    for token in tokens(text) {
        let kind = match token.kind {
            SyntaxKind::Open => Some(PieceKind::Open),
            SyntaxKind::Close => Some(PieceKind::Close),
            SyntaxKind::Text | SyntaxKind::Atom => Some(PieceKind::Other),
            _ => None,
        };
        if let Some(kind) = kind {
            let first_column = first.then_some(column);
            let length = token.text.len();
            pieces.push(Piece { kind, text: token.text, start: offset, length, first_column, column, line });
        }
        first &= token.kind == SyntaxKind::WhiteSpace;
        offset += token.text.len();
        match token.text.rsplit_once('\n') {
            Some((before, last)) => {
                line += 1 + before.matches('\n').count();
                column = 1 + last.chars().count();
                first = token.kind == SyntaxKind::WhiteSpace;
            }
            None if token.text == "\u{feff}" => {}
            None => column += token.text.chars().count(),
        }
    }
    pieces
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Balance {
    Even,
    LacksClose,
    LacksOpen,
    /// No single parenthesis repairs the form.
    Hopeless,
}

fn balance(form: &[Piece<'_>]) -> Balance {
    let mut open = 0_usize;
    let mut unmatched = 0_usize;
    for piece in form {
        match piece.kind {
            PieceKind::Open => open += 1,
            PieceKind::Close if open == 0 => unmatched += 1,
            PieceKind::Close => open -= 1,
            PieceKind::Other => {}
        }
    }
    match (open, unmatched) {
        (0, 0) => Balance::Even,
        (1, 0) => Balance::LacksClose,
        (0, 1) => Balance::LacksOpen,
        // Among others `(1, 1)`: a list is closed too early and opened again, so that two parentheses are wrong.
        _ => Balance::Hopeless,
    }
}

/// Returns the change with the least implausible result, and true if nothing implausible remains. If misspelt clauses make every change
/// implausible, the form is evaluated as if they were spelt correctly.
fn best(form: &[Piece<'_>], lacking: Balance) -> Option<(Repair, bool)> {
    let as_written = least_doubtful(form, lacking);
    if as_written.is_some_and(|(_, is_certain)| is_certain) {
        return as_written;
    }
    let as_meant = spelt_right(form).and_then(|form| least_doubtful(&form, lacking));
    // Offsets refer to the written text, because words were replaced and not moved.
    as_meant.filter(|(_, is_certain)| *is_certain).or(as_written)
}

/// Returns the form with its misspelt clauses corrected; `None` if there are none.
fn spelt_right<'t>(form: &[Piece<'t>]) -> Option<Vec<Piece<'t>>> {
    let mut meant = form.to_vec();
    let mut exchanged = false;
    for (number, piece) in form.iter().enumerate().skip(1) {
        let heads_list = form.get(number - 1).is_some_and(|before| before.kind == PieceKind::Open);
        if piece.kind == PieceKind::Other
            && heads_list
            && let Some(word) = clause_meant(piece.text)
            && let Some(place) = meant.get_mut(number)
        {
            place.text = word;
            exchanged = true;
        }
    }
    exchanged.then_some(meant)
}

fn least_doubtful(form: &[Piece<'_>], lacking: Balance) -> Option<(Repair, bool)> {
    let mut found: Option<(usize, bool, BracketCandidate)> = None;
    let candidates: Vec<BracketCandidate> = match lacking {
        Balance::LacksClose => (0..form.len()).map(BracketCandidate::CloseAfter).collect(),
        Balance::LacksOpen => {
            let removed = (0..form.len()).filter(|at| is_last_of_run(form, *at)).map(BracketCandidate::Remove);
            let opened = (0..form.len()).filter(|at| form.get(*at).is_some_and(|piece| piece.kind == PieceKind::Other));
            opened.map(BracketCandidate::OpenBefore).chain(removed).collect()
        }
        Balance::Even | Balance::Hopeless => return None,
    };
    for candidate in candidates {
        let this = cost(candidate.applied(form));
        let (least, tied) = found.map_or((usize::MAX, false), |(least, tied, _)| (least, tied));
        if this <= least {
            let elsewhere = found.is_some_and(|(_, _, other)| other.line(form) != candidate.line(form));
            found = Some((this, this == least && (tied || elsewhere), candidate));
        }
    }
    let (least, tied, candidate) = found.filter(|(least, ..)| *least < 1000)?;
    let repair = candidate.repair(form)?;
    Some((repair, least == 0 && !tied))
}

/// Returns true for the last `)` of several in a row: removing any of them has the same effect.
fn is_last_of_run(form: &[Piece<'_>], at: usize) -> bool {
    let is_close = |at: usize| form.get(at).is_some_and(|piece| piece.kind == PieceKind::Close);
    is_close(at) && !is_close(at + 1)
}

#[derive(Clone, Copy)]
enum BracketCandidate {
    CloseAfter(usize),
    Remove(usize),
    OpenBefore(usize),
}

impl BracketCandidate {
    fn at(self) -> usize {
        match self {
            BracketCandidate::CloseAfter(at) | BracketCandidate::Remove(at) | BracketCandidate::OpenBefore(at) => at,
        }
    }

    fn line(self, form: &[Piece<'_>]) -> usize {
        form.get(self.at()).map_or(0, |piece| piece.line)
    }

    /// Returns the pieces of the form with this change.
    fn applied<'f, 't>(self, form: &'f [Piece<'t>]) -> impl Iterator<Item = Piece<'t>> + 'f {
        form.iter().enumerate().flat_map(move |(number, piece)| {
            let close = Piece { kind: PieceKind::Close, text: ")", first_column: None, ..*piece };
            let open = Piece { kind: PieceKind::Open, text: "(", ..*piece };
            let inside = Piece { first_column: None, ..*piece };
            let (one, two) = match self {
                _ if self.at() != number => (Some(*piece), None),
                BracketCandidate::CloseAfter(_) => (Some(*piece), Some(close)),
                BracketCandidate::Remove(_) => (None, None),
                BracketCandidate::OpenBefore(_) => (Some(open), Some(inside)),
            };
            one.into_iter().chain(two)
        })
    }

    fn repair(self, form: &[Piece<'_>]) -> Option<Repair> {
        let piece = form.get(self.at())?;
        Some(match self {
            BracketCandidate::Remove(_) => Repair::Remove { at: piece.start },
            BracketCandidate::OpenBefore(_) => Repair::Open { at: piece.start },
            BracketCandidate::CloseAfter(at) => {
                Repair::Close { at: piece.start + piece.length, opened: innermost(form.get(..=at)?)? }
            }
        })
    }
}

/// Returns the beginning of the innermost list that is open after these pieces.
fn innermost(pieces: &[Piece<'_>]) -> Option<usize> {
    let mut open: Vec<usize> = Vec::new();
    for piece in pieces {
        match piece.kind {
            PieceKind::Open => open.push(piece.start),
            PieceKind::Close => {
                open.pop();
            }
            PieceKind::Other => {}
        }
    }
    open.pop()
}

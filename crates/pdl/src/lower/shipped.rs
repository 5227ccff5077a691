//! Goals that a shipped library serves, although the program does not require this library.

use crate::fix::Fix;
use crate::read::{Datum, DatumKind, read_file};
use crate::words::{LIBRARIES, written};

/// An index of a shipped library.
struct ShippedIndex {
    /// The name that `require-apex-library` takes.
    library: &'static str,
    index: Datum,
    text: String,
}

/// The indexes of all shipped libraries, read when the first goal asks for them.
#[derive(Default)]
pub(super) struct Shipped {
    indexes: Option<Vec<ShippedIndex>>,
}

/// Relation of a shipped library to a goal that no method of the program serves.
pub(super) enum Offer {
    /// The library serves the goal.
    Serves { library: &'static str, index: String },
    /// The library serves goals that begin with the same word and have another shape.
    OtherShape { library: &'static str, index: String },
}

impl Shipped {
    /// Returns the library that serves the goal, or one that serves a goal with the same first word.
    pub(super) fn offer(&mut self, goal: &Datum) -> Option<Offer> {
        let head = goal.head()?.clone();
        let parts = goal.as_list()?;
        let parts = parts.split(|item| item.is("=>")).next().unwrap_or(parts);
        let indexes = self.indexes.get_or_insert_with(read_all);
        let of_head = || indexes.iter().filter(|each| each.index.head() == Some(&head));
        if let Some(served) = of_head().find(|each| each.index.as_list().is_some_and(|index| serves(index, parts))) {
            return Some(Offer::Serves { library: served.library, index: served.text.clone() });
        }
        // The library's goal with the most words in common and the most similar length is probably meant.
        let likeness = |each: &&ShippedIndex| {
            let index = each.index.as_list().unwrap_or_default();
            let words = index.iter().filter_map(Datum::as_symbol);
            let common = words.filter(|word| parts.iter().any(|part| part.as_symbol() == Some(*word))).count();
            (common, std::cmp::Reverse(index.len().abs_diff(parts.len())))
        };
        let nearest = of_head().rev().max_by_key(likeness)?;
        Some(Offer::OtherShape { library: nearest.library, index: nearest.text.clone() })
    }
}

impl Offer {
    /// Returns the fix that requires the library, at the beginning of the file of the goal.
    pub(super) fn fix(&self, goal: &Datum) -> Fix {
        let (Offer::Serves { library, .. } | Offer::OtherShape { library, .. }) = self;
        let form = format!("(require-apex-library \"{library}\")");
        let span = crate::diagnostic::Span { start: 0, end: 0, ..goal.span };
        Fix::look(format!("require the library that serves it: `{form}`")).insert_before(span, format!("{form}\n"))
    }
}

fn read_all() -> Vec<ShippedIndex> {
    let mut found = Vec::new();
    for (path, text) in LIBRARIES {
        let library = path.trim_start_matches("library/").trim_end_matches(".pdl");
        for form in read_file(0, text).data {
            if !matches!(form.head_name(), "procedure" | "primitive" | "solver") {
                continue;
            }
            let clause = form.tail().iter().find(|clause| clause.head_name() == "index");
            if let Some(index) = clause.and_then(|clause| clause.tail().first()) {
                found.push(ShippedIndex { library, index: index.clone(), text: written(text, index) });
            }
        }
    }
    found
}

/// Returns true if the index may match the goal: as many parts, equal words, anything for a variable.
fn serves(index: &[Datum], goal: &[Datum]) -> bool {
    index.len() == goal.len()
        && index.iter().zip(goal).all(|(wanted, part)| match (&wanted.kind, &part.kind) {
            (DatumKind::Symbol(word), DatumKind::Symbol(other)) => word == other,
            (DatumKind::Symbol(_), DatumKind::Variable(_) | DatumKind::Bound(_) | DatumKind::Anonymous) => true,
            (DatumKind::Symbol(_), _) => false,
            _ => true,
        })
}

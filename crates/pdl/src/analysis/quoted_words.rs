//! Words in quotes that are written once and resemble another one that is written several times: `'(noth south)` next to `'north`. Such
//! words are data, which nothing declares.

use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::locate::each;
use crate::read::{Datum, DatumKind, read_file};
use crate::suggest::{meant, renames};
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of suspects in one program.
const SUSPECTS_MAX: usize = 500;

/// The places of a word.
#[derive(Default)]
struct Word {
    count: usize,
    quoted: Option<Span>,
}

/// Returns the findings in the texts of `library` except for the files `foreign`. What `known` reports is not reported again.
pub(super) fn findings(library: &Library, foreign: &BTreeSet<u32>, known: &[Diagnostic]) -> Vec<Diagnostic> {
    let mut words: BTreeMap<Symbol, Word> = BTreeMap::new();
    let own = |file: &u32| !foreign.contains(file);
    let files = || (0..).zip(&library.sources);
    for (file, source) in files().filter(|(file, _)| own(file)) {
        read_file(file, &source.text).data.iter().for_each(|datum| collect(datum, &mut words));
    }
    let quoted = || words.iter().filter(|(_, word)| word.quoted.is_some());
    let common: Vec<&str> = quoted().filter(|(_, word)| word.count > 1).map(|(name, _)| name.printed()).collect();
    let suspects = quoted().filter(|(_, word)| word.count == 1).take(SUSPECTS_MAX);
    let mut found: Vec<(&Symbol, Span, &str)> = suspects
        .filter_map(|(name, word)| Some((name, word.quoted?, meant(name, common.iter().copied())?)))
        .filter(|(_, span, _)| !known.iter().any(|other| other.span == *span))
        .collect();
    // A library may use the word.
    for (file, source) in files().filter(|(file, _)| !own(file)) {
        if found.is_empty() {
            break;
        }
        let mut others: BTreeMap<Symbol, Word> = BTreeMap::new();
        read_file(file, &source.text).data.iter().for_each(|datum| collect(datum, &mut others));
        found.retain(|(name, ..)| !others.contains_key(name));
    }
    let diagnostic = |(name, span, meant): (&Symbol, Span, &str)| {
        let message = format!("the word `{name}` is written once, and `{meant}` several times");
        Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
            .reason("a word in quotes is data: nothing declares it, and a misspelt one equals no other")
            .fixes(renames(span, name.printed(), [meant]))
    };
    found.into_iter().map(diagnostic).collect()
}

/// Adds the words of a datum.
fn collect(datum: &Datum, words: &mut BTreeMap<Symbol, Word>) {
    each(datum, &mut |part| match &part.kind {
        DatumKind::Symbol(name) => words.entry(name.clone()).or_default().count += 1,
        DatumKind::Quote(inner) => each(inner, &mut |quoted| {
            if let DatumKind::Symbol(name) = &quoted.kind
                && !name.folded().starts_with(':')
            {
                words.entry(name.clone()).or_default().quoted.get_or_insert(quoted.span);
            }
        }),
        _ => {}
    });
}

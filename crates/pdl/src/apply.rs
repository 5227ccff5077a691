//! Applies fixes to texts: each fix completely or not at all, and never two at one place.

use crate::fix::{Fix, TextEdit};
use apex_model::source::SourceFile;
use std::collections::BTreeMap;

/// Result of applying fixes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Applied {
    /// The new texts by index into the sources; texts that no fix changes are not listed.
    pub texts: BTreeMap<u32, String>,
    /// Applied fixes, by their index. A fix that overlaps an earlier one is left for the next pass.
    pub made: Vec<usize>,
}

/// Applies those of `fixes` that do not overlap, the earlier ones first. A fix with an edit outside of a text or inside a character is
/// rejected.
pub fn apply<'f>(sources: &[SourceFile], fixes: impl IntoIterator<Item = &'f Fix>) -> Applied {
    let mut accepted: BTreeMap<u32, Vec<TextEdit>> = BTreeMap::new();
    let mut made = Vec::new();
    for (number, fix) in fixes.into_iter().enumerate() {
        let known = |edit: &TextEdit| accepted.get(&edit.file).is_some_and(|edits| edits.contains(edit));
        let free = |edit: &TextEdit| {
            let others = accepted.get(&edit.file).into_iter().flatten();
            others
                .chain(&fix.edits)
                .filter(|other| *other != edit && other.file == edit.file)
                .all(|other| apart(edit, other))
        };
        let possible = fix.edits.iter().all(|edit| is_inside(sources, edit) && (known(edit) || free(edit)));
        if !possible || fix.edits.is_empty() {
            continue;
        }
        made.push(number);
        for edit in &fix.edits {
            let edits = accepted.entry(edit.file).or_default();
            if !edits.contains(edit) {
                edits.push(edit.clone());
            }
        }
    }
    let texts =
        accepted.into_iter().filter_map(|(file, edits)| Some((file, edited(source(sources, file)?, edits)))).collect();
    Applied { texts, made }
}

fn source(sources: &[SourceFile], file: u32) -> Option<&str> {
    sources.get(usize::try_from(file).ok()?).map(|source| &*source.text)
}

fn is_inside(sources: &[SourceFile], edit: &TextEdit) -> bool {
    let range = source(sources, edit.file).and_then(|text| text.get(bounds(edit)));
    range.is_some()
}

fn bounds(edit: &TextEdit) -> std::ops::Range<usize> {
    let bound = |offset: u32| usize::try_from(offset).unwrap_or(usize::MAX);
    bound(edit.start)..bound(edit.end)
}

/// Returns true if one edit ends at or before the beginning of the other. Two edits with the same beginning count as overlapping, because
/// the order of their insertions would be a guess.
fn apart(one: &TextEdit, other: &TextEdit) -> bool {
    one.start != other.start && (one.end <= other.start || other.end <= one.start)
}

/// Returns `text` after the edits, which do not overlap.
fn edited(text: &str, mut edits: Vec<TextEdit>) -> String {
    edits.sort();
    let mut result = String::with_capacity(text.len());
    let mut from = 0;
    for edit in &edits {
        let range = bounds(edit);
        result.push_str(text.get(from..range.start).unwrap_or_default());
        result.push_str(&edit.replacement);
        from = range.end;
    }
    result.push_str(text.get(from..).unwrap_or_default());
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::Span;

    fn at(start: u32, end: u32) -> Span {
        Span { start, end, ..Span::default() }
    }

    fn sources(text: &str) -> Vec<SourceFile> {
        vec![SourceFile { name: "a.pdl".into(), text: text.into() }]
    }

    fn applied(text: &str, fixes: &[Fix]) -> (String, Vec<usize>) {
        let mut applied = apply(&sources(text), fixes);
        (applied.texts.remove(&0).unwrap_or_else(|| text.to_string()), applied.made)
    }

    #[test]
    fn edits_of_one_fix_are_made_together() {
        let fix = Fix::safe("").insert_before(at(2, 5), "(").insert_after(at(2, 5), ")");
        assert_eq!(applied("a stop b", &[fix]), ("a (sto)p b".to_string(), vec![0]));
    }

    #[test]
    fn of_fixes_in_one_place_the_first_is_made() {
        let first = Fix::safe("").replace(at(0, 3), "x");
        let overlapping = Fix::safe("").replace(at(2, 4), "y").replace(at(6, 7), "z");
        let same = first.clone();
        assert_eq!(applied("abcdefgh", &[first.clone(), overlapping, same]), ("xdefgh".to_string(), vec![0, 2]));
        let beside = Fix::safe("").replace(at(3, 4), "y");
        assert_eq!(applied("abcdefgh", &[first, beside]), ("xyefgh".to_string(), vec![0, 1]));
        let twice = [Fix::safe("").insert_before(at(1, 1), "x"), Fix::safe("").insert_before(at(1, 1), "y")];
        assert_eq!(applied("ab", &twice), ("axb".to_string(), vec![0]));
    }

    #[test]
    fn edits_outside_of_the_text_or_inside_of_a_character_are_refused() {
        for span in [at(3, 9), at(2, 3), at(1, 2), at(4, 3)] {
            assert_eq!(applied("aöb", &[Fix::safe("").replace(span, "x")]), ("aöb".to_string(), vec![]));
        }
        let other_file = Fix::safe("").replace(Span { file: 1, ..at(0, 1) }, "x");
        assert_eq!(applied("a", &[other_file]).1, Vec::<usize>::new());
    }
}

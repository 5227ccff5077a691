//! "Did you mean": known names similar to a misspelt one, and the fixes that insert them.
//!
//! The distance weighs errors by how often they occur: two swapped letters, a doubled letter, a neighbouring key, a hyphen for an
//! underscore cost less than any other letter.

use crate::diagnostic::Span;
use crate::fix::Fix;
use apex_model::quantity::{UNITS, Unit};
use apex_model::symbol::Symbol;
use std::sync::LazyLock;

/// Length in characters above which names are not compared: this bounds the cost of a message.
const NAME_CHARACTERS_MAX: usize = 64;
/// Maximum number of known names that are compared with one misspelt name.
const NAMES_MAX: usize = 5_000;
/// Maximum number of suggestions for one misspelt name.
const SUGGESTIONS_MAX: usize = 3;
/// Cost of one ordinary edit.
const EDIT: u32 = 10;
/// Least cost of an edit that adds, drops or replaces a letter.
const LETTER_EDIT_MIN: u32 = EDIT - 3;
/// A suggestion is certain only if the distance of the next one is greater by more than this.
const MARGIN: u32 = 4;

/// A known name with its distance, in tenths of an ordinary edit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Near<'a> {
    pub(crate) name: &'a str,
    pub(crate) cost: u32,
}

/// Returns known names similar enough to be meant by `name`, nearest first; equally near ones in the given order.
pub(crate) fn near<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<Near<'a>> {
    let wanted: Vec<char> = name.to_lowercase().chars().take(NAME_CHARACTERS_MAX + 1).collect();
    if wanted.is_empty() || wanted.len() > NAME_CHARACTERS_MAX {
        return Vec::new();
    }
    let allowed = (wanted.len() / 3).clamp(1, 4);
    let mut found: Vec<Near<'a>> = Vec::new();
    for candidate in known.into_iter().take(NAMES_MAX) {
        let letters: Vec<char> = candidate.to_lowercase().chars().take(NAME_CHARACTERS_MAX + 1).collect();
        if letters == wanted || found.iter().any(|near| near.name == candidate) {
            continue;
        }
        let limit = u32::try_from(allowed).unwrap_or(1) * EDIT;
        // Most names have too few letters in common.
        let apart = letters_apart(&wanted, &letters);
        let is_close =
            letters.len().abs_diff(wanted.len()) <= allowed && apart.saturating_mul(LETTER_EDIT_MIN) <= limit;
        let plain = is_close.then(|| distance(&wanted, &letters));
        let by_words = if apart == 0 { distance_by_words(&wanted, &letters) } else { None };
        let cost = plain.unwrap_or(u32::MAX).min(by_words.unwrap_or(u32::MAX));
        if cost <= limit {
            found.push(Near { name: candidate, cost });
        }
    }
    found.sort_by_key(|near| near.cost);
    found
}

/// Returns true if the first of these names is certainly meant: the others are clearly farther, and the name is long enough (a short name
/// has many neighbours).
pub(crate) fn is_certain(name: &str, found: &[Near<'_>]) -> bool {
    let Some(first) = found.first() else { return false };
    let alone = found.get(1).is_none_or(|second| second.cost > first.cost + MARGIN);
    let letters = name.chars().count().max(first.name.chars().count());
    alone && letters >= 3 && !are_distinct(name, first.name) && first.cost <= if letters >= 6 { 2 * EDIT } else { EDIT }
}

/// Returns true if two names are probably those of different things, although they are alike: they differ in digits (`bridge-1`,
/// `bridge-2`), or in a part of one or two letters whose letters the other does not have in another order (`line-a`, `line-b`; `gate-n`,
/// `gate-s`).
pub(crate) fn are_distinct(name: &str, other: &str) -> bool {
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    if digits(name) != digits(other) {
        return true;
    }
    let parts = |text: &str| text.to_lowercase().split(['-', '_']).map(str::to_string).collect::<Vec<_>>();
    let (one, two) = (parts(name), parts(other));
    if one.len() < 2 || one.len() != two.len() {
        return false;
    }
    let mut different = one.iter().zip(&two).filter(|(part, same)| part != same);
    let (Some((part, same)), None) = (different.next(), different.next()) else { return false };
    let sorted = |text: &str| {
        let mut letters: Vec<char> = text.chars().collect();
        letters.sort_unstable();
        letters
    };
    let (letters, others) = (sorted(part), sorted(same));
    letters.len() == others.len() && letters.len() <= 2 && letters != others
}

/// Returns the known name nearest to `name`, if it is near enough to be meant; of equally near ones the first.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    near(name, known).first().map(|near| near.name)
}

/// Returns fixes that replace `name`, at `span`, by the nearest known names. The first fix is safe if it is certain.
pub(crate) fn renames<'a>(span: Span, name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<Fix> {
    renames_marked(span, name, known, str::to_string)
}

/// Like [`renames`], for names written with marks: `mark` makes `?x`, `+x+` or `:x` of `x`.
pub(crate) fn renames_marked<'a>(
    span: Span,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    mark: impl Fn(&str) -> String,
) -> Vec<Fix> {
    let found = near(name, known);
    let certain = is_certain(name, &found);
    let least = found.first().map_or(0, |near| near.cost);
    let likely = found.iter().take_while(|near| if certain { near.cost == least } else { near.cost <= least + EDIT });
    let fix = |near: &Near<'_>| {
        let title = format!("replace `{}` by `{}`", mark(name), mark(near.name));
        let fix = if certain { Fix::safe(title) } else { Fix::look(title) };
        fix.replace(span, mark(near.name))
    };
    likely.take(SUGGESTIONS_MAX).map(fix).collect()
}

/// Returns fixes for a misspelt unit. Different spellings of one unit count as one suggestion.
pub(crate) fn unit_renames(span: Span, name: &str, mark: impl Fn(&str) -> String) -> Vec<Fix> {
    renames_marked(span, name, near_units(name), mark)
}

/// Returns the best spelling of each unit that is near, nearest first.
pub(crate) fn near_units(name: &str) -> Vec<&'static str> {
    let spelling = |unit: &'static Unit| {
        let spellings = std::iter::once(unit.name).chain(unit.aliases.iter().copied());
        near(name, spellings).first().copied()
    };
    let mut best: Vec<Near<'_>> = UNITS.iter().filter_map(spelling).collect();
    best.sort_by_key(|near| near.cost);
    // A single letter is near every other one: only a neighbouring key counts.
    let alone = name.chars().count() == 1;
    let likely =
        best.iter().filter(|near| if alone { near.cost < EDIT } else { near.name.len() >= 2 || near.cost < EDIT });
    likely.map(|near| near.name).collect()
}

/// Returns a lower bound of the number of letters that must be added, dropped or replaced to make `b` of `a`, whatever their order; marks
/// between words do not count. 0 if a name has other than ASCII letters.
fn letters_apart(a: &[char], b: &[char]) -> u32 {
    let mut surplus = [0_i32; 128];
    for (name, one) in [(a, 1), (b, -1)] {
        for letter in name.iter().filter(|letter| !is_mark(**letter)) {
            let Some(count) = surplus.get_mut(*letter as usize) else { return 0 };
            *count += one;
        }
    }
    let total = |of: fn(i32) -> i32| surplus.iter().map(|count| of(*count).max(0)).sum::<i32>();
    total(|count| count).max(total(|count| -count)).unsigned_abs()
}

/// Returns true for a mark between words.
fn is_mark(letter: char) -> bool {
    matches!(letter, '-' | '_' | '/' | ' ')
}

/// Returns the distance of names of several words that differ in the order of the words, in the marks between them, or in both.
fn distance_by_words(a: &[char], b: &[char]) -> Option<u32> {
    let words = |name: &[char]| -> Vec<String> {
        let mut words: Vec<String> = name.split(|letter| is_mark(*letter)).map(|word| word.iter().collect()).collect();
        words.sort();
        words
    };
    let bare = |name: &[char]| -> String { name.iter().filter(|c| !matches!(c, '-' | '_' | ' ')).collect() };
    if bare(a) == bare(b) {
        return Some(EDIT / 2);
    }
    let (words_a, words_b) = (words(a), words(b));
    (words_a.len() > 1 && words_a == words_b).then_some(EDIT)
}

/// Returns the cost of turning `a` into `b` by inserting, deleting and replacing letters and swapping neighbours.
fn distance(a: &[char], b: &[char]) -> u32 {
    let mut before: Vec<u32> = Vec::new();
    let mut above: Vec<u32> = vec![0];
    for (j, y) in b.iter().enumerate() {
        let left = above.last().copied().unwrap_or(0);
        above.push(left + lone(*y, j.checked_sub(1).and_then(|j| b.get(j))));
    }
    for (i, x) in a.iter().enumerate() {
        let previous = i.checked_sub(1).and_then(|i| a.get(i));
        let dropped = lone(*x, previous);
        let mut row = vec![above.first().copied().unwrap_or(0) + dropped];
        for (j, y) in b.iter().enumerate() {
            let other = j.checked_sub(1).and_then(|j| b.get(j));
            let up = above.get(j + 1).copied().unwrap_or(0);
            let diagonal = above.get(j).copied().unwrap_or(0);
            let left = row.last().copied().unwrap_or(0);
            let mut cost = (up + dropped).min(left + lone(*y, other)).min(diagonal + replaced(*x, *y));
            if x != y && previous == Some(y) && other == Some(x) {
                cost = cost.min(before.get(j.saturating_sub(1)).copied().unwrap_or(0) + EDIT - 3);
            }
            row.push(cost);
        }
        before = std::mem::replace(&mut above, row);
    }
    above.last().copied().unwrap_or(0)
}

/// Returns the cost of an additional or missing letter; `previous` is the letter before it in the name that contains it.
fn lone(letter: char, previous: Option<&char>) -> u32 {
    if previous == Some(&letter) || matches!(letter, '-' | '_') { EDIT - 3 } else { EDIT }
}

fn replaced(x: char, y: char) -> u32 {
    match (x, y) {
        _ if x == y => 0,
        ('-', '_') | ('_', '-') => EDIT / 2,
        _ if are_neighbours(x, y) => EDIT - 2,
        _ => EDIT,
    }
}

/// Rows of a keyboard.
const ROWS: [&str; 4] = ["1234567890-", "qwertyuiop", "asdfghjkl", "zxcvbnm"];

/// Row and place of each ASCII key of [`ROWS`].
static PLACES: LazyLock<[Option<(usize, usize)>; 128]> = LazyLock::new(|| {
    let mut places = [None; 128];
    for (row, keys) in ROWS.iter().enumerate() {
        for (at, key) in keys.bytes().enumerate() {
            if let Some(place) = places.get_mut(usize::from(key)) {
                *place = Some((row, at));
            }
        }
    }
    places
});

/// Returns true if the keys are neighbours on a keyboard.
fn are_neighbours(x: char, y: char) -> bool {
    let place = |key: char| PLACES.get(key as usize).copied().flatten();
    match (place(x), place(y)) {
        (Some((row_x, at_x)), Some((row_y, at_y))) if row_x == row_y => at_x.abs_diff(at_y) == 1,
        (Some((row_x, at_x)), Some((row_y, at_y))) if row_x.abs_diff(row_y) == 1 => {
            // Lower rows are shifted to the right by half a key.
            let (upper, lower) = if row_x < row_y { (at_x, at_y) } else { (at_y, at_x) };
            upper == lower || upper == lower + 1
        }
        _ => false,
    }
}

/// Returns the known name that `name` is certainly meant to be.
pub(crate) fn meant<'n>(name: &Symbol, known: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let found = near(name.printed(), known);
    // Names that differ only in digits name different things.
    let letters = |text: &str| text.chars().filter(|letter| !letter.is_ascii_digit()).collect::<String>();
    let first = found.first().filter(|_| is_certain(name.printed(), &found))?.name;
    (letters(first).to_lowercase() != letters(name.folded()).to_lowercase()).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fix::Applicability;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        assert_eq!(nearest("witfor", ["waitfor", "select"]), Some("waitfor"));
        assert_eq!(nearest("wiatfor", ["select", "waitfor"]), Some("waitfor"));
        assert_eq!(nearest("camera", ["waitfor", "select"]), None);
        assert_eq!(nearest("", ["a"]), None);
    }

    #[test]
    fn marks_between_words_and_their_order_matter_little() {
        assert_eq!(nearest("ground_speed", ["ground-speed", "wind-speed"]), Some("ground-speed"));
        assert_eq!(nearest("groundspeed", ["ground-speed", "wind-speed"]), Some("ground-speed"));
        assert_eq!(nearest("speed-ground", ["ground-speed", "wind-speed"]), Some("ground-speed"));
        assert_eq!(nearest("targets", ["target"]), Some("target"));
    }

    /// Names of a few letters and marks: each pair is compared with the distance and the order of words, without the bound on letters.
    #[test]
    fn names_with_other_letters_are_left_out_only_if_they_are_far() {
        let mut state = 1_u64;
        let mut draw = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        let letters: Vec<char> = "abcgh-_/ eé".chars().collect();
        let mut name = |length: u64| -> String {
            (0..1 + draw(length)).map(|_| letters[draw(letters.len() as u64) as usize]).collect()
        };
        let mut found = 0;
        for round in 0..20_000 {
            let (wanted, other) = (name(3 + round % 12), name(3 + round % 12));
            let (a, b): (Vec<char>, Vec<char>) = (wanted.chars().collect(), other.chars().collect());
            let allowed = (a.len() / 3).clamp(1, 4);
            let plain = if a.len().abs_diff(b.len()) <= allowed { distance(&a, &b) } else { u32::MAX };
            let cost = plain.min(distance_by_words(&a, &b).unwrap_or(u32::MAX));
            let is_near = a != b && cost <= allowed as u32 * EDIT;
            let expected: Vec<Near<'_>> = is_near.then_some(Near { name: &other, cost }).into_iter().collect();
            assert_eq!(near(&wanted, [other.as_str()]), expected, "`{wanted}` and `{other}`");
            found += usize::from(is_near);
        }
        assert!(found > 500, "{found} near names, expected more than 500");
    }

    #[test]
    fn ties_and_short_names_are_not_certain() {
        let first = |name: &str, known: &[&str]| {
            renames(Span::default(), name, known.iter().copied()).first().map(|fix| fix.applicability)
        };
        assert_eq!(first("roll-anle", &["roll-angle", "pitch-angle"]), Some(Applicability::Safe));
        assert_eq!(first("s5", &["s1", "s2"]), Some(Applicability::NeedsLook));
        assert_eq!(first("fly-t", &["fly-to", "fly-at"]), Some(Applicability::NeedsLook));
        assert_eq!(first("camera-3", &["camera-1"]), Some(Applicability::NeedsLook));
        assert_eq!(first("bridge-b", &["bridge-a"]), Some(Applicability::NeedsLook));
        assert_eq!(first("runway-ne", &["runway-nw"]), Some(Applicability::NeedsLook));
        assert_eq!(first("take-fo", &["take-of"]), Some(Applicability::Safe));
    }

    #[test]
    fn the_neighbouring_key_is_nearer_than_any_other() {
        assert!(are_neighbours('g', 'h') && are_neighbours('g', 't') && !are_neighbours('a', 'l'));
        assert_eq!(nearest("gly", ["sly", "fly"]), Some("fly"));
    }
}

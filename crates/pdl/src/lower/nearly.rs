//! Differences between a goal that no method serves and an index that nearly serves it: one word, two words in the wrong order,
//! one part too few or too many.

use crate::read::{Datum, DatumKind};
use crate::suggest::near;
use apex_model::symbol::Symbol;

/// The difference between a goal and an index, by the number of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Difference {
    /// The word at this index differs between the goal and the index.
    Word(usize),
    /// This item of the goal and the next are exchanged.
    Swapped(usize),
    /// The goal lacks this item of the index.
    Missing(usize),
    /// The goal has this item too many.
    Extra(usize),
}

/// Number of items above which goals and indexes are not compared.
const ITEMS_MAX: usize = 24;
const SWAPPED: u32 = 12;
const MISSING_WORD: u32 = 14;
const MISSING_VALUE: u32 = 16;
const EXTRA: u32 = 18;
const OTHER_WORD: u32 = 40;

/// Returns the only difference between a goal and an index with its size; `None` if there are several.
pub(super) fn difference(goal: &Datum, index: &Datum) -> Option<(u32, Difference)> {
    let (goal, index) = (goal.as_list()?, index.as_list()?);
    let goal = goal.split(|item| item.is("=>")).next().unwrap_or(goal);
    if goal.len().max(index.len()) > ITEMS_MAX || goal.len().abs_diff(index.len()) > 1 || has_segment(index) {
        return None;
    }
    let (all, wanted): (Vec<&Datum>, Vec<&Datum>) = (goal.iter().collect(), index.iter().collect());
    if goal.len() == index.len() {
        let different: Vec<usize> = goal
            .iter()
            .zip(index)
            .enumerate()
            .filter(|(_, (one, other))| !may_equal(one, other))
            .map(|(at, _)| at)
            .collect();
        if let [at] = different.as_slice() {
            return word(goal, index, *at);
        }
        let swapped = (1..all.len()).find(|at| {
            let mut items = all.clone();
            items.swap(at - 1, *at);
            agree(&items, &wanted)
        });
        return swapped.map(|at| (SWAPPED, Difference::Swapped(at - 1)));
    }
    if goal.len() < index.len() {
        let missing = (0..index.len()).find(|at| {
            let rest: Vec<&Datum> =
                index.iter().enumerate().filter(|(number, _)| number != at).map(|(_, item)| item).collect();
            agree(&all, &rest)
        })?;
        let is_word = index.get(missing).is_some_and(|item| item.as_symbol().is_some());
        return Some((if is_word { MISSING_WORD } else { MISSING_VALUE }, Difference::Missing(missing)));
    }
    let extra = (0..goal.len()).find(|at| {
        let rest: Vec<&Datum> =
            all.iter().enumerate().filter(|(number, _)| number != at).map(|(_, item)| *item).collect();
        agree(&rest, &wanted)
    })?;
    Some((EXTRA, Difference::Extra(extra)))
}

/// Returns true if all items match and at least one word is equal in both.
fn agree(goal: &[&Datum], index: &[&Datum]) -> bool {
    let pairs = || goal.iter().zip(index);
    goal.len() == index.len()
        && pairs().all(|(one, other)| may_equal(one, other))
        && pairs().any(|(one, other)| equal(one, other))
}

/// Compares one word: it may be misspelt, or another word in a goal that is otherwise equal.
fn word(goal: &[Datum], index: &[Datum], at: usize) -> Option<(u32, Difference)> {
    let (written, wanted) = (goal.get(at)?.as_symbol()?, index.get(at)?.as_symbol()?);
    if let Some(near) = near(written.printed(), [wanted.printed()]).first() {
        return Some((near.cost, Difference::Word(at)));
    }
    let same = goal.iter().zip(index).filter(|(one, other)| one.as_symbol().is_some() && equal(one, other)).count();
    // A short word differs strongly from every other word; its context decides.
    let is_short = written.folded().len().max(wanted.folded().len()) <= 3;
    (same >= 2 || (same >= 1 && is_short)).then_some((OTHER_WORD, Difference::Word(at)))
}

fn equal(one: &Datum, other: &Datum) -> bool {
    one.as_symbol().is_some_and(|name| other.as_symbol().is_some_and(|other| name == other))
}

/// Returns true if the item of a goal may match the item of an index.
fn may_equal(goal: &Datum, index: &Datum) -> bool {
    let open = |datum: &Datum| datum.as_symbol().is_none() && datum.has_holes();
    let any = matches!(index.kind, DatumKind::Variable(_) | DatumKind::Bound(_) | DatumKind::Anonymous);
    any || open(goal) || equal(goal, index) || (index.as_list().is_some() && goal.as_list().is_some()) || {
        goal.as_symbol().is_none() && index.as_symbol().is_none() && goal.to_value().matches(&index.to_value())
    }
}

/// Returns true for `(?* ?x)`: the index then has no fixed number of items.
fn has_segment(index: &[Datum]) -> bool {
    index.iter().any(|item| item.as_list().and_then(<[Datum]>::first).is_some_and(|head| head.as_variable().is_some()))
}

/// Returns every word of a goal or an index.
pub(super) fn words(datum: &Datum) -> impl Iterator<Item = &Symbol> {
    datum.as_list().unwrap_or_default().iter().filter_map(Datum::as_symbol)
}

//! Functions that take functions: mapping, filtering, folding, sorting.

use super::evaluator::{Evaluator, error};
use super::lists::{bounded, items};
use super::result::EvalResult;
use super::{EvaluationError, arithmetic};
use apex_model::source::Place;
use apex_model::value::Value;
use std::cmp::Ordering;

/// Calls the function `name` of this family; `None` if there is no such function.
pub(super) fn call(evaluator: &mut Evaluator<'_>, name: &str, arguments: &[Value], place: Place) -> Option<EvalResult> {
    let result = match (name, arguments) {
        ("mapcar", [function, lists @ ..]) => {
            each(evaluator, function, lists, place, |_, value| Some(value)).and_then(|all| finish(all, place))
        }
        ("every", [function, lists @ ..]) => every(evaluator, function, lists, place),
        ("some", [function, lists @ ..]) => some(evaluator, function, lists, place),
        ("remove-if-not", [function, list]) => filter(evaluator, function, list, true, place),
        ("remove-if", [function, list]) => filter(evaluator, function, list, false, place),
        ("find-if", [function, list]) => find(evaluator, function, list, place),
        ("reduce", [function, list]) => reduce(evaluator, function, list, None, place),
        ("reduce", [function, list, initial]) => reduce(evaluator, function, list, Some(initial), place),
        ("sort", [list, function]) => sort(evaluator, list, function, None, place),
        ("sort", [list, function, key]) => sort(evaluator, list, function, Some(key), place),
        ("sort", [list, function, Value::Symbol(keyword), key]) if keyword.is(":key") => {
            sort(evaluator, list, function, Some(key), place)
        }
        ("funcall", [function, arguments @ ..]) => evaluator.call_value(function, arguments, place),
        ("apply", [function, first @ .., last]) => at(items(last), place).and_then(|last| {
            let arguments: Vec<Value> = first.iter().chain(last).cloned().collect();
            evaluator.call_value(function, &arguments, place)
        }),
        _ => return None,
    };
    Some(result)
}

fn at<T>(result: Result<T, String>, place: Place) -> Result<T, EvaluationError> {
    result.map_err(|message| error(place, message))
}

fn finish(values: Vec<Value>, place: Place) -> EvalResult {
    at(bounded(values), place)
}

/// Calls `function` with the first items of all lists, then the second ones, up to the end of the shortest list. `pick` chooses the value
/// kept for each result; `None` ends the loop early.
fn each(
    evaluator: &mut Evaluator<'_>,
    function: &Value,
    lists: &[Value],
    place: Place,
    mut pick: impl FnMut(usize, Value) -> Option<Value>,
) -> Result<Vec<Value>, EvaluationError> {
    let lists = at(lists.iter().map(items).collect::<Result<Vec<_>, _>>(), place)?;
    let length = lists.iter().map(|list| list.len()).min().unwrap_or(0);
    let mut results = Vec::new();
    for index in 0..length {
        let arguments: Vec<Value> = lists.iter().filter_map(|list| list.get(index)).cloned().collect();
        let result = evaluator.call_value(function, &arguments, place)?;
        match pick(index, result) {
            Some(value) => results.push(value),
            None => break,
        }
    }
    Ok(results)
}

fn every(evaluator: &mut Evaluator<'_>, function: &Value, lists: &[Value], place: Place) -> EvalResult {
    let mut truth = true;
    each(evaluator, function, lists, place, |_, value| {
        truth = value.is_true();
        truth.then(Value::nil)
    })?;
    Ok(Value::truth(truth))
}

fn some(evaluator: &mut Evaluator<'_>, function: &Value, lists: &[Value], place: Place) -> EvalResult {
    let mut found = Value::nil();
    each(evaluator, function, lists, place, |_, value| {
        found = value;
        (!found.is_true()).then(Value::nil)
    })?;
    Ok(found)
}

fn filter(evaluator: &mut Evaluator<'_>, function: &Value, list: &Value, wanted: bool, place: Place) -> EvalResult {
    let mut kept = Vec::new();
    for item in at(items(list), place)? {
        if evaluator.call_value(function, std::slice::from_ref(item), place)?.is_true() == wanted {
            kept.push(item.clone());
        }
    }
    finish(kept, place)
}

fn find(evaluator: &mut Evaluator<'_>, function: &Value, list: &Value, place: Place) -> EvalResult {
    for item in at(items(list), place)? {
        if evaluator.call_value(function, std::slice::from_ref(item), place)?.is_true() {
            return Ok(item.clone());
        }
    }
    Ok(Value::nil())
}

fn reduce(
    evaluator: &mut Evaluator<'_>,
    function: &Value,
    list: &Value,
    initial: Option<&Value>,
    place: Place,
) -> EvalResult {
    let mut items = at(items(list), place)?.iter();
    let Some(mut result) = initial.or_else(|| items.next()).cloned() else {
        return evaluator.call_value(function, &[], place);
    };
    for item in items {
        result = evaluator.call_value(function, &[result, item.clone()], place)?;
    }
    Ok(result)
}

/// Sorts by stable merge sort with a comparison that may fail.
fn sort(
    evaluator: &mut Evaluator<'_>,
    list: &Value,
    function: &Value,
    key: Option<&Value>,
    place: Place,
) -> EvalResult {
    let mut keyed = Vec::new();
    for item in at(items(list), place)? {
        let sort_key = match key {
            Some(key) => evaluator.call_value(key, std::slice::from_ref(item), place)?,
            None => item.clone(),
        };
        keyed.push((sort_key, item.clone()));
    }
    let mut width = 1;
    while width < keyed.len() {
        let mut merged = Vec::with_capacity(keyed.len());
        for pair in keyed.chunks(2 * width) {
            let (left, right) = pair.split_at(width.min(pair.len()));
            merge(evaluator, left, right, function, place, &mut merged)?;
        }
        keyed = merged;
        width = width.saturating_mul(2);
    }
    finish(keyed.into_iter().map(|(_, item)| item).collect(), place)
}

type Keyed = (Value, Value);

fn merge(
    evaluator: &mut Evaluator<'_>,
    left: &[Keyed],
    right: &[Keyed],
    function: &Value,
    place: Place,
    merged: &mut Vec<Keyed>,
) -> Result<(), EvaluationError> {
    let (mut left, mut right) = (left.iter().peekable(), right.iter().peekable());
    while let (Some((a, _)), Some((b, _))) = (left.peek(), right.peek()) {
        if before(evaluator, b, a, function, place)? {
            merged.extend(right.next().cloned());
        } else {
            merged.extend(left.next().cloned());
        }
    }
    merged.extend(left.cloned());
    merged.extend(right.cloned());
    Ok(())
}

fn before(
    evaluator: &mut Evaluator<'_>,
    a: &Value,
    b: &Value,
    function: &Value,
    place: Place,
) -> Result<bool, EvaluationError> {
    if matches!(function, Value::Symbol(name) if name.is("<")) {
        evaluator.charge(1, place)?;
        return at(arithmetic::compare(a, b), place).map(|order| order == Some(Ordering::Less));
    }
    Ok(evaluator.call_value(function, &[a.clone(), b.clone()], place)?.is_true())
}

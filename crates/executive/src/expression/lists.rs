//! List functions without function arguments, and predicates on kinds of values.

use super::arithmetic::{add, compare, integer};
use super::result::FunctionResult;
use apex_model::limits::LIST_ITEMS_MAX;
use apex_model::value::Value;
use std::cmp::Ordering;

/// Calls the list function `name`; `None` if there is no such function.
pub(super) fn call(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    Some(match (name, arguments) {
        ("list", items) => Ok(Value::list(items.iter().cloned())),
        ("cons", [item, list]) => items(list).map(|rest| Value::list(std::iter::once(item).chain(rest).cloned())),
        ("append", lists) => append(lists),
        ("first", [list]) => nth(list, 0),
        ("second", [list]) => nth(list, 1),
        ("third", [list]) => nth(list, 2),
        ("fourth", [list]) => nth(list, 3),
        ("fifth", [list]) => nth(list, 4),
        ("rest", [list]) => items(list).map(|items| Value::list(items.iter().skip(1).cloned())),
        ("nth", [index, list]) | ("elt", [list, index]) => index_of(index).and_then(|index| nth(list, index)),
        ("nthcdr", [count, list]) => {
            index_of(count).and_then(|count| items(list).map(|items| Value::list(items.iter().skip(count).cloned())))
        }
        ("last", [list]) => items(list).map(|items| Value::list(items.last().cloned())),
        ("length", [Value::Text(text)]) => whole(text.chars().count()),
        ("length", [list]) => items(list).and_then(|items| whole(items.len())),
        ("reverse", [Value::Text(text)]) => Ok(Value::text(&text.chars().rev().collect::<String>())),
        ("reverse", [list]) => items(list).map(|items| Value::list(items.iter().rev().cloned())),
        ("subseq", [Value::List(list), start]) => part(list, start, None),
        ("subseq", [Value::List(list), start, end]) => part(list, start, Some(end)),
        ("range", [end]) => range(&Value::Integer(0), end, &Value::Integer(1)),
        ("range", [start, end]) => range(start, end, &Value::Integer(1)),
        ("range", [start, end, step]) => range(start, end, step),
        ("getf", [list, key]) => property(list, key, Value::nil()),
        ("getf", [list, key, default]) => property(list, key, default.clone()),
        ("assoc", [key, list]) => items(list).map(|items| association(key, items)),
        _ => return search(name, arguments).or_else(|| kind(name, arguments)),
    })
}

fn search(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    let [left, right] = arguments else { return None };
    Some(match name {
        "member" => items(right).map(|items| {
            let found = items.iter().position(|item| item.equals(left));
            Value::list(found.and_then(|index| items.get(index..)).unwrap_or_default().iter().cloned())
        }),
        "find" => {
            items(right).map(|items| items.iter().find(|item| item.equals(left)).cloned().unwrap_or_else(Value::nil))
        }
        "position" => items(right)
            .and_then(|items| items.iter().position(|item| item.equals(left)).map_or(Ok(Value::nil()), whole)),
        "remove" => items(right).map(|items| Value::list(items.iter().filter(|item| !item.equals(left)).cloned())),
        "union" => {
            both(left, right, |a, b| a.iter().chain(b.iter().filter(|item| !contains(a, item))).cloned().collect())
        }
        "intersection" => both(left, right, |a, b| a.iter().filter(|item| contains(b, item)).cloned().collect()),
        "set-difference" => both(left, right, |a, b| a.iter().filter(|item| !contains(b, item)).cloned().collect()),
        "eq" | "eql" | "equal" => Ok(Value::truth(left.equals(right))),
        "equalp" => Ok(Value::truth(left.matches(right))),
        _ => return None,
    })
}

fn kind(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    let [value] = arguments else { return None };
    let truth = match name {
        "not" => !value.is_true(),
        "atom" => value.as_list().is_none_or(<[Value]>::is_empty),
        "consp" => value.as_list().is_some_and(|items| !items.is_empty()),
        "listp" => value.as_list().is_some(),
        "symbolp" => matches!(value, Value::Symbol(_)) || !value.is_true(),
        "stringp" => matches!(value, Value::Text(_)),
        "remove-duplicates" => return Some(items(value).map(without_duplicates)),
        _ => return None,
    };
    Some(Ok(Value::truth(truth)))
}

/// Returns the number of comparisons that `name` may need: charged against the evaluation's limit before the call.
pub(super) fn cost(name: &str, arguments: &[Value]) -> u64 {
    let length = |value: Option<&Value>| value.and_then(Value::as_list).map_or(1, |items| items.len() as u64);
    let (left, right) = (length(arguments.first()), length(arguments.get(1)));
    match name {
        "union" | "intersection" | "set-difference" => left.saturating_mul(right),
        "remove-duplicates" => left.saturating_mul(left),
        "/=" => (arguments.len() as u64).saturating_mul(arguments.len() as u64),
        _ => arguments.len() as u64 + (left + right) / 16,
    }
}

/// Returns the items of `value`.
///
/// # Errors
/// If `value` is not a list.
pub(super) fn items(value: &Value) -> Result<&[Value], String> {
    value.as_list().ok_or_else(|| format!("expected a list, found {value}"))
}

/// Returns a list of `items`, within the limit.
///
/// # Errors
/// When there are too many.
pub(super) fn bounded(mut items: impl AsMut<[Value]>) -> FunctionResult {
    let items = items.as_mut();
    if items.len() > LIST_ITEMS_MAX {
        return Err(format!(
            "a list of {} items is longer than the limit LIST_ITEMS_MAX = {LIST_ITEMS_MAX}",
            items.len()
        ));
    }
    Ok(Value::list_of(items))
}

fn contains(items: &[Value], wanted: &Value) -> bool {
    items.iter().any(|item| item.equals(wanted))
}

fn both(left: &Value, right: &Value, operation: fn(&[Value], &[Value]) -> Vec<Value>) -> FunctionResult {
    bounded(operation(items(left)?, items(right)?))
}

fn append(lists: &[Value]) -> FunctionResult {
    let mut all = Vec::new();
    for list in lists {
        let items = items(list)?;
        if all.len() + items.len() > LIST_ITEMS_MAX {
            return Err(format!("append makes a list longer than the limit LIST_ITEMS_MAX = {LIST_ITEMS_MAX}"));
        }
        all.extend(items.iter().cloned());
    }
    Ok(Value::list(all))
}

fn nth(list: &Value, index: usize) -> FunctionResult {
    items(list).map(|items| items.get(index).cloned().unwrap_or_else(Value::nil))
}

/// Returns `value` as an index or count.
///
/// # Errors
/// If `value` is not a whole number of at least zero.
pub(super) fn index_of(value: &Value) -> Result<usize, String> {
    let integer = integer(value)?;
    usize::try_from(integer).map_err(|_| format!("expected an index from 0 on, found {integer}"))
}

fn whole(length: usize) -> FunctionResult {
    i64::try_from(length).map(Value::Integer).map_err(|_| format!("{length} is too large for an integer"))
}

fn part(list: &[Value], start: &Value, end: Option<&Value>) -> FunctionResult {
    let (start, end) = bounds(start, end, list.len())?;
    Ok(Value::list(list.iter().skip(start).take(end - start).cloned()))
}

/// Returns start and end of a part of a sequence with `length` elements.
///
/// # Errors
/// If `start` and `end` are not in order within the list.
pub(super) fn bounds(start: &Value, end: Option<&Value>, length: usize) -> Result<(usize, usize), String> {
    let start = index_of(start)?;
    let end = end.filter(|end| end.is_true()).map(index_of).transpose()?.unwrap_or(length);
    if start <= end && end <= length {
        Ok((start, end))
    } else {
        Err(format!("the part from {start} to {end} does not lie within a length of {length}"))
    }
}

fn range(start: &Value, end: &Value, step: &Value) -> FunctionResult {
    let zero = super::arithmetic::subtract(step, step)?;
    let direction = match compare(step, &zero)? {
        Some(Ordering::Greater) => Ordering::Less,
        Some(Ordering::Less) => Ordering::Greater,
        _ => return Err(format!("range with a step of {step} never ends")),
    };
    let mut all = Vec::new();
    let mut value = start.clone();
    while compare(&value, end)? == Some(direction) {
        if all.len() >= LIST_ITEMS_MAX {
            return Err(format!("range makes a list longer than the limit LIST_ITEMS_MAX = {LIST_ITEMS_MAX}"));
        }
        let next = add(&value, step)?;
        all.push(std::mem::replace(&mut value, next));
    }
    Ok(Value::list(all))
}

fn property(list: &Value, key: &Value, default: Value) -> FunctionResult {
    let items = items(list)?;
    Ok(items
        .chunks(2)
        .find_map(|pair| match pair {
            [name, value] if name.equals(key) => Some(value.clone()),
            _ => None,
        })
        .unwrap_or(default))
}

fn association(key: &Value, items: &[Value]) -> Value {
    items
        .iter()
        .find(|item| item.as_list().and_then(<[Value]>::first).is_some_and(|first| first.equals(key)))
        .cloned()
        .unwrap_or_else(Value::nil)
}

fn without_duplicates(items: &[Value]) -> Value {
    let mut kept: Vec<Value> = Vec::new();
    for item in items {
        if !contains(&kept, item) {
            kept.push(item.clone());
        }
    }
    Value::list(kept)
}

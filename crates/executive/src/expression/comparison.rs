//! Comparison of values: `=`, `<` and similar functions, the greatest and the least value, predicates on numbers.

use super::arithmetic::{described, integer, number};
use super::result::FunctionResult;
use apex_model::value::Value;
use std::cmp::Ordering;

/// Calls the comparing function `name`; `None` if there is no such function.
pub(super) fn call(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    Some(match (name, arguments) {
        ("<" | "<=" | ">" | ">=", values) => chain(name, values),
        ("=", values) => all_pairs_in_row(values),
        ("/=", values) => all_different(values),
        ("min", [first, rest @ ..]) => extreme(first, rest, Ordering::Less),
        ("max", [first, rest @ ..]) => extreme(first, rest, Ordering::Greater),
        _ => return predicate(name, arguments),
    })
}

fn predicate(name: &str, arguments: &[Value]) -> Option<FunctionResult> {
    let [value] = arguments else { return None };
    let truth = match name {
        "zerop" => number(value).map(|(number, _)| number == 0.0),
        "plusp" => number(value).map(|(number, _)| number > 0.0),
        "minusp" => number(value).map(|(number, _)| number < 0.0),
        "evenp" => integer(value).map(|integer| integer.rem_euclid(2) == 0),
        "oddp" => integer(value).map(|integer| integer.rem_euclid(2) == 1),
        "numberp" => Ok(value.as_number().is_some()),
        "integerp" => Ok(matches!(value, Value::Integer(_))),
        "realp" => Ok(matches!(value, Value::Integer(_) | Value::Real(_))),
        _ => return None,
    };
    Some(truth.map(Value::truth))
}

/// Compares two values for `<` and similar functions; `None` if one of them is not a number.
///
/// # Errors
/// When their kinds or dimensions cannot be compared.
pub(crate) fn compare(left: &Value, right: &Value) -> Result<Option<Ordering>, String> {
    if let Some(order) = left.order(right) {
        return Ok(Some(order));
    }
    let infinite = |value: &Value| match value {
        Value::Real(real) if real.is_infinite() => Some(*real > 0.0),
        _ => None,
    };
    let numeric = |value: &Value| value.as_number().is_some() || matches!(value, Value::Time(_));
    match (infinite(left), infinite(right)) {
        (Some(positive), None) if numeric(right) => {
            return Ok(Some(if positive { Ordering::Greater } else { Ordering::Less }));
        }
        (None, Some(positive)) if numeric(left) => {
            return Ok(Some(if positive { Ordering::Less } else { Ordering::Greater }));
        }
        _ => {}
    }
    match (left.as_number(), right.as_number()) {
        (Some((a, dimension_a)), Some((b, dimension_b)))
            if dimension_a == dimension_b && (a.is_nan() || b.is_nan()) =>
        {
            Ok(None)
        }
        _ => Err(format!("cannot compare {} with {}", described(left), described(right))),
    }
}

/// Compares two values as PDL's `=` does, but refuses numbers of different dimensions, which are equal only by mistake.
///
/// # Errors
/// When both are numbers and their dimensions differ.
pub(crate) fn equal(left: &Value, right: &Value) -> Result<bool, String> {
    match (left.as_number(), right.as_number()) {
        (Some((_, a)), Some((_, b))) if a != b => compare(left, right).map(|order| order == Some(Ordering::Equal)),
        _ => Ok(left.equals(right)),
    }
}

fn chain(name: &str, values: &[Value]) -> FunctionResult {
    for pair in values.windows(2) {
        let [left, right] = pair else { continue };
        let holds = match (compare(left, right)?, name) {
            (None, _) => false,
            (Some(order), "<") => order.is_lt(),
            (Some(order), "<=") => order.is_le(),
            (Some(order), ">") => order.is_gt(),
            (Some(order), _) => order.is_ge(),
        };
        if !holds {
            return Ok(Value::nil());
        }
    }
    Ok(Value::truth(true))
}

fn all_pairs_in_row(values: &[Value]) -> FunctionResult {
    for pair in values.windows(2) {
        if let [left, right] = pair
            && !equal(left, right)?
        {
            return Ok(Value::nil());
        }
    }
    Ok(Value::truth(true))
}

fn all_different(values: &[Value]) -> FunctionResult {
    for (index, left) in values.iter().enumerate() {
        for right in values.iter().skip(index + 1) {
            if equal(left, right)? {
                return Ok(Value::nil());
            }
        }
    }
    Ok(Value::truth(true))
}

fn extreme(first: &Value, rest: &[Value], wanted: Ordering) -> FunctionResult {
    let mut best = first;
    for value in [first].into_iter().chain(rest) {
        if !matches!(value, Value::Time(_)) {
            number(value)?;
        }
    }
    for value in rest {
        if compare(value, best)? == Some(wanted) {
            best = value;
        }
    }
    Ok(best.clone())
}

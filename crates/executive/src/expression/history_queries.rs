//! Queries of histories: values at an instant, before an instant and over a span of time.
//!
//! A query of a time whose samples are no longer kept is an error, never a wrong answer.

use super::EvalContext;
use super::arithmetic::{add, compare, described, instant};
use super::result::FunctionResult;
use crate::state::histories::history::{History, Occurrence, Sample};
use apex_model::event::StateVariable;
use apex_model::limits::LIST_ITEMS_MAX;
use apex_model::quantity::Quantity;
use apex_model::time::Time;
use apex_model::value::Value;
use std::cmp::Ordering;

/// Calls the history query `name`; `None` if there is no such function. `published` returns samples that the agent has published at this
/// instant, which are not recorded yet.
pub(super) fn call(
    name: &str,
    arguments: &[Value],
    context: &dyn EvalContext,
    published: &dyn Fn(&StateVariable) -> Option<Value>,
) -> Option<FunctionResult> {
    if name == "events-over" {
        return Some(events(arguments, context));
    }
    let known = matches!(
        name,
        "current-value"
            | "value-at"
            | "value-before"
            | "most-recent-svvalue"
            | "mean-over"
            | "min-over"
            | "max-over"
            | "samples-over"
    );
    let [attribute, object, rest @ ..] = arguments else { return None };
    known.then(|| {
        let Value::Symbol(attribute) = attribute else {
            return Err(format!("{name} needs the attribute as a symbol ('altitude), found {attribute}"));
        };
        let variable = StateVariable::new(attribute.clone(), object.clone());
        match published(&variable) {
            Some(value) => with_published(name, &variable, value, rest, context),
            None => query(name, &variable, rest, context.histories().get(&variable), context),
        }
    })
}

/// The functions of this file whose first argument is an attribute; retention is derived from them.
pub(crate) const QUERIES: &[&str] =
    &["value-at", "value-before", "most-recent-svvalue", "mean-over", "min-over", "max-over", "samples-over"];

/// Evaluates [`query`] on a history that also holds `value` at this instant.
fn with_published(
    name: &str,
    variable: &StateVariable,
    value: Value,
    rest: &[Value],
    context: &dyn EvalContext,
) -> FunctionResult {
    if let ("current-value", []) | ("most-recent-svvalue", []) = (name, rest) {
        return Ok(value);
    }
    let mut history = context.histories().get(variable).cloned().unwrap_or_default();
    let sample = Sample { at: context.now(), sequence: u64::MAX, value };
    history.record(sample, usize::MAX);
    query(name, variable, rest, Some(&history), context)
}

fn query(
    name: &str,
    variable: &StateVariable,
    rest: &[Value],
    history: Option<&History>,
    context: &dyn EvalContext,
) -> FunctionResult {
    let Some(history) = history else {
        return Ok(Value::nil());
    };
    match (name, rest) {
        ("current-value", []) | ("most-recent-svvalue", []) => Ok(value_of(history.newest())),
        ("value-at", [at]) => {
            let at = instant(at)?;
            found(history.at(at), history, variable, at)
        }
        ("value-before", [at]) => {
            let at = instant(at)?;
            found(history.before(at), history, variable, at)
        }
        ("most-recent-svvalue", [Value::Symbol(keyword), at]) if keyword.is(":prior-to") => {
            let at = instant(at)?;
            found(history.before(at), history, variable, at)
        }
        ("mean-over" | "min-over" | "max-over" | "samples-over", window @ ([_] | [_, _])) => {
            let (start, end) = span(window, context.now())?;
            if !history.covers(start) && history.samples().next().is_none_or(|oldest| oldest.at > start) {
                return Err(no_longer_kept(history, variable, start));
            }
            aggregate(name, history.between(start, end))
        }
        _ => Err(format!("{name} does not take these arguments: {}", super::printed(rest))),
    }
}

/// Evaluates `(events-over WORD WINDOW)`: returns the messages that begin with the word.
fn events(arguments: &[Value], context: &dyn EvalContext) -> FunctionResult {
    let (Some(Value::Symbol(word)), Some(window @ ([_] | [_, _]))) = (arguments.first(), arguments.get(1..)) else {
        let given = super::printed(arguments);
        return Err(format!("events-over needs a word ('arrived) and a window, found {given}"));
    };
    let (start, end) = span(window, context.now())?;
    let Some(events) = context.histories().events_of(word, start, end) else {
        return Err(format!(
            "messages ({word} ..) of {start} are no longer kept; a (log (:events {word})) clause keeps them longer"
        ));
    };
    let pair = |event: &Occurrence| Value::list([Value::Time(event.at), event.form.clone()]);
    Ok(Value::list(events.into_iter().take(LIST_ITEMS_MAX).map(pair)))
}

fn value_of(sample: Option<&Sample>) -> Value {
    sample.map_or_else(Value::nil, |sample| sample.value.clone())
}

fn found(sample: Option<&Sample>, history: &History, variable: &StateVariable, at: Time) -> FunctionResult {
    let certain = sample.map_or(history.forgotten_until.is_none(), |sample| history.covers(sample.at));
    if certain { Ok(value_of(sample)) } else { Err(no_longer_kept(history, variable, at)) }
}

fn no_longer_kept(history: &History, variable: &StateVariable, at: Time) -> String {
    let instead = match history.has_overflowed() {
        true => "there were more than the limit keeps: query a shorter time".to_string(),
        false => format!("a (log {variable} ..) clause keeps them longer"),
    };
    format!("samples of {variable} around {at} are no longer kept; {instead}")
}

fn span(window: &[Value], now: Time) -> Result<(Time, Time), String> {
    match window {
        [Value::Duration(duration)] => Ok((now - *duration, now)),
        [Value::Interval(start, end)] => Ok((*start, *end)),
        [start] => Ok((instant(start)?, now)),
        [start, end] => Ok((instant(start)?, instant(end)?)),
        _ => Err("a window is a duration, an interval, or a start and an end".into()),
    }
}

fn aggregate<'a>(name: &str, samples: impl Iterator<Item = &'a Sample>) -> FunctionResult {
    match name {
        "samples-over" => Ok(Value::list(
            samples.take(LIST_ITEMS_MAX).map(|sample| Value::list([Value::Time(sample.at), sample.value.clone()])),
        )),
        "mean-over" => mean(samples),
        _ => {
            let wanted = if name == "min-over" { Ordering::Less } else { Ordering::Greater };
            let mut best: Option<&Value> = None;
            for Sample { value, .. } in samples {
                if best.map_or(Ok(true), |best| compare(value, best).map(|order| order == Some(wanted)))? {
                    best = Some(value);
                }
            }
            Ok(best.cloned().unwrap_or_else(Value::nil))
        }
    }
}

/// Returns the mean, computed relative to the first value so that large offsets cost no digits. Infinite values do not count.
fn mean<'a>(samples: impl Iterator<Item = &'a Sample>) -> FunctionResult {
    let mut anchor: Option<(f64, &Value)> = None;
    let (mut sum, mut count) = (0.0, 0.0);
    for Sample { value, .. } in samples {
        let (number, dimension) = value.as_number().ok_or_else(|| format!("mean-over found {}", described(value)))?;
        if number.is_infinite() {
            continue;
        }
        let (origin, first) = *anchor.get_or_insert((number, value));
        if first.as_number().is_some_and(|(_, expected)| expected != dimension) {
            return Err(format!("mean-over found {} and {}", described(first), described(value)));
        }
        sum += number - origin;
        count += 1.0;
    }
    let Some((origin, first)) = anchor else { return Ok(Value::nil()) };
    Ok(match first {
        Value::Quantity(quantity) => Value::Quantity(Quantity { si: origin + sum / count, ..*quantity }),
        Value::Duration(_) => add(first, &Value::measured(sum / count, apex_model::quantity::Dimension::TIME))?,
        _ => Value::Real(origin + sum / count),
    })
}

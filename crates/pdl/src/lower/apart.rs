//! Numbers separated from their units: `55 min` is two parts of a goal, or two values, whereas `55min` is one.

use super::expected::of_unit;
use super::goals::GoalIndex;
use crate::diagnostic::Span;
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use apex_model::expression::Template;
use apex_model::quantity::{Unit, unit_named};
use apex_model::value::Value;

/// A number and the unit after it: its index among the items, the number, the unit.
type Apart = (usize, f64, &'static Unit);

/// Returns a fix that writes `20 seconds`, which is meant as one value, as one word.
pub(super) fn apart_from_unit(values: &[Datum]) -> Option<Fix> {
    let [(0, ..)] = apart(values).as_slice() else { return None };
    let [number, unit] = values else { return None };
    Some(match gap(number, unit) {
        Some(gap) => Fix::safe("write number and unit as one word").replace(gap, ""),
        None => {
            let fix = Fix::safe("put number and unit into parentheses");
            fix.insert_before(number.span, "(").insert_after(unit.span, ")")
        }
    })
}

/// Returns a fix that joins each number of a goal with its unit, if a method serves the joined goal. `text` returns the written text.
pub(super) fn joined(
    goal: &Datum,
    template: &Template,
    index: &GoalIndex<'_>,
    text: impl Fn(&Datum) -> Option<String>,
) -> Option<Fix> {
    let items = goal.as_list()?;
    let found = apart(items);
    let mut parts: Vec<Template> = match template {
        Template::List(parts) => parts.clone(),
        Template::Constant(Value::List(items)) => items.iter().cloned().map(Template::Constant).collect(),
        _ => return None,
    };
    let mut words = Vec::new();
    let mut fix = Fix::safe("");
    for (at, number, unit) in found.iter().rev() {
        let (digits, name) = (items.get(*at)?, items.get(at + 1)?);
        *parts.get_mut(*at)? = Template::Constant(of_unit(*number, unit));
        (at + 1 < parts.len()).then(|| parts.remove(at + 1))?;
        fix = fix.replace(gap(digits, name)?, "");
        words.push(format!("`{}{}`", text(digits)?, text(name)?));
    }
    words.reverse();
    fix.edits.reverse();
    fix.title = format!("write {}", words.join(" and "));
    // A goal without holes is a single value.
    let constant = |part: &Template| match part {
        Template::Constant(value) => Some(value.clone()),
        _ => None,
    };
    let whole: Option<Vec<Value>> = parts.iter().map(constant).collect();
    let goal = whole.map_or(Template::List(parts), |items| Template::Constant(Value::list(items)));
    (!found.is_empty() && index.serves(&goal)).then_some(fix)
}

fn apart(items: &[Datum]) -> Vec<Apart> {
    let pair = |(at, pair): (usize, &[Datum])| {
        let [number, unit] = pair else { return None };
        let number = match number.kind {
            DatumKind::Integer(integer) => integer as f64,
            DatumKind::Real(real) => real,
            _ => return None,
        };
        Some((at, number, unit_named(unit.as_symbol()?.printed())?))
    };
    items.windows(2).enumerate().filter_map(pair).collect()
}

/// Returns the single blank between the two; a line end or a comment there must not be removed automatically.
fn gap(number: &Datum, unit: &Datum) -> Option<Span> {
    let gap = Span { start: number.span.end, end: unit.span.start, ..number.span };
    (gap.end == gap.start.saturating_add(1) && number.span.line == unit.span.line).then_some(gap)
}

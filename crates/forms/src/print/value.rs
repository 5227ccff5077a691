//! Values as text from which exactly the same value is read.

use apex_model::quantity::{Quantity, Unit, format_rounded};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Returns the value as a datum.
pub(super) fn value_text(value: &Value) -> String {
    match value {
        Value::Quantity(quantity) => quantity_text(quantity),
        Value::List(items) if !items.is_empty() => super::layout::list_text("", items.iter().map(value_text)),
        Value::Real(real) if real.is_infinite() => if *real > 0.0 { "1e999" } else { "-1e999" }.to_string(),
        other => other.to_string(),
    }
}

/// Returns the shortest text in the quantity's stated unit that gives the same bits, or otherwise its text in SI units.
fn quantity_text(quantity: &Quantity) -> String {
    let spelling = |unit: &'static Unit, number: &str| {
        let exact = number.parse::<f64>().is_ok_and(|parsed| Quantity::of(parsed, unit) == *quantity);
        exact.then(|| if unit.name == "FL" { format!("FL{number}") } else { format!("{number}{}", unit.name) })
    };
    let in_unit = quantity.unit().and_then(|unit| {
        let number = quantity.in_unit(unit);
        let exact = [number, number.next_up(), number.next_down()];
        let candidates = std::iter::once(format_rounded(number)).chain(exact.iter().map(f64::to_string));
        candidates.into_iter().find_map(|number| spelling(unit, &number))
    });
    let in_si = || {
        let unit = Quantity::si(quantity.si, quantity.dimension).unit()?;
        spelling(unit, &quantity.si.to_string())
    };
    in_unit.or_else(in_si).unwrap_or_else(|| quantity.to_string())
}

fn looks_like_hole(symbol: &Symbol) -> bool {
    let text = symbol.folded();
    text.starts_with('?') || text.starts_with("<?") || (text.len() > 2 && text.starts_with('+') && text.ends_with('+'))
}

/// Returns the value where holes are allowed: symbols that would be read as holes are quoted.
pub(super) fn literal_text(value: &Value) -> String {
    match value {
        Value::Symbol(symbol) if looks_like_hole(symbol) => format!("'{symbol}"),
        Value::List(items) if !items.is_empty() => super::layout::list_text("", items.iter().map(literal_text)),
        other => value_text(other),
    }
}

//! Values of variables, messages, histories and expressions.
//!
//! `nil` and the empty list are one value and mean false; `t` is the symbol for true; every other value counts as true.
//! A location is a list `(latitude_deg longitude_deg [altitude_m])` of plain reals on WGS84.

use crate::expression::Closure;
use crate::quantity::{Dimension, Quantity};
use crate::symbol::Symbol;
use crate::task::TaskId;
use crate::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// A PDL value.
#[derive(Clone, Serialize, Deserialize)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A real number without dimension.
    Real(f64),
    /// A number with a dimension other than time.
    Quantity(Quantity),
    /// A span of time.
    Duration(Duration),
    /// An instant.
    Time(Time),
    /// A name.
    Symbol(Symbol),
    /// A string.
    Text(Arc<str>),
    /// A list; empty is `nil`.
    List(Arc<[Value]>),
    /// The closed interval of a recognised condition or a task.
    Interval(Time, Time),
    /// A task, as bound to its step's tag.
    Task(TaskId),
    /// A function value made by `lambda` or `#'name`.
    Closure(Arc<Closure>),
}

impl Value {
    /// Returns the first word of a form: the symbol itself, or the symbol that a list begins with.
    #[inline]
    pub fn head(&self) -> Option<&Symbol> {
        match self {
            Value::Symbol(symbol) => Some(symbol),
            other => other.as_list()?.first()?.as_symbol(),
        }
    }

    /// Returns `nil`: the empty list, false.
    pub fn nil() -> Value {
        // The empty list is shared: no space is taken.
        Value::List(Arc::default())
    }

    /// Returns the symbol `name`.
    pub fn symbol(name: &str) -> Value {
        Value::Symbol(Symbol::new(name))
    }

    /// Returns a string.
    pub fn text(text: &str) -> Value {
        Value::Text(Arc::from(text))
    }

    /// Returns a list of `items`.
    pub fn list(items: impl IntoIterator<Item = Value>) -> Value {
        Value::List(items.into_iter().collect())
    }

    /// Returns a list of `items`, which are taken out.
    pub fn list_of(items: &mut [Value]) -> Value {
        Value::List(items.iter_mut().map(|item| std::mem::replace(item, Value::Integer(0))).collect())
    }

    /// Returns `t` or `nil`.
    pub fn truth(truth: bool) -> Value {
        if truth { Value::symbol("t") } else { Value::nil() }
    }

    /// Returns a number in SI units: a real if dimensionless, a duration if it is a time, otherwise a quantity.
    pub fn measured(si: f64, dimension: Dimension) -> Value {
        match dimension {
            Dimension::NONE => Value::Real(si),
            Dimension::TIME => Value::Duration(Duration::from_seconds(si)),
            other => Value::Quantity(Quantity::si(si, other)),
        }
    }

    /// Returns false only for `nil`.
    pub fn is_true(&self) -> bool {
        !matches!(self, Value::List(items) if items.is_empty())
    }

    /// Returns the list's items, if this is a list.
    pub fn as_list(&self) -> Option<&[Value]> {
        match self {
            Value::List(items) => Some(items),
            _ => None,
        }
    }

    /// Returns the symbol; `None` for other values.
    pub fn as_symbol(&self) -> Option<&Symbol> {
        match self {
            Value::Symbol(symbol) => Some(symbol),
            _ => None,
        }
    }

    /// Returns SI number and dimension of a numeric value. Instants are not numbers.
    pub fn as_number(&self) -> Option<(f64, Dimension)> {
        match self {
            Value::Integer(integer) => Some((*integer as f64, Dimension::NONE)),
            Value::Real(real) => Some((*real, Dimension::NONE)),
            Value::Quantity(quantity) => Some((quantity.si, quantity.dimension)),
            Value::Duration(duration) => Some((duration.seconds(), Dimension::TIME)),
            _ => None,
        }
    }

    /// Compares as PDL's `=`: numbers by value within a dimension, symbols in any case, lists element-wise. NaN equals nothing.
    pub fn equals(&self, other: &Value) -> bool {
        self.compare_items(other, |a, b| a == b)
    }

    /// Compares as patterns do: like [`Value::equals`], but strings in any case.
    pub fn matches(&self, other: &Value) -> bool {
        self.compare_items(other, |a, b| a == b || a.to_lowercase() == b.to_lowercase())
    }

    fn compare_items(&self, other: &Value, text: fn(&str, &str) -> bool) -> bool {
        match (self, other) {
            (Value::Integer(a), Value::Integer(b)) => a == b,
            (Value::Duration(a), Value::Duration(b)) => a == b,
            (Value::Symbol(a), Value::Symbol(b)) => a == b,
            (Value::Text(a), Value::Text(b)) => text(a, b),
            (Value::List(a), Value::List(b)) => {
                a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| a.compare_items(b, text))
            }
            (Value::Time(a), Value::Time(b)) => a == b,
            (Value::Interval(a, b), Value::Interval(c, d)) => a == c && b == d,
            (Value::Task(a), Value::Task(b)) => a == b,
            (Value::Closure(a), Value::Closure(b)) => a == b,
            _ => match (self.as_number(), other.as_number()) {
                (Some((a, dimension_a)), Some((b, dimension_b))) => dimension_a == dimension_b && a == b,
                _ => false,
            },
        }
    }

    /// Compares two numbers of one dimension, or two instants; `None` for all other values and for NaN.
    pub fn order(&self, other: &Value) -> Option<Ordering> {
        match (self, other) {
            (Value::Integer(a), Value::Integer(b)) => Some(a.cmp(b)),
            (Value::Duration(a), Value::Duration(b)) => Some(a.cmp(b)),
            (Value::Time(a), Value::Time(b)) => Some(a.cmp(b)),
            _ => match (self.as_number(), other.as_number()) {
                (Some((a, dimension_a)), Some((b, dimension_b))) if dimension_a == dimension_b => a.partial_cmp(&b),
                _ => None,
            },
        }
    }

    fn rank(&self) -> u8 {
        match self {
            Value::Integer(_) => 0,
            Value::Real(_) => 1,
            Value::Quantity(_) => 2,
            Value::Duration(_) => 3,
            Value::Time(_) => 4,
            Value::Symbol(_) => 5,
            Value::Text(_) => 6,
            Value::List(_) => 7,
            Value::Interval(..) => 8,
            Value::Task(_) => 9,
            Value::Closure(_) => 10,
        }
    }
}

/// Structural order for keys of ordered maps; not PDL's comparison (see [`Value::order`]).
impl Ord for Value {
    fn cmp(&self, other: &Value) -> Ordering {
        match (self, other) {
            (Value::Integer(a), Value::Integer(b)) => a.cmp(b),
            (Value::Real(a), Value::Real(b)) => a.total_cmp(b),
            (Value::Quantity(a), Value::Quantity(b)) => a.dimension.cmp(&b.dimension).then(a.si.total_cmp(&b.si)),
            (Value::Duration(a), Value::Duration(b)) => a.cmp(b),
            (Value::Time(a), Value::Time(b)) => a.cmp(b),
            (Value::Symbol(a), Value::Symbol(b)) => a.cmp(b),
            (Value::Text(a), Value::Text(b)) => a.cmp(b),
            (Value::List(a), Value::List(b)) => a.cmp(b),
            (Value::Interval(a, b), Value::Interval(c, d)) => a.cmp(c).then(b.cmp(d)),
            (Value::Task(a), Value::Task(b)) => a.cmp(b),
            (Value::Closure(a), Value::Closure(b)) => a.place.cmp(&b.place),
            _ => self.rank().cmp(&other.rank()),
        }
    }
}

impl PartialOrd for Value {
    fn partial_cmp(&self, other: &Value) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Structural equality (bit-equal reals), for the comparison of snapshots; it differs from PDL's `=` (see [`Value::equals`]).
impl PartialEq for Value {
    fn eq(&self, other: &Value) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Value {}

/// Agrees with the structural equality.
impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u8(self.rank());
        match self {
            Value::Integer(integer) => state.write_i64(*integer),
            Value::Real(real) => state.write_u64(real.to_bits()),
            Value::Quantity(quantity) => state.write_u64(quantity.si.to_bits()),
            Value::Duration(duration) => state.write_i64(duration.0),
            Value::Time(time) => state.write_i64(time.0),
            Value::Symbol(symbol) => symbol.hash(state),
            Value::Text(text) => text.hash(state),
            Value::List(items) => items.iter().for_each(|item| item.hash(state)),
            Value::Interval(start, end) => {
                state.write_i64(start.0);
                state.write_i64(end.0);
            }
            Value::Task(task) => state.write_u64(task.0),
            Value::Closure(_) => {}
        }
    }
}

impl fmt::Display for Value {
    /// Writes PDL text that is read back as the same value to twelve digits, except for tasks, intervals, instants and functions.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Integer(integer) => write!(f, "{integer}"),
            Value::Real(real) => write!(f, "{real:?}"),
            Value::Quantity(quantity) => write!(f, "{quantity}"),
            Value::Duration(duration) => write!(f, "{duration}"),
            Value::Time(time) => write!(f, "{time}"),
            Value::Symbol(symbol) => write!(f, "{symbol}"),
            Value::Text(text) => write_text(f, text),
            Value::List(items) if items.is_empty() => f.write_str("nil"),
            Value::List(items) => {
                f.write_str("(")?;
                for (index, item) in items.iter().enumerate() {
                    if index > 0 {
                        f.write_str(" ")?;
                    }
                    write!(f, "{item}")?;
                }
                f.write_str(")")
            }
            Value::Interval(start, end) => write!(f, "[{start}, {end}]"),
            Value::Task(task) => write!(f, "{task}"),
            Value::Closure(_) => f.write_str("#<function>"),
        }
    }
}

fn write_text(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    f.write_str("\"")?;
    for character in text.chars() {
        if matches!(character, '"' | '\\') {
            f.write_str("\\")?;
        }
        write!(f, "{character}")?;
    }
    f.write_str("\"")
}

impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_is_two_point_zero_and_feet_are_not_seconds() {
        assert!(Value::Integer(2).equals(&Value::Real(2.0)));
        assert!(!Value::Integer(2).equals(&Value::Duration(Duration::from_seconds(2.0))));
        assert!(!Value::Real(f64::NAN).equals(&Value::Real(f64::NAN)));
    }

    #[test]
    fn strings_match_in_any_case_but_equal_exactly() {
        assert!(Value::text("Abort").matches(&Value::text("ABORT")));
        assert!(!Value::text("Abort").equals(&Value::text("ABORT")));
    }
}

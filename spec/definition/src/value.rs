//! Values, and the constraints of conditions on them.

use crate::condition::{Constraint, Relation, Term};
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Integers and reals compare by value.
    Number(f64),
    /// A symbol in lower case.
    Symbol(String),
    /// A text, which compares with case.
    Text(String),
}

impl Value {
    /// Returns a symbol.
    pub fn symbol(name: &str) -> Value {
        Value::Symbol(name.into())
    }
}

/// Values of variables.
pub type Bindings = BTreeMap<String, Value>;

/// Returns true if the relation holds. Values that have no order are only equal or different.
pub(crate) fn holds(relation: Relation, left: &Value, right: &Value) -> bool {
    match (left, right) {
        (Value::Number(left), Value::Number(right)) => numbers(relation, *left, *right),
        _ => match relation {
            Relation::Equal => left == right,
            Relation::Different => left != right,
            _ => false,
        },
    }
}

/// Returns true if the relation between the numbers holds.
pub(crate) fn numbers<N: PartialOrd>(relation: Relation, left: N, right: N) -> bool {
    let order = left.partial_cmp(&right);
    match relation {
        Relation::Equal => order == Some(Ordering::Equal),
        Relation::Different => order != Some(Ordering::Equal),
        Relation::Less => order == Some(Ordering::Less),
        Relation::LessOrEqual => matches!(order, Some(Ordering::Less | Ordering::Equal)),
        Relation::Greater => order == Some(Ordering::Greater),
        Relation::GreaterOrEqual => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
    }
}

/// Returns true if all constraints hold for the value. Variables of `= ?x` are bound, or must already have the same value.
pub(crate) fn fits(value: &Value, constraints: &[Constraint], bound: &mut Bindings) -> bool {
    constraints.iter().all(|constraint| match (constraint, value) {
        (Constraint::Compare(Relation::Equal, Value::Number(wanted), Some(tolerance)), Value::Number(number)) => {
            (number - wanted).abs() <= *tolerance
        }
        (Constraint::Compare(relation, wanted, _), _) => holds(*relation, value, wanted),
        (Constraint::Bind(name), _) => bind(name, value, bound),
        (Constraint::Range(least, most), Value::Number(number)) => {
            least.is_none_or(|least| least <= *number) && most.is_none_or(|most| *number <= most)
        }
        (Constraint::Odd, Value::Number(number)) => number % 2.0 == 1.0 || number % 2.0 == -1.0,
        (Constraint::Range(..) | Constraint::Odd, _) => false,
    })
}

fn bind(name: &str, value: &Value, bound: &mut Bindings) -> bool {
    bound.entry(name.into()).or_insert_with(|| value.clone()) == value
}

/// Returns true if the term matches the value.
pub(crate) fn matches(term: &Term, value: &Value, bound: &mut Bindings) -> bool {
    match (term, value) {
        // Patterns match texts regardless of case.
        (Term::Is(Value::Text(wanted)), Value::Text(text)) => wanted.eq_ignore_ascii_case(text),
        (Term::Is(wanted), _) => wanted == value,
        (Term::Variable(name), _) => bind(name, value, bound),
        (Term::Any, _) => true,
    }
}

/// Returns the bindings of both, or `None` if they give a variable different values.
pub(crate) fn joined(first: &Bindings, second: &Bindings) -> Option<Bindings> {
    let mut both = first.clone();
    second.iter().all(|(name, value)| bind(name, value, &mut both)).then_some(both)
}

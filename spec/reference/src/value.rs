//! Values, variables, and the matching of phrases.

use crate::program::{Span, Term};
use std::collections::BTreeMap;
use std::fmt;

/// A value of PDL, limited to those in random programs.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub enum Value {
    /// False, and the empty list.
    Nil,
    /// True, or any other symbol.
    Word(String),
    /// A number.
    Number(f64),
    /// A span of time in nanoseconds.
    Span(Span),
    /// A list.
    List(Vec<Value>),
    /// A task, by its number.
    Task(usize),
}

/// Variables and their values.
pub(crate) type Bindings = BTreeMap<String, Value>;

impl Value {
    /// Returns true for everything but nil and the empty list.
    pub(crate) fn is_true(&self) -> bool {
        *self != Value::Nil && *self != Value::List(Vec::new())
    }

    pub(crate) fn truth(truth: bool) -> Value {
        if truth { Value::Word("t".into()) } else { Value::Nil }
    }

    pub(crate) fn word(word: &str) -> Value {
        Value::Word(word.into())
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Nil => f.write_str("nil"),
            Value::Word(word) => f.write_str(word),
            Value::Number(number) => write!(f, "{number}"),
            Value::Span(span) => write!(f, "{span}ns"),
            Value::Task(task) => write!(f, "T{task}"),
            Value::List(items) => write!(f, "{}", phrase(items)),
        }
    }
}

/// Returns a phrase as in `(a b c)`.
pub(crate) fn phrase(words: &[Value]) -> String {
    let words: Vec<String> = words.iter().map(ToString::to_string).collect();
    format!("({})", words.join(" "))
}

/// Returns true if `pattern` matches the phrase. Existing values of variables are in `known`; new ones are added to `bound`.
pub(crate) fn matches(
    pattern: &[Term],
    words: &[Value],
    known: &dyn Fn(&str) -> Option<Value>,
    bound: &mut Bindings,
) -> bool {
    pattern.len() == words.len()
        && pattern.iter().zip(words).all(|(term, word)| match term {
            Term::Is(value) => value == word,
            Term::Anything => true,
            Term::Variable(name) => match bound.get(name).cloned().or_else(|| known(name)) {
                Some(value) => value == *word,
                None => {
                    bound.insert(name.clone(), word.clone());
                    true
                }
            },
        })
}

/// Returns the variables of both, if shared variables have the same values.
pub(crate) fn joined(left: &Bindings, right: &Bindings) -> Option<Bindings> {
    let agree = right.iter().all(|(name, value)| left.get(name).is_none_or(|other| other == value));
    agree.then(|| left.iter().chain(right).map(|(name, value)| (name.clone(), value.clone())).collect())
}

//! Variable bindings of a context: small, ordered by first binding, searched linearly. A single binding needs no allocation.

use apex_model::symbol::Symbol;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// Variables and their values, without tags.
pub(crate) type PlainBindings = Vec<(Symbol, Value)>;

/// Variables (named without `?`) and their values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bindings(SmallVec<[(Symbol, Value); 1]>);

impl Bindings {
    /// Returns empty bindings.
    pub fn new() -> Bindings {
        Bindings::default()
    }

    /// Returns the value of `name`.
    pub fn get(&self, name: &Symbol) -> Option<&Value> {
        self.0.iter().find(|(key, _)| key == name).map(|(_, value)| value)
    }

    /// Binds `name`, replacing an earlier value.
    pub fn set(&mut self, name: Symbol, value: Value) {
        match self.0.iter_mut().find(|(key, _)| *key == name) {
            Some((_, slot)) => *slot = value,
            None => self.0.push((name, value)),
        }
    }

    /// Removes the binding of `name`.
    pub fn remove(&mut self, name: &Symbol) {
        self.0.retain(|(key, _)| key != name);
    }

    /// Returns the pairs in order of first binding.
    pub fn iter(&self) -> impl Iterator<Item = (&Symbol, &Value)> {
        self.0.iter().map(|(name, value)| (name, value))
    }

    /// Returns the variables with their values, without tags, whose values are intervals.
    pub(crate) fn plain(&self) -> PlainBindings {
        let values = self.iter().filter(|(_, value)| !matches!(value, Value::Interval(..)));
        values.map(|(name, value)| (name.clone(), value.clone())).collect()
    }

    /// Returns the number of bound variables.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns true if there are no bindings.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Drops all bindings after the first `length`: undoes a failed branch of a match.
    pub fn truncate(&mut self, length: usize) {
        self.0.truncate(length);
    }
}

/// Returns the bindings of both, if they agree where both bind.
pub(crate) fn joined(left: &Bindings, right: &Bindings) -> Option<Bindings> {
    let mut all = left.clone();
    for (name, value) in right.iter() {
        match all.get(name) {
            Some(bound) if !bound.matches(value) => return None,
            Some(_) => {}
            None => all.set(name.clone(), value.clone()),
        }
    }
    Some(all)
}

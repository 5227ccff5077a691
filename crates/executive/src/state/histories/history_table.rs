//! The histories of state variables: found in constant time, listed in order.

use crate::state::histories::history::History;
use crate::state::histories::variable_map::VariableMap;
use apex_model::event::StateVariable;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use rustc_hash::FxBuildHasher;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::HashMap;

/// Histories by state variable.
#[derive(Clone, Debug, Default)]
pub(crate) struct HistoryTable {
    by_variable: VariableMap<Box<History>>,
    /// The objects of each attribute in order of their first samples. Few callers list them, so the list is sorted on request.
    objects: HashMap<Symbol, Vec<Value>, FxBuildHasher>,
}

impl HistoryTable {
    /// Returns the history of `variable`.
    pub(crate) fn get(&self, variable: &StateVariable) -> Option<&History> {
        self.by_variable.get(variable).map(|history| &**history)
    }

    /// Returns the history of `variable`, mutably.
    pub(crate) fn get_mut(&mut self, variable: &StateVariable) -> Option<&mut History> {
        self.by_variable.get_mut(variable).map(|history| &mut **history)
    }

    /// Adds the history of a variable that has none.
    pub(crate) fn insert(&mut self, variable: StateVariable, history: History) {
        match self.objects.get_mut(&variable.attribute) {
            Some(objects) => objects.push(variable.object.clone()),
            None => {
                self.objects.insert(variable.attribute.clone(), vec![variable.object.clone()]);
            }
        }
        self.by_variable.insert(variable, Box::new(history));
    }

    /// Returns all histories in order of their variables.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&StateVariable, &History)> {
        self.by_variable.sorted().into_iter().map(|(variable, history)| (variable, &**history))
    }

    /// Returns the histories of one attribute, in order of their objects.
    pub(crate) fn of_attribute(&self, attribute: &Symbol) -> impl Iterator<Item = (&StateVariable, &History)> {
        let mut objects: Vec<&Value> = self.objects.get(attribute).into_iter().flatten().collect();
        objects.sort_unstable();
        let attribute = attribute.clone();
        objects.into_iter().filter_map(move |object| {
            let variable = StateVariable { attribute: attribute.clone(), object: object.clone() };
            self.by_variable.get_with_key(&variable).map(|(variable, history)| (variable, &**history))
        })
    }

    /// Applies `change` to the history of each variable that satisfies `wanted`; the order must not matter.
    pub(crate) fn change(&mut self, wanted: impl Fn(&StateVariable) -> bool, mut change: impl FnMut(&mut History)) {
        for (variable, history) in self.by_variable.each_mut() {
            if wanted(variable) {
                change(history);
            }
        }
    }
}

/// The order of first samples is not part of the state, so equality ignores it.
impl PartialEq for HistoryTable {
    fn eq(&self, other: &HistoryTable) -> bool {
        self.by_variable == other.by_variable
    }
}

impl Serialize for HistoryTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.iter().collect::<Vec<_>>().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for HistoryTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<HistoryTable, D::Error> {
        let mut table = HistoryTable::default();
        for (variable, history) in Vec::<(StateVariable, History)>::deserialize(deserializer)? {
            table.insert(variable, history);
        }
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_are_listed_in_order_whatever_came_first() {
        let mut table = HistoryTable::default();
        let variable = |attribute: &str, object| StateVariable::new(Symbol::new(attribute), Value::Integer(object));
        for (attribute, object) in [("speed", 7), ("level", 9), ("speed", -2), ("level", 10), ("speed", 3)] {
            table.insert(variable(attribute, object), History::default());
        }
        let all: Vec<String> = table.iter().map(|(variable, _)| variable.to_string()).collect();
        assert_eq!(all, ["(level 9)", "(level 10)", "(speed -2)", "(speed 3)", "(speed 7)"]);
        let of = |name: &str| {
            table.of_attribute(&Symbol::new(name)).map(|(variable, _)| variable.to_string()).collect::<Vec<_>>()
        };
        assert_eq!(of("speed"), ["(speed -2)", "(speed 3)", "(speed 7)"]);
        assert_eq!(of("roll"), Vec::<String>::new());
        let mut changed = 0;
        table.change(|variable| variable.attribute == Symbol::new("level"), |_| changed += 1);
        assert_eq!(changed, 2);
    }

    #[test]
    fn equality_does_not_see_the_order_of_first_samples() {
        let (mut first, mut second) = (HistoryTable::default(), HistoryTable::default());
        let variable = |object| StateVariable::new(Symbol::new("level"), Value::Integer(object));
        for object in [1, 2] {
            first.insert(variable(object), History::default());
            second.insert(variable(3 - object), History::default());
        }
        assert_eq!(first, second);
    }
}

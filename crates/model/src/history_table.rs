//! The histories of state variables: found in constant time, listed in order.

use crate::event::StateVariable;
use crate::history::History;
use crate::symbol::Symbol;
use crate::value::Value;
use crate::variable_map::VariableMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeSet;

/// Histories by state variable.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct HistoryTable {
    by_variable: VariableMap<Box<History>>,
    order: BTreeSet<StateVariable>,
}

impl HistoryTable {
    /// The history of `variable`.
    pub(crate) fn get(&self, variable: &StateVariable) -> Option<&History> {
        self.by_variable.get(variable).map(|history| &**history)
    }

    /// The history of `variable`, to change it.
    pub(crate) fn get_mut(&mut self, variable: &StateVariable) -> Option<&mut History> {
        self.by_variable.get_mut(variable).map(|history| &mut **history)
    }

    /// Adds the history of a variable.
    pub(crate) fn insert(&mut self, variable: StateVariable, history: History) {
        self.order.insert(variable.clone());
        self.by_variable.insert(variable, Box::new(history));
    }

    /// All histories in order of their variables.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&StateVariable, &History)> {
        self.order.iter().filter_map(|variable| Some((variable, self.get(variable)?)))
    }

    /// The histories of one attribute, in order of their objects.
    pub(crate) fn of_attribute(&self, attribute: &Symbol) -> impl Iterator<Item = (&StateVariable, &History)> {
        // `Value::Integer(i64::MIN)` is the least value of the structural order.
        let first = StateVariable { attribute: attribute.clone(), object: Value::Integer(i64::MIN) };
        let attribute = attribute.clone();
        let variables = self.order.range(first..).take_while(move |variable| variable.attribute == attribute);
        variables.filter_map(|variable| Some((variable, self.get(variable)?)))
    }

    /// Lets `change` loose on the history of each variable that `wanted` names.
    pub(crate) fn change(&mut self, wanted: impl Fn(&StateVariable) -> bool, mut change: impl FnMut(&mut History)) {
        for variable in self.order.iter().filter(|variable| wanted(variable)) {
            if let Some(history) = self.by_variable.get_mut(variable) {
                change(history);
            }
        }
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

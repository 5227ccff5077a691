//! A map by state variable: constant-time access through a hash with a fixed seed; listed only in order of the variables.

use apex_model::event::StateVariable;
use rustc_hash::FxBuildHasher;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::HashMap;

/// Entries by state variable.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableMap<T>(HashMap<StateVariable, T, FxBuildHasher>);

impl<T> Default for VariableMap<T> {
    fn default() -> VariableMap<T> {
        VariableMap(HashMap::default())
    }
}

impl<T> VariableMap<T> {
    /// Returns the entry of `variable`.
    pub fn get(&self, variable: &StateVariable) -> Option<&T> {
        self.0.get(variable)
    }

    /// Returns the entry of `variable`, mutably.
    pub fn get_mut(&mut self, variable: &StateVariable) -> Option<&mut T> {
        self.0.get_mut(variable)
    }

    /// Returns the entry of `variable` with the stored variable.
    pub fn get_with_key(&self, variable: &StateVariable) -> Option<(&StateVariable, &T)> {
        self.0.get_key_value(variable)
    }

    /// Returns all entries, mutably, in arbitrary order; results must not depend on it.
    #[allow(clippy::iter_over_hash_type, reason = "separate changes of entries do not depend on their order")]
    pub fn each_mut(&mut self) -> impl Iterator<Item = (&StateVariable, &mut T)> {
        self.0.iter_mut()
    }

    /// Returns the entry of `variable`; creates it if it is missing.
    pub fn entry(&mut self, variable: &StateVariable) -> &mut T
    where
        T: Default,
    {
        self.0.entry(variable.clone()).or_default()
    }

    /// Adds or replaces an entry.
    pub fn insert(&mut self, variable: StateVariable, entry: T) {
        self.0.insert(variable, entry);
    }

    /// Takes an entry out.
    pub fn remove(&mut self, variable: &StateVariable) -> Option<T> {
        self.0.remove(variable)
    }

    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns true if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns all entries in order of the variables; sorts them.
    pub fn sorted(&self) -> Vec<(&StateVariable, &T)> {
        let mut entries: Vec<(&StateVariable, &T)> = self.0.iter().collect();
        entries.sort_by(|a, b| a.0.cmp(b.0));
        entries
    }
}

impl<T> FromIterator<(StateVariable, T)> for VariableMap<T> {
    fn from_iter<I: IntoIterator<Item = (StateVariable, T)>>(entries: I) -> VariableMap<T> {
        VariableMap(entries.into_iter().collect())
    }
}

impl<T: Serialize> Serialize for VariableMap<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.sorted())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for VariableMap<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<VariableMap<T>, D::Error> {
        Ok(Vec::<(StateVariable, T)>::deserialize(deserializer)?.into_iter().collect())
    }
}

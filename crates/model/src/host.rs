//! Host functions: pure functions of the host program that PDL calls by name (`pdl.md`, Forms).

use crate::symbol::Symbol;
use crate::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A host function: returns a value for its arguments, or an error message. It must be pure and deterministic, for replay.
pub type HostFunction = Arc<dyn Fn(&[Value]) -> Result<Value, String> + Send + Sync>;

/// Registered host functions by name, such as the geometry functions of `apex-geo` (`distance`, `bearing`, ..).
#[derive(Clone, Default)]
pub struct HostFunctions(BTreeMap<Symbol, HostFunction>);

impl HostFunctions {
    /// Adds or replaces the function called `name`.
    pub fn register(&mut self, name: &str, function: HostFunction) {
        self.0.insert(Symbol::new(name), function);
    }

    /// Returns the function called `name`.
    pub fn get(&self, name: &Symbol) -> Option<&HostFunction> {
        self.0.get(name)
    }

    /// Returns all names, in order.
    pub fn names(&self) -> impl Iterator<Item = &Symbol> {
        self.0.keys()
    }
}

impl std::fmt::Debug for HostFunctions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.0.keys()).finish()
    }
}

impl PartialEq for HostFunctions {
    /// The contents of functions cannot be compared: two lists are equal if their names are equal.
    fn eq(&self, other: &HostFunctions) -> bool {
        self.0.keys().eq(other.0.keys())
    }
}

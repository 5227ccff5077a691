//! A table by name, with hashing. A program may have a hundred thousand names in one procedure, and comparing texts in a tree would then
//! take most of the time of the check.
//!
//! It can only be searched by name; a caller that needs all names receives them in order, so that no message depends on a hash.

use rustc_hash::FxHashMap;
use std::hash::Hash;

/// A table that is looked up by key.
#[derive(Clone, Debug)]
pub(crate) struct Lookup<K, V>(FxHashMap<K, V>);

impl<K, V> Default for Lookup<K, V> {
    fn default() -> Lookup<K, V> {
        Lookup(FxHashMap::default())
    }
}

impl<K: Eq + Hash + Ord + Clone, V> Lookup<K, V> {
    /// Returns the entry of `key`.
    pub(crate) fn get(&self, key: &K) -> Option<&V> {
        // Empty tables are searched often, and hashing has a cost.
        if self.0.is_empty() { None } else { self.0.get(key) }
    }

    pub(crate) fn contains(&self, key: &K) -> bool {
        self.get(key).is_some()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Inserts `value` and returns the previous value.
    pub(crate) fn insert(&mut self, key: K, value: V) -> Option<V> {
        self.0.insert(key, value)
    }

    pub(crate) fn remove(&mut self, key: &K) {
        self.0.remove(key);
    }

    /// Returns the entry of `key`; inserts `new` if there is none.
    pub(crate) fn or_insert(&mut self, key: &K, new: V) -> &mut V {
        self.0.entry(key.clone()).or_insert(new)
    }

    /// Returns all entries in the order of the keys.
    pub(crate) fn in_order(&self) -> Vec<(&K, &V)> {
        let mut all: Vec<(&K, &V)> = self.0.iter().collect();
        all.sort_unstable_by(|one, other| one.0.cmp(other.0));
        all
    }

    /// Returns all keys in order.
    pub(crate) fn keys_in_order(&self) -> Vec<&K> {
        self.in_order().into_iter().map(|(key, _)| key).collect()
    }
}

impl<K: Eq + Hash, V> FromIterator<(K, V)> for Lookup<K, V> {
    fn from_iter<I: IntoIterator<Item = (K, V)>>(entries: I) -> Lookup<K, V> {
        Lookup(entries.into_iter().collect())
    }
}

//! Children of a task: numbers that are added in ascending order and removed in any order.

use apex_model::task::TaskId;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use smallvec::SmallVec;

/// Marks the slot of a removed child; no task number reaches this value.
const GONE: u64 = 1 << 63;

/// A set of tasks in order of creation. Two numbers take no extra space.
#[derive(Clone, Debug, Default)]
pub struct Children {
    /// Ascending, except for the mark.
    places: SmallVec<[u64; 2]>,
    gone: u32,
}

impl Children {
    /// Adds a child, unless it is there already.
    pub fn insert(&mut self, child: TaskId) {
        match self.place(child) {
            Ok(index) => {
                if let Some(place) = self.places.get_mut(index).filter(|place| **place & GONE != 0) {
                    *place = child.0;
                    self.gone -= 1;
                }
            }
            Err(index) => self.places.insert(index, child.0),
        }
    }

    /// Removes a child, if it is there. Constant time on average, plus the search.
    pub fn remove(&mut self, child: TaskId) {
        let Ok(index) = self.place(child) else { return };
        let Some(place) = self.places.get_mut(index).filter(|place| **place & GONE == 0) else { return };
        *place |= GONE;
        self.gone += 1;
        if self.gone as usize * 2 > self.places.len() {
            self.places.retain(|place| *place & GONE == 0);
            self.gone = 0;
        }
    }

    fn place(&self, child: TaskId) -> Result<usize, usize> {
        self.places.binary_search_by_key(&child.0, |place| place & !GONE)
    }

    /// Returns true if `child` is contained.
    pub fn contains(&self, child: TaskId) -> bool {
        self.place(child).is_ok_and(|index| self.places.get(index).is_some_and(|place| place & GONE == 0))
    }

    /// Removes all children.
    pub fn clear(&mut self) {
        *self = Children::default();
    }

    /// Returns the children in order of creation.
    pub fn iter(&self) -> impl Iterator<Item = TaskId> {
        self.places.iter().filter(|place| **place & GONE == 0).map(|place| TaskId(*place))
    }
}

impl PartialEq for Children {
    fn eq(&self, other: &Children) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Serialize for Children {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.iter().collect::<Vec<TaskId>>().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Children {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Children, D::Error> {
        let mut children = Children::default();
        Vec::deserialize(deserializer)?.into_iter().for_each(|child| children.insert(child));
        Ok(children)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};
    use std::collections::BTreeSet;

    #[test]
    fn agrees_with_an_ordered_set() {
        let (mut children, mut set) = (Children::default(), BTreeSet::new());
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        for round in 0..2_000_u64 {
            let child = TaskId(generator.next_u64() % 64);
            if round % 3 == 0 {
                children.remove(child);
                set.remove(&child);
            } else {
                children.insert(child);
                set.insert(child);
            }
            assert!(children.iter().eq(set.iter().copied()));
            assert_eq!(children.contains(child), set.contains(&child));
        }
    }
}

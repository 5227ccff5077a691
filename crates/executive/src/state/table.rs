//! A table indexed by counters: constant-time access, memory only for living entries.
//!
//! Numbers come from counters and are never reused, so the table is a directory of small pages that point into slots; a page is freed
//! with its last entry. There is no hashing, so no result depends on a seed. Two tables are equal, and are stored equally, if they
//! contain the same entries, whatever the arrangement of their slots.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Numbers of one page: few, so that one old entry keeps little memory allocated.
const PAGE: u64 = 64;
/// Marks a number without entry.
const VACANT: u32 = u32::MAX;

/// Entries of type `T` by number.
#[derive(Clone, Debug)]
pub struct Table<T> {
    pages: Vec<Option<Box<TablePage>>>,
    slots: Slots<T>,
    free: Vec<u32>,
    length: usize,
}

/// Slots in chunks of one size: no slot is moved when more are needed, and few are unused.
#[derive(Clone, Debug)]
struct Slots<T>(Vec<Vec<Option<T>>>);

/// Number of slots of one chunk.
const CHUNK: usize = 128;

impl<T> Slots<T> {
    #[inline]
    fn get(&self, slot: usize) -> Option<&T> {
        self.0.get(slot / CHUNK)?.get(slot % CHUNK)?.as_ref()
    }

    #[inline]
    fn place(&mut self, slot: usize) -> Option<&mut Option<T>> {
        self.0.get_mut(slot / CHUNK)?.get_mut(slot % CHUNK)
    }

    /// Adds an empty slot and returns its number.
    fn add(&mut self) -> u32 {
        if self.0.last().is_none_or(|chunk| chunk.len() == CHUNK) {
            self.0.push(Vec::with_capacity(CHUNK));
        }
        if let Some(chunk) = self.0.last_mut() {
            chunk.push(None);
        }
        u32::try_from(self.len() - 1).unwrap_or(VACANT)
    }

    fn len(&self) -> usize {
        self.0.last().map_or(0, |last| (self.0.len() - 1) * CHUNK + last.len())
    }
}

#[derive(Clone, Debug)]
struct TablePage {
    slots: [u32; PAGE as usize],
    used: u32,
}

impl<T> Default for Table<T> {
    fn default() -> Table<T> {
        Table { pages: Vec::new(), slots: Slots(Vec::new()), free: Vec::new(), length: 0 }
    }
}

#[inline]
fn split(number: u64) -> Option<(usize, usize)> {
    let page = usize::try_from(number / PAGE).ok()?;
    let offset = usize::try_from(number % PAGE).ok()?;
    Some((page, offset))
}

impl<T> Table<T> {
    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Returns true if there are no entries.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    #[inline]
    fn slot(&self, number: u64) -> Option<usize> {
        let (page, offset) = split(number)?;
        let slot = *self.pages.get(page)?.as_ref()?.slots.get(offset)?;
        (slot != VACANT).then_some(slot as usize)
    }

    /// Returns the entry with this number.
    #[inline]
    pub fn get(&self, number: u64) -> Option<&T> {
        self.slots.get(self.slot(number)?)
    }

    /// Returns the entry with this number, mutably.
    #[inline]
    pub fn get_mut(&mut self, number: u64) -> Option<&mut T> {
        let slot = self.slot(number)?;
        self.slots.place(slot)?.as_mut()
    }

    /// Returns true if an entry has this number.
    #[inline]
    pub fn contains(&self, number: u64) -> bool {
        self.slot(number).is_some()
    }

    /// Adds or replaces the entry with this number.
    pub fn insert(&mut self, number: u64, entry: T) {
        if let Some(slot) = self.get_mut(number) {
            *slot = entry;
            return;
        }
        let Some((page, offset)) = split(number) else { return };
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => self.slots.add(),
        };
        if self.pages.len() <= page {
            self.pages.resize_with(page + 1, || None);
        }
        if let Some(place) = self.pages.get_mut(page) {
            let page = place.get_or_insert_with(|| Box::new(TablePage { slots: [VACANT; PAGE as usize], used: 0 }));
            if let (Some(pointer), Some(room)) = (page.slots.get_mut(offset), self.slots.place(slot as usize)) {
                *pointer = slot;
                *room = Some(entry);
                page.used += 1;
                self.length += 1;
            }
        }
    }

    /// Takes the entry with this number out.
    pub fn remove(&mut self, number: u64) -> Option<T> {
        let slot = self.slot(number)?;
        let (page_index, offset) = split(number)?;
        let place = self.pages.get_mut(page_index)?;
        if let Some(page) = place {
            if let Some(pointer) = page.slots.get_mut(offset) {
                *pointer = VACANT;
            }
            page.used -= 1;
            if page.used == 0 {
                *place = None;
            }
        }
        self.length -= 1;
        self.free.push(u32::try_from(slot).unwrap_or(VACANT));
        self.slots.place(slot)?.take()
    }

    /// Takes the entry with this number out for a moment: its place stays reserved for [`Table::put`].
    pub fn lift(&mut self, number: u64) -> Option<T> {
        let slot = self.slot(number)?;
        self.slots.place(slot)?.take()
    }

    /// Puts a lifted entry back.
    pub fn put(&mut self, number: u64, entry: T) {
        if let Some(place) = self.slot(number).and_then(|slot| self.slots.place(slot)) {
            *place = Some(entry);
        }
    }

    /// Returns the entries in order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &T)> {
        self.pages.iter().zip(0_u64..).filter_map(|(page, index)| page.as_ref().map(|page| (page, index))).flat_map(
            move |(page, index)| {
                page.slots
                    .iter()
                    .zip(index * PAGE..)
                    .filter_map(move |(slot, number)| Some((number, self.slots.get(usize::try_from(*slot).ok()?)?)))
            },
        )
    }
}

impl<T: PartialEq> PartialEq for Table<T> {
    fn eq(&self, other: &Table<T>) -> bool {
        self.length == other.length && self.iter().eq(other.iter())
    }
}

impl<T: Serialize> Serialize for Table<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entries: Vec<(u64, &T)> = self.iter().collect();
        entries.serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Table<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Table<T>, D::Error> {
        let entries: Vec<(u64, T)> = Vec::deserialize(deserializer)?;
        let mut table = Table::default();
        for (number, entry) in entries {
            table.insert(number, entry);
        }
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_in_order_of_their_numbers_whatever_came_first() {
        let mut table = Table::default();
        for number in [700, 3, 64, 65] {
            table.insert(number, number * 10);
        }
        assert_eq!(table.remove(64), Some(640));
        table.insert(1, 10);
        assert_eq!(table.iter().collect::<Vec<_>>(), [(1, &10), (3, &30), (65, &650), (700, &7000)]);
        assert_eq!((table.get(64), table.len()), (None, 4));
    }

    #[test]
    fn equality_does_not_see_the_slots() {
        let mut first = Table::default();
        first.insert(1, 'a');
        first.insert(2, 'b');
        first.remove(1);
        first.insert(3, 'c');
        let mut second = Table::default();
        second.insert(3, 'c');
        second.insert(2, 'b');
        assert_eq!(first, second);
    }

    #[test]
    fn a_page_goes_with_its_last_entry() {
        let mut table = Table::default();
        for number in 0..1_000_u64 {
            table.insert(number, ());
            table.remove(number);
        }
        assert!(table.pages.iter().all(Option::is_none) && table.slots.len() == 1);
    }
}

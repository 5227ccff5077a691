//! The hash chain of a record: each group of rows that is committed together ends with a seal.
//!
//! A seal contains the number of rows of each table in the group, and SHA-256 over the preceding seal, its own columns and the digests of
//! the group's rows, table by table in the order of their keys. So a row cannot be changed, added, removed or moved without invalidating
//! a seal. Cells are hashed with the type that SQLite returns for them.

use super::tables::{ALL, TABLES};
use rusqlite::types::ValueRef;
use sha2::{Digest, Sha256};

/// SHA-256.
pub(super) type Hash = [u8; 32];

/// Begins every hashed text, so that a later layout cannot be mistaken for this one.
const MARK: &[u8] = b"apex record seal 1\0";

/// Position in a chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ChainPosition {
    /// Number of the last seal; 0 before the first.
    pub(super) id: i64,
    pub(super) chain: Hash,
}

/// A row of the table `seal`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Seal {
    pub(super) id: i64,
    /// Instant of the last batch.
    pub(super) t_ns: i64,
    /// Number of the last batch.
    pub(super) batch: i64,
    /// Rows of the group by table.
    pub(super) counts: [u64; TABLES],
    pub(super) chain: Hash,
}

/// Hashes the rows of one group.
#[derive(Clone, Default)]
pub(super) struct Sealer {
    digests: [Sha256; TABLES],
    pub(super) counts: [u64; TABLES],
    bytes: Vec<u8>,
}

impl Sealer {
    /// Takes in a row of the table with this index.
    pub(super) fn row<'c>(&mut self, table: usize, cells: impl IntoIterator<Item = ValueRef<'c>>) {
        self.bytes.clear();
        cells.into_iter().for_each(|cell| put_cell(&mut self.bytes, cell));
        if let (Some(digest), Some(count)) = (self.digests.get_mut(table), self.counts.get_mut(table)) {
            digest.update(&self.bytes);
            *count += 1;
        }
    }

    /// Forgets the rows since the last seal.
    pub(super) fn clear(&mut self) {
        *self = Sealer { bytes: std::mem::take(&mut self.bytes), ..Sealer::default() };
    }

    /// Returns true if the group has no row.
    pub(super) fn is_empty(&self) -> bool {
        self.counts.iter().all(|count| *count == 0)
    }

    /// Returns the seal of the rows, after the seal `before`; the sealer is empty again.
    pub(super) fn seal(&mut self, before: ChainPosition, t_ns: i64, batch: i64) -> Seal {
        let id = before.id + 1;
        let mut chain = Sha256::new();
        chain.update(MARK);
        chain.update(before.chain);
        for number in [id, t_ns, batch] {
            chain.update(number.to_le_bytes());
        }
        let counts = std::mem::take(&mut self.counts);
        for (index, (digest, count)) in self.digests.iter_mut().zip(counts).enumerate() {
            if count > 0 {
                chain.update((index as u64).to_le_bytes());
                chain.update(count.to_le_bytes());
                chain.update(digest.finalize_reset());
            }
        }
        Seal { id, t_ns, batch, counts, chain: chain.finalize().into() }
    }
}

/// Writes a cell as its type and its bytes. SQLite keeps neither a NaN nor the sign of zero.
fn put_cell(bytes: &mut Vec<u8>, cell: ValueRef<'_>) {
    let (kind, body): (u8, &[u8]) = match cell {
        ValueRef::Real(real) if !real.is_nan() => {
            bytes.push(2);
            bytes.extend_from_slice(&(if real == 0.0 { 0.0 } else { real }).to_le_bytes());
            return;
        }
        ValueRef::Null | ValueRef::Real(_) => {
            bytes.push(0);
            return;
        }
        ValueRef::Integer(number) => {
            bytes.push(1);
            bytes.extend_from_slice(&number.to_le_bytes());
            return;
        }
        ValueRef::Text(text) => (3, text),
        ValueRef::Blob(blob) => (4, blob),
    };
    bytes.push(kind);
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(body);
}

impl Seal {
    /// Returns the position in the chain after this seal.
    pub(super) fn link(&self) -> ChainPosition {
        ChainPosition { id: self.id, chain: self.chain }
    }

    /// Returns the counts in their stored form: index of the table and number of rows, for each table that has any.
    pub(super) fn count_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (index, count) in self.counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            bytes.push(index as u8);
            let mut rest = *count;
            while rest >= 0x80 {
                bytes.push((rest as u8) | 0x80);
                rest >>= 7;
            }
            bytes.push(rest as u8);
        }
        bytes
    }
}

/// Reads stored counts; `None` if they are malformed.
pub(super) fn counts_of(bytes: &[u8]) -> Option<[u64; TABLES]> {
    let mut counts = [0; TABLES];
    let mut rest = bytes.iter();
    while let Some(index) = rest.next() {
        let slot = counts.get_mut(usize::from(*index)).filter(|slot| **slot == 0)?;
        for shift in (0..63).step_by(7) {
            let byte = rest.next()?;
            *slot |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                break;
            }
        }
        if *slot == 0 {
            return None;
        }
    }
    debug_assert_eq!(ALL.len(), counts.len());
    Some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_come_back() {
        let mut counts = [0; TABLES];
        (counts[3], counts[5], counts[15]) = (1, 300, 1 << 40);
        let seal = Seal { id: 1, t_ns: 0, batch: 0, counts, chain: Hash::default() };
        assert_eq!(counts_of(&seal.count_bytes()), Some(counts));
        assert_eq!(counts_of(&[3]), None, "cut off");
        assert_eq!(counts_of(&[3, 1, 3, 1]), None, "the same table twice");
        assert_eq!(counts_of(&[200, 1]), None, "no such table");
        assert_eq!(counts_of(&[1, 0]), None, "no rows are not stored");
    }

    #[test]
    fn every_cell_and_its_place_count() {
        let seal = |rows: &[(usize, &[ValueRef<'_>])]| {
            let mut sealer = Sealer::default();
            rows.iter().for_each(|(table, cells)| sealer.row(*table, cells.iter().copied()));
            sealer.seal(ChainPosition::default(), 0, 0).chain
        };
        let (one, text) = (ValueRef::Integer(1), ValueRef::Text(b"1"));
        let chains = [
            seal(&[(0, &[one])]),
            seal(&[(0, &[text])]),
            seal(&[(0, &[ValueRef::Blob(b"1")])]),
            seal(&[(0, &[ValueRef::Real(1.0)])]),
            seal(&[(0, &[one, one])]),
            seal(&[(0, &[one]), (0, &[one])]),
            seal(&[(1, &[one])]),
            seal(&[(0, &[one]), (1, &[one])]),
            seal(&[]),
        ];
        let distinct: std::collections::BTreeSet<_> = chains.iter().collect();
        // The table determines a row's number of columns, so two cells may hash like two rows; the counts differ.
        assert_eq!(distinct.len(), chains.len());
        let stored = seal(&[(0, &[ValueRef::Null, ValueRef::Real(0.0)])]);
        assert_eq!(stored, seal(&[(0, &[ValueRef::Real(f64::NAN), ValueRef::Real(-0.0)])]), "as SQLite stores them");
    }
}

//! Rows that are not on the disk yet, in bounded memory: those of the open group, and after a failed write those of all later steps. The
//! record then continues at the point of failure, or, if memory was too small, with the newest steps after a gap.

use super::tables::{ALL, Table};
use rusqlite::types::ValueRef as Cell;
use std::collections::VecDeque;

/// Rows of whole steps, as bytes.
#[derive(Default)]
struct Chunk {
    bytes: Vec<u8>,
    steps: u64,
    /// Numbers of the first and last batch contained.
    batches: Option<(i64, i64)>,
}

/// Steps that were dropped because memory is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gap {
    pub(super) first_batch: i64,
    pub(super) last_batch: i64,
}

/// Rows in the order in which they were written.
pub(super) struct KeptRows {
    /// Rows of steps that must not be dropped: sources, variables, facts.
    lasting: Vec<u8>,
    /// All rows that every segment needs since the beginning, including committed ones: a new segment begins with them.
    ever_lasting: Vec<u8>,
    chunks: VecDeque<Chunk>,
    /// Rows since the last step ended.
    open: Chunk,
    bytes: usize,
    bytes_max: usize,
    gap: Option<Gap>,
    /// The open step alone is more than memory may hold: its rows are dropped.
    is_too_large: bool,
}

impl KeptRows {
    pub(super) fn new(bytes_max: usize) -> KeptRows {
        let (chunks, open) = (VecDeque::new(), Chunk::default());
        KeptRows {
            lasting: Vec::new(),
            ever_lasting: Vec::new(),
            chunks,
            open,
            bytes: 0,
            bytes_max,
            gap: None,
            is_too_large: false,
        }
    }

    /// Keeps a row.
    pub(super) fn row<'c>(&mut self, table: Table, cells: impl IntoIterator<Item = Cell<'c>>) {
        if self.is_too_large && !lasts(table) {
            return;
        }
        let before = self.open.bytes.len();
        let bytes = &mut self.open.bytes;
        bytes.push(table.index() as u8);
        let count = bytes.len();
        bytes.push(0);
        for (number, cell) in (1..).zip(cells) {
            if table == Table::Batch
                && number == 1
                && let Cell::Integer(batch) = cell
            {
                let first = self.open.batches.map_or(batch, |(first, _)| first);
                self.open.batches = Some((first, batch));
            }
            put(bytes, cell);
            if let Some(count) = bytes.get_mut(count) {
                *count = number;
            }
        }
        self.bytes += self.open.bytes.len() - before;
        if lasts(table) {
            self.ever_lasting.extend_from_slice(self.open.bytes.get(before..).unwrap_or_default());
        }
        if self.bytes > self.bytes_max {
            self.trim();
            if self.bytes > self.bytes_max && !self.is_too_large {
                self.is_too_large = true;
                let open = std::mem::take(&mut self.open);
                self.drop_chunk(&open);
            }
        }
    }

    /// Records the end of a step. With `apart`, the step can be dropped alone.
    pub(super) fn end_step(&mut self, apart: bool) {
        if std::mem::take(&mut self.is_too_large) {
            return;
        }
        self.open.steps += 1;
        if apart {
            self.chunks.push_back(std::mem::take(&mut self.open));
        }
    }

    /// Drops the oldest steps until the bound holds.
    fn trim(&mut self) {
        while self.bytes > self.bytes_max {
            let Some(chunk) = self.chunks.pop_front() else { return };
            self.drop_chunk(&chunk);
        }
    }

    fn drop_chunk(&mut self, chunk: &Chunk) {
        self.bytes -= chunk.bytes.len();
        let before = self.lasting.len();
        for (table, row) in rows(&chunk.bytes) {
            if lasts(table) {
                self.lasting.extend_from_slice(row);
            }
        }
        self.bytes += self.lasting.len() - before;
        if let Some((first, last)) = chunk.batches {
            let first_batch = self.gap.map_or(first, |gap| gap.first_batch);
            self.gap = Some(Gap { first_batch, last_batch: last });
        }
    }

    /// Calls `each` with every row, in order.
    pub(super) fn each<E>(&self, mut each: impl FnMut(Table, &[Cell<'_>]) -> Result<(), E>) -> Result<(), E> {
        let chunks = self.chunks.iter().map(|chunk| &chunk.bytes);
        let mut all = [&self.lasting].into_iter().chain(chunks).chain([&self.open.bytes]);
        all.try_for_each(|bytes| each_in(bytes, &mut each))
    }

    /// Calls `each` with the rows with which a new segment begins: all rows since the beginning that later steps need, and the other kept
    /// rows.
    pub(super) fn each_of_segment<E>(
        &self,
        mut each: impl FnMut(Table, &[Cell<'_>]) -> Result<(), E>,
    ) -> Result<(), E> {
        each_in(&self.ever_lasting, &mut each)?;
        let mut others = |table: Table, cells: &[Cell<'_>]| if lasts(table) { Ok(()) } else { each(table, cells) };
        let chunks = self.chunks.iter().map(|chunk| &chunk.bytes);
        chunks.chain([&self.open.bytes]).try_for_each(|bytes| each_in(bytes, &mut others))
    }

    /// Forgets all rows: they are on the disk.
    pub(super) fn clear(&mut self) {
        self.lasting.clear();
        self.chunks.clear();
        self.open.bytes.clear();
        (self.open.steps, self.open.batches) = (0, None);
        (self.bytes, self.gap, self.is_too_large) = (0, None, false);
    }

    /// Steps that are kept.
    pub(super) fn steps(&self) -> u64 {
        self.chunks.iter().map(|chunk| chunk.steps).sum::<u64>() + self.open.steps
    }

    /// Returns the steps that were dropped.
    pub(super) fn gap(&self) -> Option<Gap> {
        self.gap
    }
}

fn each_in<E>(bytes: &[u8], each: &mut impl FnMut(Table, &[Cell<'_>]) -> Result<(), E>) -> Result<(), E> {
    let mut cells = Vec::new();
    for (table, row) in rows(bytes) {
        cells.clear();
        get(row.get(2..).unwrap_or_default(), &mut cells);
        each(table, &cells)?;
    }
    Ok(())
}

/// True for rows without which later steps cannot be read.
pub(super) fn lasts(table: Table) -> bool {
    match table {
        Table::Meta
        | Table::Agent
        | Table::Source
        | Table::Variable
        | Table::Word
        | Table::Shape
        | Table::Target
        | Table::TargetState
        | Table::Report => true,
        Table::Batch
        | Table::Effects
        | Table::Note
        | Table::Snapshot
        | Table::Problem
        | Table::Answer
        | Table::Situation
        | Table::Track => false,
    }
}

fn put(bytes: &mut Vec<u8>, cell: Cell<'_>) {
    let (kind, body): (u8, &[u8]) = match cell {
        Cell::Null => return bytes.push(0),
        Cell::Integer(number) => {
            bytes.push(1);
            return bytes.extend_from_slice(&number.to_le_bytes());
        }
        Cell::Real(real) => {
            bytes.push(2);
            return bytes.extend_from_slice(&real.to_le_bytes());
        }
        Cell::Text(text) => (3, text),
        Cell::Blob(blob) => (4, blob),
    };
    bytes.push(kind);
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(body);
}

/// Reads one cell; also returns the remaining bytes.
fn take(bytes: &[u8]) -> Option<(Cell<'_>, &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    if *kind == 0 {
        return Some((Cell::Null, rest));
    }
    let (number, rest) = rest.split_first_chunk::<8>()?;
    if *kind == 1 {
        return Some((Cell::Integer(i64::from_le_bytes(*number)), rest));
    }
    if *kind == 2 {
        return Some((Cell::Real(f64::from_le_bytes(*number)), rest));
    }
    let (body, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*number)).ok()?)?;
    Some((if *kind == 3 { Cell::Text(body) } else { Cell::Blob(body) }, rest))
}

fn get<'b>(mut bytes: &'b [u8], cells: &mut Vec<Cell<'b>>) {
    while let Some((cell, rest)) = take(bytes) {
        cells.push(cell);
        bytes = rest;
    }
}

/// Returns the rows in `bytes`, each with its table.
fn rows(mut bytes: &[u8]) -> impl Iterator<Item = (Table, &[u8])> {
    std::iter::from_fn(move || {
        let [table, count, rest @ ..] = bytes else { return None };
        let mut rest = rest;
        for _ in 0..*count {
            rest = take(rest)?.1;
        }
        let (row, after) = bytes.split_at_checked(bytes.len() - rest.len())?;
        bytes = after;
        Some((*ALL.get(usize::from(*table))?, row))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(kept: &KeptRows) -> Vec<String> {
        let mut all = Vec::new();
        let shown = kept.each(|table, cells| {
            all.push(format!("{} {cells:?}", table.name()));
            Ok::<(), ()>(())
        });
        shown.unwrap();
        all
    }

    #[test]
    fn rows_come_back_in_order() {
        let mut kept = KeptRows::new(1 << 20);
        let cells = [Cell::Integer(7), Cell::Null, Cell::Real(0.5), Cell::Text(b"a"), Cell::Blob(&[0; 300])];
        kept.row(Table::Batch, cells);
        kept.end_step(true);
        kept.row(Table::Note, [Cell::Text(b"")]);
        let expected = [format!("batch {cells:?}"), format!("note {:?}", [Cell::Text(b"")])];
        assert_eq!((shown(&kept), kept.steps(), kept.gap()), (expected.to_vec(), 1, None));
        kept.clear();
        assert_eq!((shown(&kept).len(), kept.steps()), (0, 0));
    }

    #[test]
    fn the_oldest_steps_are_dropped_and_what_later_ones_need_stays() {
        let mut kept = KeptRows::new(2_000);
        for batch in 1..=40 {
            if batch == 3 {
                kept.row(Table::Variable, [Cell::Integer(1)]);
            }
            kept.row(Table::Batch, [Cell::Integer(batch), Cell::Blob(&[1; 200])]);
            kept.end_step(true);
        }
        let gap = kept.gap().unwrap();
        let all = shown(&kept);
        assert_eq!((gap.first_batch, gap.last_batch + kept.steps() as i64), (1, 40));
        assert!(all[0].starts_with("variable") && all.len() as u64 == kept.steps() + 1, "{all:?}");
        assert!((5..=9).contains(&kept.steps()), "{}", kept.steps());
    }

    #[test]
    fn a_step_that_is_too_large_is_dropped_whole() {
        let mut kept = KeptRows::new(2_000);
        kept.row(Table::Batch, [Cell::Integer(1)]);
        kept.end_step(false);
        kept.row(Table::Batch, [Cell::Integer(2)]);
        for effect in 1..100 {
            kept.row(Table::Effects, [Cell::Integer(effect), Cell::Blob(&[1; 200])]);
        }
        kept.end_step(false);
        kept.row(Table::Batch, [Cell::Integer(3)]);
        kept.end_step(false);
        assert_eq!(kept.gap(), Some(Gap { first_batch: 1, last_batch: 2 }));
        assert_eq!(shown(&kept), ["batch [Integer(3)]"]);
    }
}

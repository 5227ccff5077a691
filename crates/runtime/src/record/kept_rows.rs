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
    /// Instant of the last batch.
    at_ns: i64,
}

/// Steps that were dropped because memory is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gap {
    pub(super) first_batch: i64,
    pub(super) last_batch: i64,
}

/// The oldest rows that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct KeptPart {
    chunks: usize,
    /// Number and instant of its last batch; `None` without one.
    pub(super) last: Option<(i64, i64)>,
}

/// Rows in the order in which they were written.
pub(super) struct KeptRows {
    /// Rows of steps that must not be dropped: sources, variables, facts.
    lasting: Vec<u8>,
    /// All rows that every segment needs since the beginning, including committed ones: a new segment begins with them.
    ever_lasting: Vec<u8>,
    /// Number of bytes of `ever_lasting` that are committed.
    committed: usize,
    chunks: VecDeque<Chunk>,
    /// Rows since the last step ended.
    open: Chunk,
    bytes: usize,
    bytes_max: usize,
    gap: Option<Gap>,
    /// True if the open step alone exceeds the memory bound: its rows are dropped.
    is_too_large: bool,
}

impl KeptRows {
    pub(super) fn new(bytes_max: usize) -> KeptRows {
        let (chunks, open) = (VecDeque::new(), Chunk::default());
        KeptRows {
            lasting: Vec::new(),
            ever_lasting: Vec::new(),
            committed: 0,
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
            match (table, number, cell) {
                (Table::Batch, 1, Cell::Integer(batch)) => {
                    let first = self.open.batches.map_or(batch, |(first, _)| first);
                    self.open.batches = Some((first, batch));
                }
                (Table::Batch, 2, Cell::Integer(at_ns)) => self.open.at_ns = at_ns,
                _ => {}
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

    /// Returns the oldest rows that are stored together: whole steps of about `bytes`. `None` if nothing is kept.
    pub(super) fn part(&self, bytes: usize) -> Option<KeptPart> {
        let mut part = KeptPart { chunks: 0, last: None };
        let mut sum = 0;
        for chunk in self.chunks.iter().chain([&self.open]) {
            if part.chunks > 0 && sum + chunk.bytes.len() > bytes {
                break;
            }
            sum += chunk.bytes.len();
            part.chunks += 1;
            part.last = chunk.batches.map(|(_, batch)| (batch, chunk.at_ns)).or(part.last);
        }
        (sum > 0 || !self.lasting.is_empty() || self.gap.is_some()).then_some(part)
    }

    /// Calls `each` with every row of a part, in order.
    pub(super) fn each<E>(
        &self,
        part: &KeptPart,
        mut each: impl FnMut(Table, &[Cell<'_>]) -> Result<(), E>,
    ) -> Result<(), E> {
        let chunks = self.chunks.iter().chain([&self.open]).take(part.chunks).map(|chunk| &chunk.bytes);
        [&self.lasting].into_iter().chain(chunks).try_for_each(|bytes| each_in(bytes, &mut each))
    }

    /// Calls `each` with the committed rows without which later steps cannot be read: a new segment begins with them.
    pub(super) fn each_committed<E>(&self, mut each: impl FnMut(Table, &[Cell<'_>]) -> Result<(), E>) -> Result<(), E> {
        each_in(self.ever_lasting.get(..self.committed).unwrap_or_default(), &mut each)
    }

    /// Gives the facts that are kept higher positions, so that `count` facts can be stored before them. Returns the first free position;
    /// `None` if no fact is kept.
    pub(super) fn make_way(&mut self, count: i64) -> Option<i64> {
        let KeptRows { lasting, ever_lasting, chunks, open, committed, .. } = self;
        let chunks = chunks.iter_mut().chain([open]).map(|chunk| &mut chunk.bytes[..]);
        let copies = ever_lasting.get_mut(*committed..).into_iter();
        let all = [&mut lasting[..]].into_iter().chain(chunks).chain(copies);
        all.filter_map(|bytes| move_facts(bytes, count)).min()
    }

    /// Forgets a part, which is on the disk.
    pub(super) fn stored(&mut self, part: &KeptPart) {
        let lasting = std::mem::take(&mut self.lasting);
        (self.bytes, self.committed) = (self.bytes - lasting.len(), self.committed + lasting.len());
        self.gap = None;
        let whole = part.chunks.min(self.chunks.len());
        let mut stored: Vec<Chunk> = self.chunks.drain(..whole).collect();
        if part.chunks > whole {
            stored.push(std::mem::take(&mut self.open));
        }
        for chunk in stored {
            self.bytes -= chunk.bytes.len();
            let lasting = rows(&chunk.bytes).filter(|(table, _)| lasts(*table));
            self.committed += lasting.map(|(_, row)| row.len()).sum::<usize>();
        }
    }

    /// Forgets all rows: they are on the disk.
    pub(super) fn clear(&mut self) {
        self.lasting.clear();
        self.chunks.clear();
        self.open.bytes.clear();
        (self.open.steps, self.open.batches) = (0, None);
        (self.bytes, self.gap, self.is_too_large) = (0, None, false);
        self.committed = self.ever_lasting.len();
    }

    /// Returns the number of steps that are kept.
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

/// Adds `count` to the positions of the facts in `bytes`; returns the first one as it was.
fn move_facts(bytes: &mut [u8], count: i64) -> Option<i64> {
    let facts: Vec<usize> = rows(bytes)
        .scan(0, |end, (table, row)| {
            let begin = *end;
            *end += row.len();
            Some((table, begin))
        })
        .filter_map(|(table, begin)| (table == Table::Meta).then_some(begin))
        .collect();
    let mut first = None;
    for begin in facts {
        // After the table, the number of cells and the kind of the first cell.
        let position = bytes.get_mut(begin + 3..).and_then(|rest| rest.first_chunk_mut::<8>());
        if let Some(position) = position {
            let before = i64::from_le_bytes(*position);
            first.get_or_insert(before);
            *position = (before + count).to_le_bytes();
        }
    }
    first
}

pub(super) fn put(bytes: &mut Vec<u8>, cell: Cell<'_>) {
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

pub(super) fn get<'b>(mut bytes: &'b [u8], cells: &mut Vec<Cell<'b>>) {
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
        let part = kept.part(usize::MAX).unwrap_or(KeptPart { chunks: 0, last: None });
        shown_of(kept, &part)
    }

    fn shown_of(kept: &KeptRows, part: &KeptPart) -> Vec<String> {
        let mut all = Vec::new();
        let shown = kept.each(part, |table, cells| {
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
    fn parts_are_whole_steps_in_order() {
        let mut kept = KeptRows::new(1 << 20);
        kept.row(Table::Source, [Cell::Integer(1)]);
        kept.clear();
        for batch in 1..=10 {
            kept.row(Table::Batch, [Cell::Integer(batch), Cell::Integer(batch * 100), Cell::Blob(&[1; 200])]);
            if batch == 2 {
                kept.row(Table::Word, [Cell::Integer(1)]);
            }
            kept.end_step(true);
        }
        let whole = shown(&kept);
        let mut parts = Vec::new();
        let mut lasts = Vec::new();
        while let Some(part) = kept.part(500) {
            parts.extend(shown_of(&kept, &part));
            lasts.push(part.last);
            kept.stored(&part);
            let mut committed = Vec::new();
            kept.each_committed(|table, _| {
                committed.push(table);
                Ok::<(), ()>(())
            })
            .unwrap();
            assert_eq!(committed, [Table::Source, Table::Word], "after {part:?}");
        }
        assert_eq!((parts, kept.bytes, kept.steps()), (whole, 0, 0));
        assert_eq!(lasts, [2, 4, 6, 8, 10].map(|batch| Some((batch, batch * 100))));
    }

    #[test]
    fn kept_facts_make_way_for_others() {
        let mut kept = KeptRows::new(1 << 20);
        kept.row(Table::Meta, [Cell::Integer(1), Cell::Text(b"mission")]);
        kept.clear();
        assert_eq!(kept.make_way(2), None);
        kept.row(Table::Note, [Cell::Integer(9)]);
        kept.row(Table::Meta, [Cell::Integer(2), Cell::Text(b"end_ns")]);
        kept.row(Table::Meta, [Cell::Integer(3), Cell::Text(b"complete")]);
        assert_eq!(kept.make_way(2), Some(2));
        let meta = |position, key: &'static [u8]| format!("meta {:?}", [Cell::Integer(position), Cell::Text(key)]);
        let note = format!("note {:?}", [Cell::Integer(9)]);
        assert_eq!(shown(&kept), [note, meta(4, b"end_ns"), meta(5, b"complete")]);
        kept.clear();
        let mut committed = Vec::new();
        kept.each_committed(|table, cells| {
            committed.push(format!("{} {cells:?}", table.name()));
            Ok::<(), ()>(())
        })
        .unwrap();
        assert_eq!(committed, [meta(1, b"mission"), meta(4, b"end_ns"), meta(5, b"complete")]);
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

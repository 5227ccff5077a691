//! The writer of effects: each is the number of its shape, a bit for each value that differs from the expected one, and the differences.
//! The expected value is that of the preceding effect of the same shape; at the beginning of a block that of the shape's example; for the
//! first task of an effect the task of the preceding effect.
//!
//! A shape or word gets a number at its second occurrence, so texts that occur once do not fill the tables. Bound: proportional to the
//! bytes of the effects. The tables have a largest size; beyond it effects are stored as postcard.

use super::BLOCK_EFFECTS;
use super::splitter::{Hole, Parts, holes_of};
use crate::record::numbers::{put_signed, put_unsigned};
use crate::record::store::{SqlValue, text};
use crate::record::tables::Table;
use apex_model::effect::Effect;
use apex_model::time::Time;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Largest numbers of shapes and of words.
const SHAPES_MAX: usize = 4_096;
const WORDS_MAX: usize = 1 << 16;
/// Maximum number of bytes of a word.
const WORD_BYTES_MAX: usize = 200;
/// Maximum number of texts and shapes that are remembered until they occur again.
const SIGHTINGS_MAX: usize = 1 << 14;

/// Writes the effects of one record.
#[derive(Default)]
pub(in crate::record) struct EffectEncoder {
    words: Words,
    shapes: Vec<NumberedShape>,
    /// By layout: the place in `shapes`.
    numbers: BTreeMap<Vec<u8>, usize>,
    sightings: Sightings,
    parts: Parts,
    /// Number of the block that is being written.
    block: u64,
    stored_words: usize,
    stored_shapes: usize,
}

/// A shape with its number and the expected values.
struct NumberedShape {
    layout: Vec<u8>,
    holes: Vec<Hole>,
    /// The values that are expected at the beginning of a block: numbers as 64 bits, of texts the number of the word.
    example: Vec<u64>,
    last: Vec<u64>,
    /// The block in which `last` was written.
    block: u64,
    /// Place of the shape that came next the last time.
    successor: usize,
}

/// Words by number, from 1.
#[derive(Default)]
struct Words {
    list: Vec<Arc<str>>,
    numbers: BTreeMap<Arc<str>, u64>,
    sightings: Sightings,
}

/// Hashes of words and shapes that have occurred once.
#[derive(Default)]
struct Sightings(BTreeSet<u64>);

impl Sightings {
    /// Returns true if the bytes have occurred before.
    fn is_second(&mut self, bytes: &[u8]) -> bool {
        // Fowler-Noll-Vo hash (FNV-1a). A collision gives the bytes a number too early, which is harmless.
        let hash = bytes
            .iter()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
        if self.0.remove(&hash) {
            return true;
        }
        if self.0.len() >= SIGHTINGS_MAX {
            self.0.clear();
        }
        self.0.insert(hash);
        false
    }
}

impl Words {
    /// Returns the word with this number, from 1.
    fn get(&self, number: u64) -> Option<&str> {
        let place = usize::try_from(number.checked_sub(1)?).ok()?;
        self.list.get(place).map(|word| &**word)
    }

    /// Returns the number of `text`; 0 if it has none.
    fn number(&mut self, text: &str) -> u64 {
        if let Some(number) = self.numbers.get(text) {
            return *number;
        }
        let is_kept =
            text.len() <= WORD_BYTES_MAX && self.list.len() < WORDS_MAX && self.sightings.is_second(text.as_bytes());
        if !is_kept {
            return 0;
        }
        let word: Arc<str> = Arc::from(text);
        self.list.push(Arc::clone(&word));
        self.numbers.insert(word, self.list.len() as u64);
        self.list.len() as u64
    }
}

/// State while one row of effects is written.
#[derive(Default)]
struct RowState {
    written: usize,
    /// The task of the effect before.
    task: u64,
    /// Place of the shape before.
    before: Option<usize>,
}

impl EffectEncoder {
    /// Gives `insert` the rows of words and shapes that are new since the last call.
    pub(in crate::record) fn new_rows<E>(
        &mut self,
        mut insert: impl FnMut(Table, &[SqlValue<'_>]) -> Result<(), E>,
    ) -> Result<(), E> {
        for (number, word) in (1..).zip(&self.words.list).skip(self.stored_words) {
            insert(Table::Word, &[SqlValue::Integer(number), text(Some(word))])?;
        }
        self.stored_words = self.words.list.len();
        let mut example = Vec::new();
        for (number, shape) in (1..).zip(&self.shapes).skip(self.stored_shapes) {
            example.clear();
            shape.example.iter().for_each(|value| put_unsigned(&mut example, *value));
            insert(
                Table::Shape,
                &[SqlValue::Integer(number), SqlValue::Blob(&shape.layout), SqlValue::Blob(&example)],
            )?;
        }
        self.stored_shapes = self.shapes.len();
        Ok(())
    }

    /// Writes the effects of a step at `now` into `bytes` (cleared first).
    ///
    /// # Errors
    /// Postcard's, for an effect that cannot be turned into bytes.
    pub(in crate::record) fn encode(
        &mut self,
        now: Time,
        effects: &[Effect],
        bytes: &mut Vec<u8>,
    ) -> Result<(), postcard::Error> {
        bytes.clear();
        let mut row = RowState::default();
        for effect in effects {
            if row.written.is_multiple_of(BLOCK_EFFECTS) {
                self.block += 1;
                row.task = 0;
            }
            row.written += 1;
            let place = if self.parts.split(now, effect) { self.place(row.before) } else { None };
            if let Some(place) = place {
                put_unsigned(bytes, place as u64 + 1);
                self.write(place, &mut row, bytes);
                row.before = Some(place);
            } else {
                let body = postcard::to_stdvec(effect)?;
                put_unsigned(bytes, 0);
                put_unsigned(bytes, body.len() as u64);
                bytes.extend_from_slice(&body);
            }
        }
        Ok(())
    }

    /// Returns the index of the shape of the parts; `None` if it has no number.
    fn place(&mut self, before: Option<usize>) -> Option<usize> {
        let layout = &self.parts.shape;
        let guess = before.and_then(|before| self.shapes.get(before)).map(|shape| shape.successor);
        if let Some(guess) = guess
            && self.shapes.get(guess).is_some_and(|shape| shape.layout == *layout)
        {
            return Some(guess);
        }
        let place = match self.numbers.get(layout) {
            Some(place) => *place,
            None => self.admit()?,
        };
        if let Some(shape) = before.and_then(|before| self.shapes.get_mut(before)) {
            shape.successor = place;
        }
        Some(place)
    }

    /// Numbers the shape of the parts if it has occurred before.
    fn admit(&mut self) -> Option<usize> {
        let layout = &self.parts.shape;
        if self.shapes.len() >= SHAPES_MAX || !self.sightings.is_second(layout) {
            // Its words have occurred once now.
            let mut from = 0;
            for (hole, value) in holes_of(layout)?.iter().zip(&self.parts.values) {
                if *hole == Hole::Text {
                    let end = *value as usize;
                    self.words.number(self.parts.texts.get(from..end).unwrap_or_default());
                    from = end;
                }
            }
            return None;
        }
        let holes = holes_of(layout)?;
        let mut from = 0;
        let mut example = Vec::with_capacity(holes.len());
        for (hole, value) in holes.iter().zip(&self.parts.values) {
            example.push(if *hole == Hole::Text {
                let end = *value as usize;
                let text = self.parts.texts.get(from..end).unwrap_or_default();
                from = end;
                self.words.number(text)
            } else {
                *value
            });
        }
        let place = self.shapes.len();
        let last = example.clone();
        self.numbers.insert(layout.clone(), place);
        self.shapes.push(NumberedShape { layout: layout.clone(), holes, example, last, block: 0, successor: place });
        Some(place)
    }

    /// Writes the values of the parts.
    fn write(&mut self, place: usize, row: &mut RowState, bytes: &mut Vec<u8>) {
        let Some(shape) = self.shapes.get_mut(place) else { return };
        if shape.block != self.block {
            shape.block = self.block;
            shape.last.clone_from(&shape.example);
        }
        let marks = bytes.len();
        bytes.resize(marks + shape.holes.len().div_ceil(8), 0);
        let (mut from, mut is_first_task) = (0, true);
        let holes = shape.holes.iter().zip(&mut shape.last).zip(&self.parts.values);
        for (number, ((hole, last), value)) in holes.enumerate() {
            let before = bytes.len();
            match hole {
                Hole::Text => {
                    let end = *value as usize;
                    let text = self.parts.texts.get(from..end).unwrap_or_default();
                    from = end;
                    if self.words.get(*last) == Some(text) {
                        continue;
                    }
                    *last = self.words.number(text);
                    put_unsigned(bytes, *last);
                    if *last == 0 {
                        put_unsigned(bytes, text.len() as u64);
                        bytes.extend_from_slice(text.as_bytes());
                    }
                }
                Hole::Real => {
                    if *last != *value {
                        bytes.extend_from_slice(&value.to_le_bytes());
                    }
                    *last = *value;
                }
                Hole::Task | Hole::Instant | Hole::Unsigned | Hole::Signed => {
                    let is_task = *hole == Hole::Task && std::mem::take(&mut is_first_task);
                    let expected = if is_task { std::mem::replace(&mut row.task, *value) } else { *last };
                    if expected != *value {
                        put_signed(bytes, value.wrapping_sub(expected).cast_signed());
                    }
                    *last = *value;
                }
            }
            if bytes.len() > before
                && let Some(byte) = bytes.get_mut(marks + number / 8)
            {
                *byte |= 1 << (number % 8);
            }
        }
    }
}

//! The reader of effects: decodes a row of bytes into one effect after the other. It ends for any bytes, with effects or with an error.

use super::BLOCK_EFFECTS;
use super::kind::EffectKind;
use super::splitter::{Filling, Hole, holes_of, join};
use crate::record::numbers::Input;
use apex_model::effect::Effect;
use apex_model::time::Time;
use rusqlite::Connection;
use std::sync::Arc;

/// The words and shapes of a record.
#[derive(Default)]
pub(in crate::record) struct Dictionary {
    words: Vec<Arc<str>>,
    shapes: Vec<KnownShape>,
    /// The text used where a shape's example has none.
    nothing: Arc<str>,
}

/// A stored shape.
struct KnownShape {
    layout: Vec<u8>,
    holes: Vec<Hole>,
    example: Vec<Filling>,
    /// Kind of all of its effects.
    kind: EffectKind,
}

impl Dictionary {
    /// Reads the words and shapes that are new since the last call.
    pub(in crate::record) fn refresh(&mut self, connection: &Connection) -> rusqlite::Result<Result<(), String>> {
        let mut statement = connection.prepare_cached("SELECT id, text FROM word WHERE id > ?1 ORDER BY id")?;
        let mut rows = statement.query([self.words.len() as i64])?;
        while let Some(row) = rows.next()? {
            let id: i64 = row.get(0)?;
            if id != self.words.len() as i64 + 1 {
                return Ok(Err(format!("word {} of its effects is missing", self.words.len() + 1)));
            }
            self.words.push(Arc::from(row.get_ref(1)?.as_str()?));
        }
        let mut statement =
            connection.prepare_cached("SELECT id, layout, example FROM shape WHERE id > ?1 ORDER BY id")?;
        let mut rows = statement.query([self.shapes.len() as i64])?;
        while let Some(row) = rows.next()? {
            let id: i64 = row.get(0)?;
            if id != self.shapes.len() as i64 + 1 {
                return Ok(Err(format!("shape {} of its effects is missing", self.shapes.len() + 1)));
            }
            let added = self.add_shape(row.get(1)?, row.get_ref(2)?.as_blob()?);
            if let Err(fault) = added {
                return Ok(Err(format!("shape {} of its effects is garbled: {fault}", self.shapes.len() + 1)));
            }
        }
        Ok(Ok(()))
    }

    /// Adds a word under the number that the encoder gave it.
    #[cfg(test)]
    pub(super) fn add_word(&mut self, word: &str) {
        self.words.push(Arc::from(word));
    }

    pub(super) fn add_shape(&mut self, layout: Vec<u8>, example: &[u8]) -> Result<(), String> {
        let holes = holes_of(&layout).ok_or("its layout is not one")?;
        let mut input = Input { bytes: example };
        let mut fillings = Vec::with_capacity(holes.len());
        for hole in &holes {
            let value = input.unsigned()?;
            fillings.push(match (hole, value) {
                (Hole::Text, 0) => Filling::Text(Arc::clone(&self.nothing)),
                (Hole::Text, number) => Filling::Text(self.word(number)?),
                _ => Filling::Number(value),
            });
        }
        if !input.bytes.is_empty() {
            return Err("bytes are left over".into());
        }
        let mut body = Vec::new();
        join(Time::ZERO, &layout, fillings.iter(), &mut body);
        let effect: Effect =
            postcard::from_bytes(&body).map_err(|error| format!("its example is not an effect ({error})"))?;
        let kind = EffectKind::of(&effect);
        self.shapes.push(KnownShape { layout, holes, example: fillings, kind });
        Ok(())
    }

    fn word(&self, number: u64) -> Result<Arc<str>, String> {
        let place = number.checked_sub(1).and_then(|place| usize::try_from(place).ok());
        let word = place.and_then(|place| self.words.get(place));
        word.map(Arc::clone).ok_or_else(|| format!("word {number} is not known"))
    }
}

/// The effect that was read last.
pub(in crate::record) struct Item<'r> {
    now: Time,
    content: Content<'r>,
}

enum Content<'r> {
    Shaped { place: usize, shape: &'r KnownShape, values: &'r [Filling], task: u64 },
    Stored(&'r [u8]),
}

impl Item<'_> {
    /// Returns the effect in postcard.
    pub(in crate::record) fn body(&self) -> Vec<u8> {
        match &self.content {
            Content::Shaped { shape, values, .. } => {
                let mut bytes = Vec::with_capacity(shape.layout.len());
                join(self.now, &shape.layout, values.iter(), &mut bytes);
                bytes
            }
            Content::Stored(bytes) => bytes.to_vec(),
        }
    }

    /// Returns the effect.
    pub(in crate::record) fn effect(&self) -> Result<Effect, String> {
        let garbled = |error| format!("an effect is garbled ({error})");
        match &self.content {
            Content::Shaped { .. } => postcard::from_bytes(&self.body()).map_err(garbled),
            Content::Stored(bytes) => postcard::from_bytes(bytes).map_err(garbled),
        }
    }

    /// Returns the place of its shape among the shapes; `None` without one.
    pub(super) fn shape(&self) -> Option<usize> {
        match &self.content {
            Content::Shaped { place, .. } => Some(*place),
            Content::Stored(_) => None,
        }
    }

    /// Writes a signature of the effect: effects with equal signatures are equal, whatever their instants. Returns false for an effect that
    /// has no signature: one without a shape, or with an instant among its values.
    pub(in crate::record) fn signature(&self, bytes: &mut Vec<u8>) -> bool {
        let Content::Shaped { place, shape, values, .. } = &self.content else { return false };
        bytes.clear();
        bytes.extend_from_slice(&place.to_le_bytes());
        for (hole, value) in shape.holes.iter().zip(*values) {
            match value {
                Filling::Number(_) if *hole == Hole::Instant => return false,
                Filling::Number(number) => bytes.extend_from_slice(&number.to_le_bytes()),
                Filling::Text(text) => {
                    bytes.extend_from_slice(&text.len().to_le_bytes());
                    bytes.extend_from_slice(text.as_bytes());
                }
            }
        }
        true
    }

    /// Returns its kind and the task that it is about.
    pub(super) fn kind(&self) -> Result<(EffectKind, Option<u64>), String> {
        match &self.content {
            Content::Shaped { shape, task, .. } => Ok((shape.kind, shape.kind.has_task.then_some(*task))),
            Content::Stored(_) => {
                let effect = self.effect()?;
                Ok((EffectKind::of(&effect), EffectKind::task_of(&effect).map(|task| task.0)))
            }
        }
    }
}

/// Reads effects, row after row.
pub(in crate::record) struct EffectReader<'d, 'b> {
    dictionary: &'d Dictionary,
    now: Time,
    input: Input<'b>,
    count: usize,
    task: u64,
    memory: Memory,
}

/// The values that the last effect of each shape had.
#[derive(Default)]
pub(super) struct Memory {
    /// Number of the block that is being read.
    block: u64,
    /// By shape: the block in which its values were read, and the values.
    last: Vec<(u64, Vec<Filling>)>,
}

impl<'d, 'b> EffectReader<'d, 'b> {
    /// Returns a reader of the row `bytes` of a step at `now`.
    pub(in crate::record) fn new(dictionary: &'d Dictionary, now: Time, bytes: &'b [u8]) -> EffectReader<'d, 'b> {
        EffectReader::within(dictionary, now, bytes, 0)
    }

    /// Returns a reader that begins `offset` bytes after the row's begin, where a block begins.
    pub(in crate::record) fn within(
        dictionary: &'d Dictionary,
        now: Time,
        bytes: &'b [u8],
        offset: usize,
    ) -> EffectReader<'d, 'b> {
        let input = Input { bytes: bytes.get(offset..).unwrap_or_default() };
        EffectReader { dictionary, now, input, count: 0, task: 0, memory: Memory::default() }
    }

    /// Returns a reader of a row that continues with the memory of another reader.
    pub(super) fn in_memory(
        dictionary: &'d Dictionary,
        now: Time,
        bytes: &'b [u8],
        memory: Memory,
    ) -> EffectReader<'d, 'b> {
        EffectReader { dictionary, now, input: Input { bytes }, count: 0, task: 0, memory }
    }

    /// Returns the memory of a reader that is not needed any longer.
    pub(super) fn memory(self) -> Memory {
        self.memory
    }

    /// Returns bytes that are still to be read.
    pub(super) fn left(&self) -> usize {
        self.input.bytes.len()
    }

    /// Returns the next effect; `None` at the end of the row.
    pub(in crate::record) fn read(&mut self) -> Result<Option<Item<'_>>, String> {
        if self.input.bytes.is_empty() {
            return Ok(None);
        }
        if self.count.is_multiple_of(BLOCK_EFFECTS) {
            self.memory.block += 1;
            self.task = 0;
        }
        self.count += 1;
        let number = self.input.unsigned()?;
        let now = self.now;
        let Some(place) = number.checked_sub(1).and_then(|place| usize::try_from(place).ok()) else {
            let length = self.input.unsigned()?;
            return Ok(Some(Item { now, content: Content::Stored(self.input.take(length)?) }));
        };
        let dictionary = self.dictionary;
        let shape = dictionary.shapes.get(place).ok_or_else(|| format!("shape {number} is not known"))?;
        self.values(place, shape)?;
        let values = self.memory.last.get(place).map_or(&[][..], |(_, values)| values);
        Ok(Some(Item { now, content: Content::Shaped { place, shape, values, task: self.task } }))
    }

    /// Reads the values of an effect of `shape`.
    fn values(&mut self, place: usize, shape: &KnownShape) -> Result<(), String> {
        if self.memory.last.len() <= place {
            self.memory.last.resize(place + 1, (0, Vec::new()));
        }
        let marks = self.input.take(shape.holes.len().div_ceil(8) as u64)?;
        let current = self.memory.block;
        let Some((block, last)) = self.memory.last.get_mut(place) else { return Ok(()) };
        if *block != current {
            *block = current;
            last.clone_from(&shape.example);
        }
        let mut is_first_task = true;
        for (number, (hole, last)) in shape.holes.iter().zip(last).enumerate() {
            let is_marked = marks.get(number / 8).is_some_and(|byte| byte & (1 << (number % 8)) != 0);
            let is_task = *hole == Hole::Task && std::mem::take(&mut is_first_task);
            match last {
                Filling::Text(text) if is_marked => {
                    let word = self.input.unsigned()?;
                    *text = if word == 0 {
                        let length = self.input.unsigned()?;
                        let bytes = self.input.take(length)?;
                        Arc::from(std::str::from_utf8(bytes).map_err(|_| "a text is not UTF-8")?)
                    } else {
                        self.dictionary.word(word)?
                    };
                }
                Filling::Number(value) if *hole == Hole::Real => {
                    if is_marked {
                        *value = self.input.real()?.to_bits();
                    }
                }
                Filling::Number(value) => {
                    let expected = if is_task { self.task } else { *value };
                    let more = if is_marked { self.input.signed()? } else { 0 };
                    *value = expected.wrapping_add(more.cast_unsigned());
                    if is_task {
                        self.task = *value;
                    }
                }
                Filling::Text(_) => {}
            }
        }
        Ok(())
    }
}

//! The recorded steps in order, read in pages so that a long flight need not fit into memory.

use super::codec::{self, Variables};
use super::reader::RecordReader;
use crate::error::RecordError;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use rusqlite::params;
use std::collections::{BTreeMap, VecDeque};

/// Batches read at one time.
const PAGE_BATCHES: i64 = 256;

/// One recorded executive step.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedStep {
    /// The batch's number, from 1.
    pub batch_number: i64,
    /// What went in.
    pub batch: Batch,
    /// What came out, in order; empty after [`Steps::without_effects`].
    pub effects: Vec<RecordedEffect>,
}

/// A recorded effect as stored: replay compares the bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedEffect {
    /// Its number, from 1.
    pub number: i64,
    /// The effect in postcard.
    pub body: Vec<u8>,
}

impl RecordedEffect {
    /// The effect itself.
    ///
    /// # Errors
    /// What is wrong with the bytes, as a sentence fragment.
    pub fn effect(&self) -> Result<Effect, String> {
        postcard::from_bytes(&self.body).map_err(|error| format!("effect {} is garbled ({error})", self.number))
    }
}

impl RecordedStep {
    /// The effects themselves.
    ///
    /// # Errors
    /// What is wrong with the bytes, as a sentence fragment.
    pub fn decoded_effects(&self) -> Result<Vec<Effect>, String> {
        self.effects.iter().map(RecordedEffect::effect).collect()
    }
}

/// An iterator over recorded steps.
pub struct Steps<'a> {
    reader: &'a RecordReader,
    variables: Variables,
    next_batch: i64,
    to: Time,
    with_effects: bool,
    page: VecDeque<RecordedStep>,
    ended: bool,
    failure: Option<RecordError>,
}

impl<'a> Steps<'a> {
    /// Steps from batch `first` (0: none) to the instant `to`.
    pub(super) fn new(reader: &'a RecordReader, first: i64, to: Time) -> Result<Steps<'a>, RecordError> {
        let variables = reader.variable_table()?;
        let (page, ended) = (VecDeque::new(), first == 0);
        Ok(Steps { reader, variables, next_batch: first, to, with_effects: true, page, ended, failure: None })
    }

    /// The same steps without their effects: faster where only inputs count.
    #[must_use]
    pub fn without_effects(mut self) -> Steps<'a> {
        self.with_effects = false;
        self
    }

    fn fill(&mut self) -> Result<(), RecordError> {
        let (first, last) = (self.next_batch, self.next_batch.saturating_add(PAGE_BATCHES - 1));
        self.next_batch = last.saturating_add(1);
        let mut effects = if self.with_effects { self.effects(first, last)? } else { BTreeMap::new() };
        let reader = self.reader;
        let broken = |error| reader.damaged("the steps", error);
        let sql = "SELECT id, t_ns, events FROM batch WHERE id BETWEEN ?1 AND ?2 ORDER BY id";
        let mut statement = reader.connection.prepare_cached(sql).map_err(broken)?;
        let mut rows = statement.query(params![first, last]).map_err(broken)?;
        while let Some(row) = rows.next().map_err(broken)? {
            let batch_number = row.get::<_, i64>(0).map_err(broken)?;
            let now = Time(row.get(1).map_err(broken)?);
            let bytes = row.get_ref(2).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            if now > self.to {
                self.ended = true;
                break;
            }
            let batch = codec::decode(now, bytes, &self.variables)
                .map_err(|fault| reader.garbled(format!("batch {batch_number} at {now} cannot be read: {fault}")))?;
            let effects = effects.remove(&batch_number).unwrap_or_default();
            self.page.push_back(RecordedStep { batch_number, batch, effects });
        }
        self.ended |= self.page.is_empty();
        Ok(())
    }

    fn effects(&self, first: i64, last: i64) -> Result<BTreeMap<i64, Vec<RecordedEffect>>, RecordError> {
        let broken = |error| self.reader.damaged("the effects", error);
        let sql = "SELECT batch, id, body FROM effect WHERE batch BETWEEN ?1 AND ?2 ORDER BY batch, id";
        let mut statement = self.reader.connection.prepare_cached(sql).map_err(broken)?;
        let mut rows = statement.query(params![first, last]).map_err(broken)?;
        let mut effects: BTreeMap<i64, Vec<RecordedEffect>> = BTreeMap::new();
        while let Some(row) = rows.next().map_err(broken)? {
            let batch = row.get::<_, i64>(0).map_err(broken)?;
            let effect = RecordedEffect { number: row.get(1).map_err(broken)?, body: row.get(2).map_err(broken)? };
            effects.entry(batch).or_default().push(effect);
        }
        Ok(effects)
    }
}

impl Iterator for Steps<'_> {
    type Item = Result<RecordedStep, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.page.is_empty() && !self.ended {
            self.failure = self.fill().err();
            self.ended |= self.failure.is_some();
        }
        // What stands before the damage is told before it.
        match self.page.pop_front() {
            Some(step) => Some(Ok(step)),
            None => self.failure.take().map(Err),
        }
    }
}

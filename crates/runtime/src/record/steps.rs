//! The recorded steps in order, read in pages so that a long flight need not fit into memory.

use super::codec::{self, Variables};
use super::effects::{Dictionary, EffectReader};
use super::reader::RecordReader;
use crate::error::RecordError;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use rusqlite::params;
use std::collections::{BTreeMap, VecDeque};

/// Number of batches read at one time.
const PAGE_BATCHES: i64 = 256;

/// One recorded executive step.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedStep {
    /// The number of the agent that stepped, from 0.
    pub agent: usize,
    /// The batch's number, from 1.
    pub batch_number: i64,
    /// Input.
    pub batch: Batch,
    /// Output, in order; empty for steps without effects by [`Steps::with_effects_after`].
    pub effects: Vec<RecordedEffect>,
}

/// A recorded effect in bytes, which replay compares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedEffect {
    /// Its number, from 1.
    pub number: i64,
    /// The effect in postcard.
    pub body: Vec<u8>,
}

impl RecordedEffect {
    /// Returns the effect itself.
    ///
    /// # Errors
    /// The error in the bytes, as a fragment of a message.
    pub fn effect(&self) -> Result<Effect, String> {
        postcard::from_bytes(&self.body).map_err(|error| format!("effect {} is garbled ({error})", self.number))
    }
}

impl RecordedStep {
    /// Returns the effects themselves.
    ///
    /// # Errors
    /// The error in the bytes, as a fragment of a message.
    pub fn decoded_effects(&self) -> Result<Vec<Effect>, String> {
        self.effects.iter().map(RecordedEffect::effect).collect()
    }
}

/// An iterator over recorded steps.
pub struct Steps<'a> {
    reader: &'a RecordReader,
    variables: Variables,
    dictionary: Dictionary,
    next_batch: i64,
    to: Time,
    /// Steps up to this batch are returned without their effects.
    effects_after: i64,
    /// True for the steps of all agents, false for those of the selected one.
    of_all: bool,
    page: VecDeque<RecordedStep>,
    ended: bool,
    failure: Option<RecordError>,
}

impl<'a> Steps<'a> {
    /// Returns the steps from batch `first` (0: none) to the instant `to`.
    pub(super) fn new(reader: &'a RecordReader, first: i64, to: Time) -> Result<Steps<'a>, RecordError> {
        let variables = reader.variable_table()?;
        let (page, ended) = (VecDeque::new(), first == 0);
        Ok(Steps {
            reader,
            variables,
            dictionary: Dictionary::default(),
            next_batch: first,
            to,
            effects_after: 0,
            of_all: false,
            page,
            ended,
            failure: None,
        })
    }

    /// Returns the same steps without their effects, for callers that need only inputs.
    #[must_use]
    pub fn without_effects(self) -> Steps<'a> {
        self.with_effects_after(i64::MAX)
    }

    /// Returns the same steps, those up to batch `last` without their effects.
    #[must_use]
    pub fn with_effects_after(mut self, last: i64) -> Steps<'a> {
        self.effects_after = last;
        self
    }

    /// Returns the steps of all agents.
    #[must_use]
    pub(super) fn of_all(mut self) -> Steps<'a> {
        self.of_all = true;
        self
    }

    fn fill(&mut self) -> Result<(), RecordError> {
        let reader = self.reader;
        let broken = |error| reader.damaged("the steps", error);
        let table = if self.of_all { "main.batch" } else { "batch" };
        let sql =
            format!("SELECT id, t_ns, events, agent FROM {table} WHERE id >= ?1 ORDER BY id LIMIT {PAGE_BATCHES}");
        let mut statement = reader.connection.prepare_cached(&sql).map_err(broken)?;
        let mut rows = statement.query(params![self.next_batch]).map_err(broken)?;
        let mut last = self.next_batch;
        while let Some(row) = rows.next().map_err(broken)? {
            let batch_number = row.get::<_, i64>(0).map_err(broken)?;
            let now = Time(row.get(1).map_err(broken)?);
            let bytes = row.get_ref(2).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            let agent = row.get::<_, i64>(3).map_err(broken)?;
            if now > self.to {
                self.ended = true;
                break;
            }
            let batch = codec::decode(now, bytes, &self.variables)
                .map_err(|fault| reader.garbled(format!("batch {batch_number} at {now} cannot be read: {fault}")));
            // Steps before the damage are returned before the error.
            let batch = match batch {
                Ok(batch) => batch,
                Err(fault) => {
                    self.failure = Some(fault);
                    break;
                }
            };
            last = batch_number;
            let agent = usize::try_from(agent).unwrap_or(0);
            self.page.push_back(RecordedStep { agent, batch_number, batch, effects: Vec::new() });
        }
        self.ended |= self.page.is_empty();
        let first = self.next_batch.max(self.effects_after.saturating_add(1));
        if first <= last && !self.page.is_empty() {
            let (mut effects, damaged) = self.effects(first, last).inspect_err(|_| self.page.clear())?;
            for step in &mut self.page {
                step.effects = effects.remove(&step.batch_number).unwrap_or_default();
            }
            if let Some((batch, fault)) = damaged {
                self.page.retain(|step| step.batch_number < batch);
                self.failure = Some(fault);
            }
        }
        self.next_batch = last.saturating_add(1);
        Ok(())
    }

    /// Returns the effects of the steps from `first` to `last`, up to the first step whose effects are damaged, and that step with the
    /// error.
    fn effects(&mut self, first: i64, last: i64) -> Result<(EffectsOfSteps, Option<(i64, RecordError)>), RecordError> {
        let reader = self.reader;
        let broken = |error| reader.damaged("the effects", error);
        let sql = "SELECT e.batch, b.t_ns, e.first, e.body FROM main.effects e JOIN main.batch b ON b.id = e.batch \
                   WHERE e.batch BETWEEN ?1 AND ?2 ORDER BY e.batch";
        self.dictionary.refresh(&reader.connection).map_err(broken)?.map_err(|fault| reader.garbled(fault))?;
        let mut statement = reader.connection.prepare_cached(sql).map_err(broken)?;
        let mut rows = statement.query(params![first, last]).map_err(broken)?;
        let mut effects = EffectsOfSteps::new();
        while let Some(row) = rows.next().map_err(broken)? {
            let (batch, now): (i64, i64) = (row.get(0).map_err(broken)?, row.get(1).map_err(broken)?);
            let first: i64 = row.get(2).map_err(broken)?;
            let bytes = row.get_ref(3).and_then(|cell| Ok(cell.as_blob()?)).map_err(broken)?;
            match effects_of(&self.dictionary, Time(now), first, bytes) {
                Ok(of_step) => effects.insert(batch, of_step),
                Err(fault) => {
                    let fault = reader.garbled(format!("the effects of step {batch} cannot be read: {fault}"));
                    return Ok((effects, Some((batch, fault))));
                }
            };
        }
        Ok((effects, None))
    }
}

/// Effects by the number of their step.
type EffectsOfSteps = BTreeMap<i64, Vec<RecordedEffect>>;

/// Returns the effects of one step; the first one has the number `first`.
fn effects_of(dictionary: &Dictionary, now: Time, first: i64, bytes: &[u8]) -> Result<Vec<RecordedEffect>, String> {
    let mut effects: Vec<RecordedEffect> = Vec::new();
    let mut items = EffectReader::new(dictionary, now, bytes);
    while let Some(item) = items.read()? {
        let number = first.wrapping_add(effects.len() as i64);
        effects.push(RecordedEffect { number, body: item.body() });
    }
    Ok(effects)
}

impl Iterator for Steps<'_> {
    type Item = Result<RecordedStep, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.page.is_empty() && !self.ended {
            if let Err(fault) = self.fill() {
                self.failure = Some(fault);
            }
            self.ended |= self.failure.is_some();
        }
        // Steps before the damage are returned before the error.
        match self.page.pop_front() {
            Some(step) => Some(Ok(step)),
            None => self.failure.take().map(Err),
        }
    }
}

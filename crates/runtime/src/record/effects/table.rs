//! All effects of one agent in memory: kind, task and place in the record of each. It grows with the record, and all readers of the
//! record share it. Bound: each effect is read once; 24 bytes for each.

use super::BLOCK_EFFECTS;
use super::decoder::{Dictionary, EffectReader, Memory};
use super::kind::EffectKind;
use apex_model::effect::{Decision, DecisionKind, Effect, SolveRequestId};
use apex_model::source::SourceFile;
use apex_model::time::Time;
use rusqlite::Connection;
use std::collections::BTreeMap;

/// Kind of the effects that adopt a plan.
const PLAN_ADOPTED: &str = "procedure-added";

/// A step with effects.
pub(in crate::record) struct StepRow {
    pub(in crate::record) batch: i64,
    pub(in crate::record) at: Time,
    /// Number of its first effect.
    pub(in crate::record) first: i64,
    /// Place of its first effect in the table.
    pub(in crate::record) place: usize,
    /// Offsets in the bytes at which its second block begins, its third, ..
    pub(in crate::record) blocks: Vec<u32>,
}

impl StepRow {
    /// Returns the offset in the bytes at which a block begins.
    pub(in crate::record) fn offset(&self, block: usize) -> usize {
        block.checked_sub(1).and_then(|before| self.blocks.get(before)).map_or(0, |offset| *offset as usize)
    }
}

/// An effect.
struct EffectEntry {
    task: Option<u64>,
    /// Index of its kind among the kinds.
    kind: u32,
    /// Index of the preceding effect about the same task, plus 1; 0 if there is none.
    before: u32,
}

/// The effects by their place from 0.
#[derive(Default)]
pub(crate) struct EffectTable {
    pub(in crate::record) dictionary: Dictionary,
    pub(in crate::record) steps: Vec<StepRow>,
    /// Number of the last step that was read or belongs to another agent.
    pub(in crate::record) read_to: i64,
    entries: Vec<EffectEntry>,
    kinds: Vec<EffectKind>,
    /// By shape: the index of its kind plus 1; 0 before the first effect of the shape.
    kinds_of_shapes: Vec<u32>,
    /// By task: index of its last effect.
    last: BTreeMap<u64, u32>,
    /// Places of the effects that adopt a plan.
    plans: Vec<usize>,
    /// Adopted plans whose sources are still to be found: the step and the request.
    pub(in crate::record) adopted: Vec<(i64, SolveRequestId)>,
    /// The sources of the program and of the plans, in the order in which places refer to them.
    pub(in crate::record) sources: Vec<SourceFile>,
}

impl EffectTable {
    /// Reads the steps that are new since the last call, up to `newest`; the inner error describes the bytes that cannot be decoded.
    pub(in crate::record) fn refresh(
        &mut self,
        connection: &Connection,
        newest: i64,
    ) -> rusqlite::Result<Result<(), String>> {
        let seen = self.steps.last().map_or(0, |step| step.batch);
        if newest <= self.read_to {
            return Ok(Ok(()));
        }
        // All reads see one state of the record: words, shapes and the rows that use them.
        let own_transaction = connection.is_autocommit() && connection.execute_batch("BEGIN").is_ok();
        let read = self.read_rows(connection, seen);
        if own_transaction {
            let _ = connection.execute_batch("COMMIT");
        }
        if let Ok(Ok(())) = read {
            self.read_to = newest;
        }
        read
    }

    fn read_rows(&mut self, connection: &Connection, seen: i64) -> rusqlite::Result<Result<(), String>> {
        if let Err(fault) = self.dictionary.refresh(connection)? {
            return Ok(Err(fault));
        }
        let sql = "SELECT e.batch, b.t_ns, e.first, e.body FROM main.effects e JOIN batch b ON b.id = e.batch \
                   WHERE e.batch > ?1 ORDER BY e.batch";
        let mut statement = connection.prepare_cached(sql)?;
        let mut rows = statement.query([seen])?;
        let mut memory = Memory::default();
        while let Some(row) = rows.next()? {
            let (batch, at, first) = (row.get(0)?, Time(row.get(1)?), row.get(2)?);
            let step = StepRow { batch, at, first, place: self.entries.len(), blocks: Vec::new() };
            let place = self.entries.len();
            let bytes = row.get_ref(3)?.as_blob()?;
            memory = match self.read_step(step, bytes, memory) {
                Ok(memory) => memory,
                Err(fault) => {
                    self.entries.truncate(place);
                    self.plans.retain(|plan| *plan < place);
                    return Ok(Err(format!("the effects of step {batch} cannot be read: {fault}")));
                }
            };
        }
        Ok(Ok(()))
    }

    /// Enters the effects of a step; `memory` is reused from step to step.
    fn read_step(&mut self, mut step: StepRow, bytes: &[u8], memory: Memory) -> Result<Memory, String> {
        let mut reader = EffectReader::in_memory(&self.dictionary, step.at, bytes, memory);
        let mut count = 0_usize;
        loop {
            if count > 0 && count.is_multiple_of(BLOCK_EFFECTS) {
                step.blocks.push(u32::try_from(bytes.len() - reader.left()).map_err(|_| "it is too long")?);
            }
            let Some(item) = reader.read()? else { break };
            let (kind, task) = item.kind()?;
            let is_plan = kind.word == PLAN_ADOPTED;
            if is_plan
                && let Effect::Decided(Decision { kind: DecisionKind::ProcedureAdded { request, .. }, .. }) =
                    item.effect()?
            {
                self.adopted.push((step.batch, request));
            }
            count += 1;
            let kind = match item.shape() {
                Some(shape) => kind_of_shape((&mut self.kinds, &mut self.kinds_of_shapes), shape, kind),
                None => place_of(&mut self.kinds, kind),
            };
            if is_plan {
                self.plans.push(self.entries.len());
            }
            let place = u32::try_from(self.entries.len()).map_err(|_| "there are too many effects")?;
            let before = task.and_then(|task| self.last.insert(task, place)).map_or(0, |before| before + 1);
            self.entries.push(EffectEntry { task, kind, before });
        }
        let memory = reader.memory();
        self.steps.push(step);
        Ok(memory)
    }

    /// Returns the places of the effects up to `at` that adopt a plan.
    pub(crate) fn plans(&self, at: Time) -> &[usize] {
        let later = self.place_later(at);
        let end = self.plans.partition_point(|place| *place < later);
        self.plans.get(..end).unwrap_or_default()
    }

    /// Returns the number of effects.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Returns the step of the effect at an index, and the effect's index within that step.
    pub(in crate::record) fn step_of(&self, place: usize) -> Option<(&StepRow, usize)> {
        let step = self.steps.partition_point(|step| step.place <= place).checked_sub(1)?;
        let step = self.steps.get(step)?;
        Some((step, place - step.place))
    }

    /// Returns the number of the effect at a place.
    pub(crate) fn id(&self, place: usize) -> i64 {
        self.step_of(place).map_or(0, |(step, number)| step.first.wrapping_add(number as i64))
    }

    /// Returns the first place with a number above `id`.
    pub(crate) fn place_after(&self, id: i64) -> usize {
        let later = self.steps.partition_point(|step| step.first <= id);
        let end = self.steps.get(later).map_or(self.entries.len(), |step| step.place);
        let Some(step) = later.checked_sub(1).and_then(|before| self.steps.get(before)) else { return 0 };
        let within = usize::try_from(id.saturating_sub(step.first)).unwrap_or(usize::MAX).saturating_add(1);
        step.place.saturating_add(within).min(end)
    }

    /// Returns the first place with an instant above `at`.
    pub(crate) fn place_later(&self, at: Time) -> usize {
        let later = self.steps.partition_point(|step| step.at <= at);
        self.steps.get(later).map_or(self.entries.len(), |step| step.place)
    }

    /// Returns the number of the last effect; 0 before the first.
    pub(crate) fn last_id(&self) -> i64 {
        self.entries.len().checked_sub(1).map_or(0, |last| self.id(last))
    }

    /// Returns the kind of the effect at a place.
    pub(crate) fn kind(&self, place: usize) -> Option<&EffectKind> {
        self.entries.get(place).and_then(|entry| self.kinds.get(entry.kind as usize))
    }

    /// Returns the task of the effect at a place.
    pub(crate) fn task(&self, place: usize) -> Option<u64> {
        self.entries.get(place)?.task
    }

    /// Returns the places of the effects about a task, the newest first.
    pub(crate) fn about(&self, task: u64) -> impl Iterator<Item = usize> + '_ {
        let newest = self.last.get(&task).map(|place| *place as usize);
        std::iter::successors(newest, |place| self.before(*place))
    }

    /// Returns the index of the preceding effect about the same task.
    pub(in crate::record) fn before(&self, place: usize) -> Option<usize> {
        self.entries.get(place)?.before.checked_sub(1).map(|before| before as usize)
    }
}

/// Returns the place of the kind that all effects of a shape have.
fn kind_of_shape((kinds, known): (&mut Vec<EffectKind>, &mut Vec<u32>), shape: usize, kind: EffectKind) -> u32 {
    if known.len() <= shape {
        known.resize(shape + 1, 0);
    }
    let Some(slot) = known.get_mut(shape) else { return place_of(kinds, kind) };
    if *slot == 0 {
        *slot = place_of(kinds, kind) + 1;
    }
    *slot - 1
}

/// Returns the place of a kind, which is added if it is new.
fn place_of(kinds: &mut Vec<EffectKind>, kind: EffectKind) -> u32 {
    let place = kinds.iter().position(|known| *known == kind).unwrap_or_else(|| {
        kinds.push(kind);
        kinds.len() - 1
    });
    place as u32
}

//! Reads single effects, with their texts.

use super::codec;
use super::effects::{BLOCK_EFFECTS, EffectKind, EffectNeed, EffectReader, EffectTable, Item, StepRow};
use super::reader::RecordReader;
use crate::effect_describer::{EffectDescriber, EffectRow};
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use apex_model::effect::{Decision, DecisionKind, Effect, Method, SolveRequestId};
use apex_model::event::{Event, EventKind, SolverReport};
use apex_model::source::SourceFile;
use apex_model::task::TaskId;
use apex_model::time::Time;
use rusqlite::{Connection, OptionalExtension};
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, PoisonError, RwLockReadGuard};

/// Maximum number of blocks of decoded effects that stay in memory for further queries.
const BLOCKS_KEPT: usize = 16;

/// All effects of an agent up to now, opened for queries.
pub(crate) struct Effects<'r> {
    reader: &'r RecordReader,
    pub(crate) table: RwLockReadGuard<'r, EffectTable>,
    describer: RefCell<EffectDescriber>,
    blocks: RefCell<VecDeque<ReadBlock>>,
    /// Goals by index of the effect that reported them.
    goals: RefCell<BTreeMap<usize, Arc<str>>>,
}

/// The effects of a block in postcard.
struct ReadBlock {
    /// Place of the first one.
    place: usize,
    bodies: Vec<Vec<u8>>,
}

/// An effect with its texts.
#[derive(Clone, Debug)]
pub(crate) struct Told {
    pub(crate) id: i64,
    pub(crate) at: Time,
    pub(crate) row: EffectRow,
    pub(crate) effect: Effect,
}

/// An effect of a scan.
pub(crate) struct ScannedEffect {
    pub(crate) place: usize,
    pub(crate) at: Time,
    pub(crate) kind: EffectKind,
    pub(crate) task: Option<u64>,
    /// The effect; `None` if only its kind was requested.
    pub(crate) effect: Option<Effect>,
}

impl RecordReader {
    /// Returns the effects of the agent, up to date with the record.
    pub(crate) fn effects(&self) -> Result<Effects<'_>, RecordError> {
        let newest = newest_step(&self.connection).map_err(|error| self.damaged("the effects", error))?;
        let is_current = self.table.read().unwrap_or_else(PoisonError::into_inner).read_to >= newest;
        // Only a reader that must extend the table locks out the other readers.
        if !is_current {
            let mut table = self.table.write().unwrap_or_else(PoisonError::into_inner);
            let refreshed = table.refresh(&self.connection, newest);
            refreshed.map_err(|error| self.damaged("the effects", error))?.map_err(|fault| self.garbled(fault))?;
            self.find_plans(&mut table)?;
        }
        let table = self.table.read().unwrap_or_else(PoisonError::into_inner);
        let describer = RefCell::new(EffectDescriber::of_sources(table.sources.clone()));
        let (blocks, goals) = (RefCell::default(), RefCell::default());
        Ok(Effects { reader: self, table, describer, blocks, goals })
    }

    /// Adds the sources of the program, and of each adopted plan, to the table.
    fn find_plans(&self, table: &mut EffectTable) -> Result<(), RecordError> {
        if table.sources.is_empty() {
            table.sources = self.pdl_sources()?;
        }
        for (batch, request) in std::mem::take(&mut table.adopted) {
            if let Some(source) = self.plan_source(batch, request)? {
                table.sources.push(source);
            }
        }
        Ok(())
    }

    /// Returns the source of the plan that the step `batch` adopted.
    fn plan_source(&self, batch: i64, request: SolveRequestId) -> Result<Option<SourceFile>, RecordError> {
        Ok(self.inputs_of(batch)?.into_iter().find_map(|event| match event.kind {
            EventKind::SolverReported(reported, SolverReport::Plan(plan)) if reported == request => Some(plan.source),
            _ => None,
        }))
    }

    /// Returns the inputs of the step `batch`; none if the record does not have it.
    fn inputs_of(&self, batch: i64) -> Result<Vec<Event>, RecordError> {
        let sql = "SELECT t_ns, events FROM main.batch WHERE id = ?1";
        let row = self.connection.query_row(sql, [batch], |row| Ok((row.get(0)?, row.get::<_, Vec<u8>>(1)?)));
        let row = row.optional().map_err(|error| self.damaged("the steps", error))?;
        let Some((now, bytes)) = row else { return Ok(Vec::new()) };
        let decoded = codec::decode(Time(now), &bytes, &self.variable_table()?);
        let decoded = decoded.map_err(|fault| self.garbled(format!("batch {batch} cannot be read: {fault}")))?;
        Ok(decoded.events)
    }
}

/// Returns the number of the last step of any agent that has effects; 0 before the first.
fn newest_step(connection: &Connection) -> rusqlite::Result<i64> {
    let mut statement = connection.prepare_cached("SELECT ifnull(max(batch), 0) FROM main.effects")?;
    statement.query_row([], |row| row.get(0))
}

impl Effects<'_> {
    /// Calls `take` with each effect at `places` of which any part is requested, in order.
    pub(crate) fn scan(
        &self,
        places: std::ops::Range<usize>,
        wanted: impl Fn(&EffectKind) -> EffectNeed,
        take: impl FnMut(ScannedEffect) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        self.scan_items(places, |kind, _, _| wanted(kind), take)
    }

    /// Like [`Effects::scan`], except that `wanted` also receives the task and the stored effect.
    pub(in crate::record) fn scan_items(
        &self,
        places: std::ops::Range<usize>,
        mut wanted: impl FnMut(&EffectKind, Option<u64>, &Item<'_>) -> EffectNeed,
        mut take: impl FnMut(ScannedEffect) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        let mut place = places.start;
        let end = places.end.min(self.table.len());
        while place < end {
            let Some((step, number)) = self.table.step_of(place) else { return Ok(()) };
            let garbled =
                |fault| self.reader.garbled(format!("the effects of step {} cannot be read: {fault}", step.batch));
            let bytes = self.bytes_of(step)?;
            let block = number / BLOCK_EFFECTS;
            let mut items = EffectReader::within(&self.table.dictionary, step.at, &bytes, step.offset(block));
            let mut at = step.place + block * BLOCK_EFFECTS;
            while at < end
                && let Some(item) = items.read().map_err(garbled)?
            {
                let kind = self.table.kind(at).filter(|_| at >= place);
                let task = self.table.task(at);
                let effect = match kind.map_or(EffectNeed::Nothing, |kind| wanted(kind, task, &item)) {
                    EffectNeed::Nothing => None,
                    EffectNeed::Kind => Some(None),
                    EffectNeed::Effect => Some(Some(item.effect().map_err(garbled)?)),
                };
                if let (Some(effect), Some(kind)) = (effect, kind) {
                    take(ScannedEffect { place: at, at: step.at, kind: *kind, task, effect })?;
                }
                at += 1;
            }
            place = at.max(place + 1);
        }
        Ok(())
    }

    /// Returns the bytes of a step's effects.
    fn bytes_of(&self, step: &StepRow) -> Result<Vec<u8>, RecordError> {
        let broken = |error| self.reader.damaged("the effects", error);
        let sql = "SELECT body FROM main.effects WHERE batch = ?1";
        let mut statement = self.reader.connection.prepare_cached(sql).map_err(broken)?;
        statement.query_row([step.batch], |row| row.get(0)).map_err(broken)
    }

    /// Returns the inputs of the step of the effect at a place.
    pub(crate) fn inputs(&self, place: usize) -> Result<Vec<Event>, RecordError> {
        self.table.step_of(place).map_or(Ok(Vec::new()), |(step, _)| self.reader.inputs_of(step.batch))
    }

    /// Returns the instant of the effect at a place.
    pub(crate) fn at(&self, place: usize) -> Time {
        self.table.step_of(place).map_or(Time::ZERO, |(step, _)| step.at)
    }

    /// Returns the effect at a place.
    pub(crate) fn effect(&self, place: usize) -> Result<Effect, RecordError> {
        if let Some(body) = self.kept(place) {
            return self.effect_of(&body, place);
        }
        let block = self.load(place)?;
        let body = place.checked_sub(block.place).and_then(|number| block.bodies.get(number)).cloned();
        let mut blocks = self.blocks.borrow_mut();
        if blocks.len() >= BLOCKS_KEPT {
            blocks.pop_front();
        }
        blocks.push_back(block);
        self.effect_of(&body.unwrap_or_default(), place)
    }

    fn effect_of(&self, body: &[u8], place: usize) -> Result<Effect, RecordError> {
        postcard::from_bytes(body)
            .map_err(|error| self.reader.garbled(format!("effect {} is garbled ({error})", self.table.id(place))))
    }

    fn kept(&self, place: usize) -> Option<Vec<u8>> {
        let blocks = self.blocks.borrow();
        blocks.iter().find_map(|block| block.bodies.get(place.checked_sub(block.place)?).cloned())
    }

    /// Reads the block with the effect at a place.
    fn load(&self, place: usize) -> Result<ReadBlock, RecordError> {
        let missing = || self.reader.garbled("an effect is missing".into());
        let (step, number) = self.table.step_of(place).ok_or_else(missing)?;
        let block = number / BLOCK_EFFECTS;
        let bytes = self.bytes_of(step)?;
        let mut items = EffectReader::within(&self.table.dictionary, step.at, &bytes, step.offset(block));
        let mut bodies = Vec::new();
        let garbled =
            |fault| self.reader.garbled(format!("the effects of step {} cannot be read: {fault}", step.batch));
        while bodies.len() < BLOCK_EFFECTS
            && let Some(item) = items.read().map_err(garbled)?
        {
            bodies.push(item.body());
        }
        Ok(ReadBlock { place: step.place + block * BLOCK_EFFECTS, bodies })
    }

    /// Returns the effect at a place with its texts.
    pub(crate) fn told(&self, place: usize) -> Result<Told, RecordError> {
        let effect = self.effect(place)?;
        self.tell(place, effect)
    }

    /// Returns the texts of the effect at a place.
    pub(crate) fn tell(&self, place: usize, effect: Effect) -> Result<Told, RecordError> {
        let told_goal = told_goal(&effect);
        if !told_goal && let Some(task) = self.table.task(place) {
            let goal = self.goal_before(place)?;
            self.describer.borrow_mut().remember(TaskId(task), goal);
        }
        let row = self.describer.borrow_mut().tell(&effect);
        if told_goal {
            self.goals.borrow_mut().insert(place, Arc::clone(&row.goal));
        }
        Ok(Told { id: self.table.id(place), at: self.at(place), row, effect })
    }

    /// Returns the place of a decision, `file:line:column`: of a task's creation that of its step.
    pub(crate) fn place(&self, decision: &Decision) -> Option<String> {
        let step = match &decision.kind {
            DecisionKind::Created { place, .. } => *place,
            _ => None,
        };
        step.or(decision.because.place).map(|place| self.describer.borrow().place(place))
    }

    /// Returns the method with its place.
    pub(crate) fn method(&self, method: &Method) -> MethodDetail {
        self.describer.borrow().method(method)
    }

    /// Returns the goal of the task of the effect at a place, as known then.
    fn goal_before(&self, place: usize) -> Result<Arc<str>, RecordError> {
        let mut earlier = std::iter::successors(self.table.before(place), |place| self.table.before(*place));
        let teller = earlier.find(|place| self.table.kind(*place).is_some_and(|kind| kind.tells_goal()));
        let Some(teller) = teller else { return Ok(Arc::default()) };
        if let Some(goal) = self.goals.borrow().get(&teller) {
            return Ok(Arc::clone(goal));
        }
        let goal: Arc<str> = match self.effect(teller)? {
            Effect::Decided(Decision {
                kind: DecisionKind::Created { goal, .. } | DecisionKind::Selected { goal, .. },
                ..
            }) => Arc::from(goal.to_string()),
            _ => Arc::default(),
        };
        self.goals.borrow_mut().insert(teller, Arc::clone(&goal));
        Ok(goal)
    }
}

fn told_goal(effect: &Effect) -> bool {
    let Effect::Decided(decision) = effect else { return false };
    matches!(decision.kind, DecisionKind::Created { .. } | DecisionKind::Selected { .. })
}

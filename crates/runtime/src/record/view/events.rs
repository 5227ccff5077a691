//! The log: all effects of the agent, with their causes.

use super::effect_index::{BLOCK_EFFECTS, EffectSearch};
use super::{RecordView, for_reading, for_writing};
use crate::error::RecordError;
use crate::record::{EffectKind, Effects, Told};
use apex_model::time::Time;
use serde::Serialize;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Maximum number of rows of an answer, unless the query states one.
const LIMIT_DEFAULT: usize = 200;
/// Maximum number of rows of any answer.
const LIMIT_MAX: usize = 5_000;

/// Maximum number of effects that one answer reads in search of a text. A search for a text that does not occur would otherwise read the
/// whole log; the answer states where the search continues.
const SEARCHED_MAX: usize = 4_096;

/// An effect that is not in the index counts as this many of [`SEARCHED_MAX`]: while the log is being indexed, each answer would otherwise
/// read as many as it may.
const UNINDEXED_WEIGHT: usize = 4;

/// Number of blocks that a query takes from the index at once.
const BLOCKS_TURN: usize = 32;

/// Time that a query spends on an index that is behind.
const EVENTS_BUDGET: Duration = Duration::from_millis(30);

/// A query of the log.
#[derive(Clone, Debug, Default)]
pub struct EventsQuery {
    /// Earliest mission time in nanoseconds; default: the record's start.
    pub from_ns: Option<i64>,
    /// Latest mission time in nanoseconds; default: the record's end.
    pub to_ns: Option<i64>,
    /// Kinds of effects; empty selects all.
    pub kinds: Vec<String>,
    /// Only effects of this task.
    pub task: Option<u64>,
    /// Only effects whose subject or text contains this text, in any case.
    pub find: Option<String>,
    /// Maximum number of rows; default 200, at most 5,000.
    pub limit: Option<usize>,
    /// Only effects with lower numbers: continues a search at its [`Events::next`].
    pub before: Option<i64>,
    /// Maximum number of effects that are read in search of a text; default 4,096.
    pub searched_max: Option<usize>,
}

/// The last effects of the requested time, oldest first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Events {
    /// The effects.
    pub events: Vec<EventRow>,
    /// True if older effects of that time are left out.
    pub more: bool,
    /// Number of the effect before which the search for a text continues; null if the query was answered to its end or limit.
    pub next: Option<i64>,
}

/// An effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct EventRow {
    /// Its number in the record, from 1.
    pub id: i64,
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// `transition`, `command`, `solve`, ..: `docs/reference/flight-record.md` lists them.
    pub kind: String,
    /// The number of the task concerned, if there is one.
    pub task: Option<u64>,
    /// State before, for `transition`.
    pub from_state: Option<String>,
    /// State after, for `transition`.
    pub to_state: Option<String>,
    /// A word of `apex_model::task::OUTCOME_WORDS`, for the transition to `terminated`.
    pub outcome: Option<String>,
    /// The goal, form or variable.
    pub subject: Option<String>,
    /// The cause or the message, without the place.
    pub text: Option<String>,
    /// `file:line:column` of the clause of PDL.
    pub place: Option<String>,
}

impl EventRow {
    fn of(told: Told) -> EventRow {
        let Told { id, at, row, .. } = told;
        let text = |text: String| Some(text).filter(|text| !text.is_empty());
        EventRow {
            id,
            t_ns: at.0,
            kind: row.kind.into(),
            task: row.task.map(|task| task.0),
            from_state: row.from.map(|state| state.word().into()),
            to_state: row.to.map(|state| state.word().into()),
            outcome: row.outcome.map(str::to_owned),
            subject: text(row.subject),
            text: text(row.text),
            place: row.place,
        }
    }
}

impl RecordView {
    /// Returns the effects that a query selects.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn events(&self, query: &EventsQuery) -> Result<Events, RecordError> {
        let limit = query.limit.unwrap_or(LIMIT_DEFAULT).clamp(1, LIMIT_MAX);
        self.reader.check_growth()?;
        let (mut events, next) = match query.task {
            Some(task) => {
                let effects = self.reader.effects()?;
                self.selected(query, &effects, (effects.table.about(task), usize::MAX), limit + 1)?
            }
            None => self.found(query, limit + 1)?,
        };
        let more = events.len() > limit || next.is_some();
        events.truncate(limit);
        events.reverse();
        Ok(Events { events, more, next })
    }

    /// Returns the first `count` effects at `places` that a query selects, and the number of the effect at which the search ended early.
    /// Effects from the place `unindexed` on are not in the index.
    fn selected(
        &self,
        query: &EventsQuery,
        effects: &Effects<'_>,
        (places, unindexed): (impl Iterator<Item = usize>, usize),
        count: usize,
    ) -> Result<(Vec<EventRow>, Option<i64>), RecordError> {
        let find = query.find.as_deref().map(str::to_ascii_lowercase).unwrap_or_default();
        let (from_ns, to_ns) = (query.from_ns.unwrap_or(i64::MIN), query.to_ns.unwrap_or(i64::MAX));
        let first_beyond =
            query.before.map_or(usize::MAX, |before| effects.table.place_after(before.saturating_sub(1)));
        let searched_max = query.searched_max.unwrap_or(SEARCHED_MAX).max(1);
        let mut events = Vec::new();
        let mut in_vain = 0_usize;
        for place in places.filter(|place| *place < first_beyond) {
            if events.len() >= count {
                break;
            }
            let is_kind =
                |kind: &EffectKind| query.kinds.is_empty() || query.kinds.iter().any(|each| each == kind.word);
            if !effects.table.kind(place).is_some_and(is_kind) || !(from_ns..=to_ns).contains(&effects.at(place).0) {
                continue;
            }
            if in_vain >= searched_max {
                return Ok((events, Some(effects.table.id(place) + 1)));
            }
            let told = effects.told(place)?;
            let holds = |text: &str| text.to_ascii_lowercase().contains(&find);
            if find.is_empty() || holds(&told.row.subject) || holds(&told.row.text) {
                events.push(EventRow::of(told));
            } else {
                in_vain += if place >= unindexed { UNINDEXED_WEIGHT } else { 1 };
            }
        }
        Ok((events, None))
    }

    /// Returns the newest effects that a query selects, at most `count`: first those that are not in the index yet, then those of the
    /// blocks that may contain a match.
    fn found(&self, query: &EventsQuery, count: usize) -> Result<(Vec<EventRow>, Option<i64>), RecordError> {
        // If another thread extends the index, queries leave that to it.
        if !self.indexes.is_indexed_apart.load(Ordering::Relaxed) {
            self.index_now(EVENTS_BUDGET)?;
        }
        let wanted = EffectSearch {
            from_ns: query.from_ns.unwrap_or(i64::MIN),
            to_ns: query.to_ns.unwrap_or(i64::MAX),
            kinds: &query.kinds,
            find: query.find.as_deref().filter(|find| !find.is_empty()),
        };
        let seen = for_reading(&self.indexes.effects).seen();
        let effects = self.reader.effects()?;
        let place = |id: i64| effects.table.place_after(id);
        let end = effects.table.place_later(Time(wanted.to_ns));
        let end = query.before.map_or(end, |before| place(before.saturating_sub(1)).min(end));
        let begin = place(seen).max(effects.table.place_later(Time(wanted.from_ns.saturating_sub(1))));
        let newest = (begin..end).rev();
        // An answer mostly ends after a few blocks: the index is read in turns, so that the other blocks are left alone.
        let mut below = query.before.map_or(i64::MAX, |before| before.saturating_add(BLOCK_EFFECTS));
        let mut ended = false;
        let turns = std::iter::from_fn(|| {
            let index = for_reading(&self.indexes.effects);
            let ranges: Vec<(i64, i64)> =
                if ended { Vec::new() } else { index.blocks(&wanted, below).take(BLOCKS_TURN).collect() };
            below = ranges.last().map_or(below, |(first, _)| *first);
            ended = ranges.len() < BLOCKS_TURN;
            (!ranges.is_empty()).then_some(ranges)
        });
        let blocks = turns.flatten().flat_map(|(first, last)| (place(first - 1)..place(last)).rev());
        self.selected(query, &effects, (newest.chain(blocks), place(seen)), count)
    }

    /// Extends the index of the log for about `budget` of time. Returns true once it contains all effects; before that, queries search
    /// the others row by row and do not extend the index.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn index_effects(&self, budget: Duration) -> Result<bool, RecordError> {
        self.indexes.is_indexed_apart.store(true, Ordering::Relaxed);
        let indexed = self.index_now(budget);
        if !matches!(indexed, Ok(false)) {
            self.indexes.is_indexed_apart.store(false, Ordering::Relaxed);
        }
        indexed
    }

    fn index_now(&self, budget: Duration) -> Result<bool, RecordError> {
        self.reader.check_growth()?;
        let began = Instant::now();
        let last = self.reader.effects()?.table.last_id();
        loop {
            // Queries wait for neither the reading nor the decoding of effects: the index is locked only to append what was read.
            let mut next = for_reading(&self.indexes.effects).continuation();
            let after = next.seen();
            if after >= last {
                return Ok(true);
            }
            if began.elapsed() > budget {
                return Ok(false);
            }
            next.refresh(&self.reader, last)?;
            for_writing(&self.indexes.effects).append(after, next);
        }
    }
}

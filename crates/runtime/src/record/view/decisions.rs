//! Searches for decisions that explanations need: the last one of a kind before another, or at its instant; the decisions about a task;
//! the effects about a target.

use super::announcements::Announcements;
use super::targets::TargetChange;
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use crate::record::{EffectKind, Effects, RecordReader, Told};
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use rusqlite::{OptionalExtension, params};

/// An effect with its texts.
pub(crate) struct DecisionRow {
    pub(crate) id: i64,
    pub(crate) at: Time,
    pub(crate) kind: String,
    pub(crate) task: Option<TaskId>,
    /// State before, for `transition`.
    pub(crate) from: Option<String>,
    /// State after, for `transition`.
    pub(crate) to: Option<String>,
    /// A word of `apex_model::task::OUTCOME_WORDS`, for the transition to `terminated`.
    pub(crate) outcome: Option<String>,
    pub(crate) subject: String,
    pub(crate) text: String,
    pub(crate) place: Option<String>,
    /// The method, for `selected`.
    pub(crate) method: Option<MethodDetail>,
    /// The effect; `None` if this version of Apex cannot read it.
    pub(crate) effect: Option<Effect>,
}

impl DecisionRow {
    fn of(told: Told) -> DecisionRow {
        let Told { id, at, row, effect, .. } = told;
        let word = |state: Option<TaskState>| state.map(|state| state.word().to_owned());
        DecisionRow {
            id,
            at,
            kind: row.kind.into(),
            task: row.task,
            from: word(row.from),
            to: word(row.to),
            outcome: row.outcome.map(str::to_owned),
            subject: row.subject,
            text: row.text,
            place: row.place,
            method: row.method,
            effect: Some(effect),
        }
    }
}

/// The decisions of a record up to an instant.
#[derive(Clone, Copy)]
pub(crate) struct Decisions<'a> {
    pub(crate) reader: &'a RecordReader,
    /// Later decisions are ignored.
    pub(crate) until: Time,
}

type DecisionResult = Result<Option<DecisionRow>, RecordError>;

/// An effect as stored in the table.
struct DecisionEntry {
    place: usize,
    id: i64,
    at: Time,
    kind: EffectKind,
}

impl DecisionEntry {
    fn moves_to(&self, state: &str) -> bool {
        self.kind.word == "transition" && self.kind.to.is_some_and(|to| to.word() == state)
    }
}

impl Decisions<'_> {
    /// Returns the entries of effects about a task up to the instant, the newest first.
    fn entries<'e>(&self, effects: &'e Effects<'_>, task: TaskId) -> impl Iterator<Item = DecisionEntry> + 'e {
        let until = self.until;
        let entry = |place| {
            Some(DecisionEntry {
                place,
                id: effects.table.id(place),
                at: effects.at(place),
                kind: *effects.table.kind(place)?,
            })
        };
        effects.table.about(task.0).filter_map(entry).filter(move |entry| entry.at <= until)
    }

    /// Returns the newest effect about a task that satisfies `wanted`.
    fn newest(&self, task: TaskId, wanted: impl Fn(&DecisionEntry) -> bool) -> DecisionResult {
        let effects = self.reader.effects()?;
        let found = self.entries(&effects, task).find(wanted);
        found.map(|entry| effects.told(entry.place).map(DecisionRow::of)).transpose()
    }

    /// Returns the effect about a task that satisfies `wanted` and has the least `distance`; of equals the oldest.
    fn nearest<K: Ord>(
        &self,
        task: TaskId,
        wanted: impl Fn(&DecisionEntry) -> bool,
        distance: impl Fn(&DecisionEntry) -> K,
    ) -> DecisionResult {
        let effects = self.reader.effects()?;
        let found = self.entries(&effects, task).filter(wanted).min_by_key(|entry| (distance(entry), entry.id));
        found.map(|entry| effects.told(entry.place).map(DecisionRow::of)).transpose()
    }

    /// Returns the first effect of one kind at `places` that satisfies `wanted`.
    fn first_of(
        &self,
        kind: &str,
        places: impl FnOnce(&Effects<'_>, usize) -> Box<dyn Iterator<Item = usize>>,
        wanted: impl Fn(&Told) -> bool,
    ) -> DecisionResult {
        let effects = self.reader.effects()?;
        let end = effects.table.place_later(self.until);
        for place in places(&effects, end) {
            if effects.table.kind(place).is_some_and(|found| found.word == kind) {
                let told = effects.told(place)?;
                if wanted(&told) {
                    return Ok(Some(DecisionRow::of(told)));
                }
            }
        }
        Ok(None)
    }

    /// Returns the transition to `state` nearest to the decision `id` at its instant `at`; if there is none, the last one before.
    pub(crate) fn transition(&self, task: TaskId, state: &str, (id, at): (i64, Time)) -> DecisionResult {
        let wanted = |entry: &DecisionEntry| entry.moves_to(state) && (entry.id < id || entry.at == at);
        self.nearest(task, wanted, |entry| (entry.at != at, entry.id.abs_diff(id)))
    }

    /// Returns the last transition to `state` before the decision `id`.
    pub(crate) fn transition_before(&self, task: TaskId, state: &str, id: i64) -> DecisionResult {
        self.newest(task, |entry| entry.moves_to(state) && entry.id < id)
    }

    /// Returns the last decision of one kind about the task before the decision `id`.
    pub(crate) fn before(&self, task: TaskId, kind: &str, id: i64) -> DecisionResult {
        self.newest(task, |entry| entry.kind.word == kind && entry.id < id)
    }

    /// Returns the decision of one kind about the task nearest to `id` at its instant.
    pub(crate) fn beside(&self, task: TaskId, kind: &str, (id, at): (i64, Time)) -> DecisionResult {
        self.nearest(task, |entry| entry.kind.word == kind && entry.at == at, |entry| entry.id.abs_diff(id))
    }

    /// Returns the creation or last transition of the task.
    pub(crate) fn last_move(&self, task: TaskId) -> DecisionResult {
        self.newest(task, |entry| matches!(entry.kind.word, "created" | "transition"))
    }

    /// Returns the last binding of a variable of the task before the decision `id`.
    pub(crate) fn binding(&self, task: TaskId, variable: &Symbol, id: i64) -> DecisionResult {
        self.newest_told(task, "bound", |told| {
            let Effect::Decided(Decision { kind: DecisionKind::Bound { variable: bound, .. }, .. }) = &told.effect
            else {
                return false;
            };
            told.id < id && bound == variable
        })
    }

    /// Returns the newest effect of one kind about a task whose text satisfies `wanted`.
    fn newest_told(&self, task: TaskId, kind: &str, wanted: impl Fn(&Told) -> bool) -> DecisionResult {
        let effects = self.reader.effects()?;
        for entry in self.entries(&effects, task).filter(|entry| entry.kind.word == kind) {
            let told = effects.told(entry.place)?;
            if wanted(&told) {
                return Ok(Some(DecisionRow::of(told)));
            }
        }
        Ok(None)
    }

    /// Returns the command with this number.
    pub(crate) fn command(&self, command: u64) -> DecisionResult {
        self.first_of("command", |_, end| Box::new(0..end), |told| is_command(told, command))
    }

    /// Returns the command with this number that `task` sent.
    pub(crate) fn command_of(&self, task: TaskId, command: u64) -> DecisionResult {
        self.newest_told(task, "command", |told| is_command(told, command))
    }

    /// Returns the last command whose form contains `words`.
    pub(crate) fn command_like(&self, words: &str) -> DecisionResult {
        let words = words.to_ascii_lowercase();
        let places = |_: &Effects<'_>, end| -> Box<dyn Iterator<Item = usize>> { Box::new((0..end).rev()) };
        self.first_of("command", places, |told| told.row.subject.to_ascii_lowercase().contains(&words))
    }

    /// Returns the request to a solver with this number.
    pub(crate) fn request(&self, task: TaskId, request: u64) -> DecisionResult {
        self.newest_told(
            task,
            "solve",
            |told| matches!(&told.effect, Effect::Solve(asked) if asked.request.0 == request),
        )
    }

    /// Returns the message `form` that a task of the same agent sent at this instant.
    pub(crate) fn inform(&self, form: &str, at: Time) -> DecisionResult {
        self.first_of("inform", |effects, end| Box::new(places_at(effects, at, end)), |told| told.row.subject == form)
    }

    /// Returns the sample `subject`, `(count x) = 3`, that a task of the same agent published at this instant.
    pub(crate) fn publish(&self, subject: &str, at: Time) -> DecisionResult {
        let places = |effects: &Effects<'_>, end| -> Box<dyn Iterator<Item = usize>> {
            Box::new(places_at(effects, at, end).rev())
        };
        self.first_of("publish", places, |told| told.row.subject == subject)
    }

    /// Calls `take` with every decision about the task, oldest first.
    pub(crate) fn about(&self, task: TaskId, mut take: impl FnMut(DecisionRow)) -> Result<(), RecordError> {
        let effects = self.reader.effects()?;
        let mut entries: Vec<DecisionEntry> = self.entries(&effects, task).collect();
        entries.reverse();
        for entry in entries {
            take(DecisionRow::of(effects.told(entry.place)?));
        }
        Ok(())
    }

    /// Returns the word of the task's state at the end of the interval; `None` if the task had no transition.
    pub(crate) fn state(&self, task: TaskId) -> Result<Option<String>, RecordError> {
        let effects = self.reader.effects()?;
        let state = self.entries(&effects, task).find_map(|entry| entry.kind.to);
        Ok(state.map(|state| state.word().to_owned()))
    }

    /// Returns the identifier of the target with this identifier or name, in any case. Ground by which a fire has grown has no row in the
    /// table of targets: it is known by its states.
    pub(crate) fn target_called(&self, name: &str) -> Result<Option<String>, RecordError> {
        let sql = "SELECT id FROM (SELECT id, name, position FROM target UNION ALL SELECT target, '', 1e18 FROM target_state) \
             WHERE id = ?1 COLLATE NOCASE OR name = ?1 COLLATE NOCASE ORDER BY position LIMIT 1";
        let found = self.reader.connection.query_row(sql, [name], |row| row.get(0)).optional();
        found.map_err(|error| self.reader.damaged("the targets", error))
    }

    /// Returns the identifiers of all targets.
    pub(crate) fn target_ids(&self) -> Result<Vec<String>, RecordError> {
        let read = || {
            let mut statement = self
                .reader
                .connection
                .prepare("SELECT id FROM target UNION SELECT target FROM target_state ORDER BY 1")?;
            statement.query_map([], |row| row.get(0))?.collect::<rusqlite::Result<_>>()
        };
        read().map_err(|error| self.reader.damaged("the targets", error))
    }

    /// Returns the instant at which the target is announced: the earliest instant for a target known from the start, `None` for one that
    /// is never announced.
    pub(crate) fn announced(&self, id: &str) -> Result<Option<Time>, RecordError> {
        let mut announcements = Announcements::default();
        announcements.refresh(self.reader)?;
        Ok(announcements.known_ns(id).map(Time))
    }

    /// Returns the recorded states of the target, in the order of recording.
    pub(crate) fn target_changes(&self, id: &str) -> Result<Vec<TargetChange>, RecordError> {
        let sql = "SELECT t_ns, state, detail FROM target_state WHERE target = ?1 AND t_ns <= ?2 ORDER BY position";
        let read = || {
            let mut statement = self.reader.connection.prepare(sql)?;
            let rows = statement.query_map(params![id, self.until.0], |row| {
                Ok(TargetChange { t_ns: row.get(0)?, state: row.get(1)?, detail: row.get(2)? })
            })?;
            rows.collect::<rusqlite::Result<_>>()
        };
        read().map_err(|error| self.reader.damaged("the targets", error))
    }
}

/// Returns true for the command with this number.
fn is_command(told: &Told, number: u64) -> bool {
    matches!(&told.effect, Effect::Command { command, .. } if command.0 == number)
}

/// Returns the places of the effects at an instant, before the place `end`.
fn places_at(effects: &Effects<'_>, at: Time, end: usize) -> std::ops::Range<usize> {
    let first = effects.table.place_later(Time(at.0.saturating_sub(1)));
    first..effects.table.place_later(at).min(end)
}

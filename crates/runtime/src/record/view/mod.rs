//! The record view: typed answers to the questions that the server and the page ask of a flight record.
//!
//! One file per question. Every answer is plain data (serde) with units in its field names; the page's TypeScript types are generated
//! from these types (`src/typescript.rs`). A record that is still being written is read in the same way; each answer contains what was
//! committed at that moment.
//!
//! An answer for an instant contains what was known at that instant, and nothing that was recorded later: decision 0088.

mod announcements;
mod command_index;
mod commands;
pub(crate) mod decisions;
mod early;
mod effect_index;
mod events;
mod goals;
mod holding_index;
mod holdings;
mod index;
mod known_targets;
mod library;
mod mission;
mod plan;
mod question_index;
mod questions;
mod report;
mod samples;
mod signals;
mod source;
mod state;
mod surroundings;
mod targets;
mod tasks;
mod timeline;
mod track;
mod trouble_index; // english: allow
mod troubles;

pub use command_index::RecordedCommand;
pub use commands::RecordedCommands;
pub use events::{EventRow, Events, EventsQuery};
pub use holdings::{Holding, Holdings, ResourceRow};
pub use library::{DeclaredName, ProcedureRow, ProgramContents, ProgramFile, ProgramText, StepRow};
pub use mission::{Ending, Growth, Mission, RecordStatus};
pub use plan::{LeftOutTarget, PLANS_MAX, PlanInForce, PlannedVisit, Plans, VisitNeed};
pub use question_index::{AskedQuestion, QuestionEnd};
pub use questions::Questions;
pub use report::{Report, Section};
pub use signals::{
    Excursion, SIGNALS_MAX, Signal, SignalKind, SignalLimit, SignalQuery, SignalWindow, SignalWindows, Signals,
    Statistics,
};
pub use source::{Snippet, SourceLine};
pub use state::StateWord;
pub use surroundings::{LandingPlace, Surroundings, Zone};
pub use targets::{Target, TargetChange, Targets};
pub use tasks::{Task, TaskLookup, Tasks, TasksQuery};
pub use timeline::{Band, Bar, Lane, More, Timeline, TimelineQuery};
pub use track::{Track, TrackQuery};
pub use trouble_index::{Trouble, TroubleKind}; // english: allow
pub use troubles::Troubles; // english: allow

use super::effect_access::Effects;
use super::reader::RecordReader;
use crate::error::RecordError;
use announcements::Announcements;
use command_index::CommandIndex;
use early::EarlyReading;
use effect_index::EffectIndex;
use holding_index::HoldingIndex;
use index::TaskIndex;
use known_targets::KnownTargets;
use question_index::QuestionIndex;
use rusqlite::Connection;
use signals::SampleIndex;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use trouble_index::TroubleIndex; // english: allow

/// A flight record opened for queries about one agent. It owns its connection, so it can move to another thread.
pub struct RecordView {
    reader: RecordReader,
    indexes: Arc<Indexes>,
}

/// In-memory indexes of a record for one agent: shared by its views, and updated before each use.
#[derive(Default)]
struct Indexes {
    /// The states of all tasks over time.
    tasks: RwLock<TaskIndex>,
    /// Holders of resources over time.
    holdings: RwLock<HoldingIndex>,
    /// Commands of operators.
    commands: RwLock<CommandIndex>,
    /// Questions to operators.
    questions: RwLock<QuestionIndex>,
    /// Identifiers of the targets.
    targets: Mutex<KnownTargets>,
    /// Times at which late targets became known.
    announcements: RwLock<Announcements>,
    /// Places of times, kinds and texts in the log.
    effects: RwLock<EffectIndex>,
    /// A thread reads the log into its index.
    is_indexed_apart: AtomicBool,
    /// Failures, interruptions and faults.
    faults: RwLock<TroubleIndex>, // english: allow
    /// The samples.
    samples: Mutex<SampleIndex>,
}

impl RecordView {
    /// Opens the record at `path` to read agent number `agent`, from 0 in the order of the declarations. A closed record is read while
    /// it is compared with its seal: the indexes are complete soon after.
    ///
    /// # Errors
    /// Like [`RecordReader::open`].
    pub fn open(path: &Path, agent: usize) -> Result<RecordView, RecordError> {
        // An error of the early reading occurs again in the first query, which reports it.
        let read = |reader: RecordReader, indexes: Arc<Indexes>| drop(RecordView::of(reader, indexes).prepare());
        let early = EarlyReading::begin(path, agent, read);
        let mut reader = RecordReader::open_at(path, agent)?;
        let indexes = early.and_then(|early| early.taken_over_by(&mut reader));
        Ok(RecordView::of(reader, indexes.unwrap_or_default()))
    }

    /// Returns a view of a record that is open.
    pub fn of_reader(reader: RecordReader) -> RecordView {
        RecordView::of(reader, Arc::default())
    }

    fn of(reader: RecordReader, indexes: Arc<Indexes>) -> RecordView {
        RecordView { reader, indexes }
    }

    /// Returns another view of the same record with its own connection, for concurrent queries.
    ///
    /// # Errors
    /// Like [`RecordReader::open`].
    pub fn reopened(&self) -> Result<RecordView, RecordError> {
        Ok(RecordView::of(self.reader.of_agent(self.reader.agent)?, Arc::clone(&self.indexes)))
    }

    /// Returns a view of agent number `agent` of the same record.
    ///
    /// # Errors
    /// Like [`RecordReader::open`].
    pub fn of_agent(&self, agent: usize) -> Result<RecordView, RecordError> {
        Ok(RecordView::of(self.reader.of_agent(agent)?, Arc::default()))
    }

    /// Returns the record's steps, sources and snapshots, which explanations read.
    pub fn reader(&self) -> &RecordReader {
        &self.reader
    }

    /// Builds the indexes for queries about tasks, resources and signals, so that the first query of each kind is fast.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn prepare(&self) -> Result<(), RecordError> {
        drop(self.tasks_index()?);
        drop(self.current(&self.indexes.holdings, HoldingIndex::read_to, HoldingIndex::refresh)?);
        drop(self.current(&self.indexes.faults, TroubleIndex::read_to, TroubleIndex::refresh)?); // english: allow
        drop(self.current(&self.indexes.questions, QuestionIndex::read_to, QuestionIndex::refresh)?);
        self.refresh_commands()?;
        let mut samples = self.indexes.samples.lock().unwrap_or_else(PoisonError::into_inner);
        samples.refresh(&self.reader, &[])
    }

    /// Returns the task index, up to date with the record.
    fn tasks_index(&self) -> Result<RwLockReadGuard<'_, TaskIndex>, RecordError> {
        self.current(&self.indexes.tasks, TaskIndex::read_to, TaskIndex::refresh)
    }

    /// Returns an index, updated to the last effect; `read_to` returns how far an index is. Only a view that must update the index locks
    /// out the other views.
    fn current<'a, T>(
        &self,
        lock: &'a RwLock<T>,
        read_to: fn(&T) -> i64,
        refresh: impl FnOnce(&mut T, &RecordReader, i64) -> Result<(), RecordError>,
    ) -> Result<RwLockReadGuard<'a, T>, RecordError> {
        self.reader.check_growth()?;
        let last = self.reader.effects()?.table.last_id();
        let index = for_reading(lock);
        if read_to(&index) >= last {
            return Ok(index);
        }
        drop(index);
        refresh(&mut for_writing(lock), &self.reader, last)?;
        Ok(for_reading(lock))
    }

    /// Returns the effects of the agent, up to date with the record.
    fn effects(&self) -> Result<Effects<'_>, RecordError> {
        self.reader.check_growth()?;
        self.reader.effects()
    }

    /// Runs queries; `what` names their subject in error messages.
    fn query<T>(&self, what: &str, read: impl FnOnce(&Connection) -> rusqlite::Result<T>) -> Result<T, RecordError> {
        self.reader.check_growth()?;
        read(&self.reader.connection).map_err(|error| self.reader.damaged(what, error))
    }
}

/// Returns a lock for reading. A panic during an update leaves an index that the next update continues.
fn for_reading<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}

/// Returns a lock for writing, as [`for_reading`].
fn for_writing<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::closed_record;
    use std::fs;

    fn begin(path: &Path) -> Option<EarlyReading<Indexes>> {
        EarlyReading::begin(path, 0, |reader, indexes| drop(RecordView::of(reader, indexes).prepare()))
    }

    #[test]
    fn a_closed_record_is_read_early_and_gives_the_same_answers() {
        let (_folder, path) = closed_record();
        let early = begin(&path).unwrap();
        let mut reader = RecordReader::open_at(&path, 0).unwrap();
        let indexes = early.taken_over_by(&mut reader).unwrap();
        let mut view = RecordView::of(reader, indexes);
        let mut plain = RecordView::of(RecordReader::open_at(&path, 0).unwrap(), Arc::default());
        assert_eq!(view.mission(None).unwrap(), plain.mission(None).unwrap());
        let events = view.events(&EventsQuery::default()).unwrap();
        assert_eq!(events, plain.events(&EventsQuery::default()).unwrap());
        assert!(!events.events.is_empty());
    }

    #[test]
    fn a_file_that_changed_since_it_was_read_is_read_again() {
        let (_folder, path) = closed_record();
        let early = begin(&path).unwrap();
        let file = fs::File::options().write(true).open(&path).unwrap();
        file.set_modified(std::time::UNIX_EPOCH).unwrap();
        let mut reader = RecordReader::open_at(&path, 0).unwrap();
        assert!(early.taken_over_by(&mut reader).is_none());
    }

    #[test]
    fn what_was_read_early_is_not_shown_if_a_byte_differs_from_the_seal() {
        let (_folder, path) = closed_record();
        let mut bytes = fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes).unwrap();
        let early = begin(&path).unwrap();
        match RecordReader::open_at(&path, 0) {
            Err(RecordError::Damaged { .. }) => {}
            // The byte is in a free page: the groups of rows fit their seals, and the rows are read after their check.
            Ok(mut reader) => assert!(early.taken_over_by(&mut reader).is_none()),
            Err(error) => panic!("{error}"),
        }
    }

    #[test]
    fn a_record_without_a_seal_is_not_read_before_its_check() {
        let (_folder, path) = closed_record();
        let length = fs::metadata(&path).unwrap().len();
        fs::File::options().write(true).open(&path).unwrap().set_len(length - 64).unwrap();
        assert!(begin(&path).is_none());
        assert!(RecordView::open(&path, 0).is_ok());
    }
}

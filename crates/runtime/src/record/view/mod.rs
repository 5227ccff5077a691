//! The record view: typed answers to the questions that the server and the page ask of a flight record.
//!
//! One file per question. Every answer is plain data (serde) with its units in the names of its fields; the TypeScript
//! types of the page are generated from these types (`src/typescript.rs`). A record that is still being written is
//! read in the same way; each answer shows what was committed when it was asked for.
//!
//! An answer for an instant holds what was known at that instant and nothing that was recorded later: decision 0088.

mod announcements;
mod commands;
pub(crate) mod decisions;
mod events;
mod holding_index;
mod holdings;
mod index;
mod library;
mod mission;
mod plan;
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
mod troubles;

pub use commands::{RecordedCommand, RecordedCommands};
pub use events::{EventRow, Events, EventsQuery};
pub use holdings::{Holding, Holdings, ResourceRow};
pub use library::{DeclaredName, ProcedureRow, ProgramContents, ProgramFile, ProgramText, StepRow};
pub use mission::{Ending, Growth, Mission, RecordStatus};
pub use plan::{LeftOutTarget, PLANS_MAX, PlanInForce, PlannedVisit, Plans};
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
pub use troubles::{Trouble, TroubleKind, Troubles};

use super::reader::RecordReader;
use crate::error::RecordError;
use announcements::Announcements;
use holding_index::HoldingIndex;
use index::TaskIndex;
use rusqlite::Connection;
use signals::SampleIndex;
use std::path::Path;
use std::sync::{Arc, Mutex};

/// A flight record opened for questions about one agent. Owns its connection, so it can move to another thread.
pub struct RecordView {
    reader: RecordReader,
    /// The states of all tasks over time, brought up to date before each use.
    index: TaskIndex,
    /// Who held which resource when, brought up to date before each use.
    holdings: HoldingIndex,
    /// When late targets became known, brought up to date before each use.
    announcements: Announcements,
    /// The samples, shared by all views of one record.
    samples: Arc<Mutex<SampleIndex>>,
}

impl RecordView {
    /// Opens the record at `path` to look at agent number `agent`, from 0 in the order of the declarations.
    ///
    /// # Errors
    /// As [`RecordReader::open`].
    pub fn open(path: &Path, agent: usize) -> Result<RecordView, RecordError> {
        Ok(RecordView::of(RecordReader::open_at(path, agent)?, Arc::default()))
    }

    fn of(reader: RecordReader, samples: Arc<Mutex<SampleIndex>>) -> RecordView {
        RecordView {
            reader,
            index: TaskIndex::default(),
            holdings: HoldingIndex::default(),
            announcements: Announcements::default(),
            samples,
        }
    }

    /// Another view of the same record with a separate connection, for a question at the same time.
    ///
    /// # Errors
    /// As [`RecordReader::open`].
    pub fn reopened(&self) -> Result<RecordView, RecordError> {
        Ok(RecordView::of(self.reader.of_agent(self.reader.agent)?, Arc::clone(&self.samples)))
    }

    /// The record's steps, sources and snapshots, which explanations read.
    pub fn reader(&self) -> &RecordReader {
        &self.reader
    }

    /// The task index, up to date with the record.
    fn tasks_index(&mut self) -> Result<&TaskIndex, RecordError> {
        self.reader.check_growth()?;
        let refreshed = self.index.refresh(&self.reader.connection);
        refreshed.map_err(|error| self.reader.damaged("the tasks", error))?;
        Ok(&self.index)
    }

    /// Runs queries; `what` names in errors what they read.
    fn query<T>(&self, what: &str, read: impl FnOnce(&Connection) -> rusqlite::Result<T>) -> Result<T, RecordError> {
        self.reader.check_growth()?;
        read(&self.reader.connection).map_err(|error| self.reader.damaged(what, error))
    }
}

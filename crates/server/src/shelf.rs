//! The records that one page can show: each agent of the served record, further records, and forks.

use apex_runtime::RecordError;
use apex_runtime::record::RecordReader;
use apex_runtime::record::view::RecordView;
use axum::Router;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// Maximum number of records on a shelf; further ones are left out.
const ENTRIES_MAX: usize = 64;

/// Further records that the page can show, without the shown agent of the served record.
#[derive(Default)]
pub(crate) struct Shelf(Mutex<Vec<ShelfEntry>>);

/// One agent of one record.
#[derive(Clone)]
pub(crate) struct ShelfEntry {
    pub(crate) path: PathBuf,
    pub(crate) agent: usize,
    pub(crate) shown: ShelfRow,
    /// The open record, so that the first query reads this one, whatever file has its name by then. `None` for the served record, which has
    /// connections.
    pub(crate) opened: Option<Arc<Mutex<RecordView>>>,
    /// Routes for queries about it; made at the first query.
    pub(crate) routes: Arc<OnceLock<Router>>,
}

/// An entry in the form of the API.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ShelfRow {
    /// Its number; 0 is the served record with the agent that is shown first.
    id: usize,
    /// The record's file name.
    record: String,
    /// The agent's name.
    agent: String,
    /// The mission's name.
    mission: Option<String>,
    /// Changes of a fork and the instant of the first; null for other records.
    fork: Option<ForkRow>,
}

#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct ForkRow {
    at_ns: i64,
    with: String,
}

impl Shelf {
    pub(crate) fn entries(&self) -> MutexGuard<'_, Vec<ShelfEntry>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds all agents of the record at `path`, except agent number `except`, up to a limit. Returns the number of the first added one.
    ///
    /// # Errors
    /// A record that cannot be read.
    pub(crate) fn stand(&self, path: &Path, except: Option<usize>) -> Result<Option<usize>, RecordError> {
        let reader = RecordReader::open(path)?;
        let (rows, path) = (rows_of(&reader)?, path.to_path_buf());
        let opened = Arc::new(Mutex::new(RecordView::of_reader(reader)));
        Ok(self.stand_rows(rows, (path, Some(opened)), except))
    }

    /// As [`Shelf::stand`], for the served record: opening it again would check the whole file again.
    pub(crate) fn stand_reader(
        &self,
        reader: &RecordReader,
        except: Option<usize>,
    ) -> Result<Option<usize>, RecordError> {
        let rows = rows_of(reader)?;
        Ok(self.stand_rows(rows, (reader.path().to_path_buf(), None), except))
    }

    fn stand_rows(
        &self,
        rows: Vec<ShelfRow>,
        (path, opened): (PathBuf, Option<Arc<Mutex<RecordView>>>),
        except: Option<usize>,
    ) -> Option<usize> {
        let mut entries = self.entries();
        let mut first = None;
        for (agent, row) in rows.into_iter().enumerate().filter(|(agent, _)| Some(*agent) != except) {
            let id = entries.len() + 1;
            if id > ENTRIES_MAX {
                break;
            }
            first.get_or_insert(id);
            let (path, opened, routes) = (path.clone(), opened.clone(), Arc::default());
            entries.push(ShelfEntry { path, agent, shown: ShelfRow { id, ..row }, opened, routes });
        }
        first
    }
}

/// Returns one row for each agent of a record.
pub(crate) fn rows_of(reader: &RecordReader) -> Result<Vec<ShelfRow>, RecordError> {
    let at_ns = reader.meta("forked_at_ns")?.and_then(|text| text.parse().ok());
    let with = reader.meta("forked_with")?;
    let fork = at_ns.zip(with).map(|(at_ns, with)| ForkRow { at_ns, with });
    let record = reader.path().file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let mission = reader.meta("mission")?;
    let row = |agent: &String| ShelfRow {
        id: 0,
        record: record.clone(),
        agent: agent.clone(),
        mission: mission.clone(),
        fork: fork.clone(),
    };
    Ok(reader.agents().iter().map(row).collect())
}

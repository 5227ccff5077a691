//! State that request handlers share: connections to the record, flights, and checks of parameters and of blocking work.

use crate::access::Sessions;
use crate::answer::{ApiError, ApiResult};
use crate::flights::Tower;
use crate::mission_facts::MissionFacts;
use crate::operation::FlightDoor;
use crate::scored_flight::ScoredFlight;
use crate::seen_ground::SeenGround;
use crate::shelf::Shelf;
use crate::what_if::WhatIf;
use apex_model::source::SourceFile;
use apex_runtime::RecordError;
use apex_runtime::record::view::{Growth, RecordStatus, RecordView};
use apex_runtime::record::{RecordReader, RestoredProgram};
use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError, Weak};
use std::time::Duration;
use tokio::sync::Semaphore;

/// Maximum number of queries answered at the same time.
const CONNECTIONS: usize = 8;
/// Time between two looks for the next segment of a record that is being written.
const SEGMENT_LOOK: Duration = Duration::from_millis(500);

/// Checks the PDL sources of a record again, so that an instant can be restored; the server itself has no parser.
pub type LoadSources = Arc<dyn Fn(&[SourceFile]) -> Result<RestoredProgram, String> + Send + Sync>;

/// State shared by all request handlers.
pub(crate) struct AppState {
    /// The record's file; `None` if only missions are served.
    pub(crate) record: Option<PathBuf>,
    /// The number of the agent that is shown.
    pub(crate) agent: usize,
    /// Checks the recorded sources again; without it instants are not restored.
    pub(crate) load: Option<LoadSources>,
    /// Connections to the record, if there is one.
    pub(crate) views: Option<Arc<Views>>,
    /// The record's checked program, loaded at its first use; none if it cannot be loaded.
    pub(crate) program: OnceLock<Option<RestoredProgram>>,
    /// Facts of the record's mission, which never change; empty before the first request.
    pub(crate) facts: OnceLock<Option<MissionFacts>>,
    /// The connection to the run that writes the record, if this program runs it.
    pub(crate) door: Option<FlightDoor>,
    /// The ground that the record's sensors have seen, computed as far as requested.
    pub(crate) seen: SeenGround,
    /// The score of the record's flight, computed as far as requested.
    pub(crate) score: ScoredFlight,
    /// The flights of this server, if it may fly.
    pub(crate) tower: Option<Arc<Tower>>,
    /// The routes on a state; for the records on the shelf.
    pub(crate) routes: fn(Arc<AppState>) -> Router,
    /// Further records that the page can show.
    pub(crate) shelf: Shelf,
    /// Means of continuing flights and of drafting plans; without them the server does neither.
    pub(crate) what_if: Option<WhatIf>,
    /// Callers with their roles.
    pub(crate) sessions: Arc<Sessions>,
    /// Names of this server in addition to its addresses.
    pub(crate) names: Vec<String>,
    /// True if connections are encrypted.
    pub(crate) is_encrypted: bool,
    /// Free places for WebSocket connections.
    pub(crate) live_places: Arc<Semaphore>,
}

impl AppState {
    /// Runs a query on one of the connections; blocks while all are in use.
    pub(crate) fn read<T>(&self, query: impl FnOnce(&mut RecordView) -> ApiResult<T>) -> ApiResult<T> {
        self.views.as_ref().ok_or_else(no_record)?.read(query)
    }

    /// Returns another connection to the record, for longer work. The record was checked when the server started; opening it as a new one
    /// would read the whole file.
    pub(crate) fn reader(&self) -> ApiResult<RecordReader> {
        self.reader_of(self.agent)
    }

    /// As [`AppState::reader`], for agent number `agent`.
    pub(crate) fn reader_of(&self, agent: usize) -> ApiResult<RecordReader> {
        self.read(|view| Ok(view.reader().of_agent(agent)?))
    }

    /// Corrects the growth of the record: while its run is under way in this program the record is live, even without new rows.
    pub(crate) fn with_life(&self, growth: Growth) -> Growth {
        let is_flown = self.door.as_ref().is_some_and(FlightDoor::is_under_way);
        if is_flown && growth.status == RecordStatus::Incomplete {
            return Growth { status: RecordStatus::Live, ..growth };
        }
        growth
    }

    /// Returns the record's checked program; `None` without a loader, and if its sources cannot be loaded.
    pub(crate) fn program(&self) -> Option<RestoredProgram> {
        let load = self.load.as_deref()?;
        let loaded = || self.read(|view| Ok(view.reader().load(load)?)).ok();
        self.program.get_or_init(loaded).clone()
    }

    /// Returns the means of continuing flights and of drafting plans.
    ///
    /// # Errors
    /// If the server was started without them.
    pub(crate) fn what_if(&self) -> ApiResult<&WhatIf> {
        self.what_if.as_ref().ok_or_else(|| {
            ApiError::not_found(
                "this record cannot be continued from here",
                "ask the record that the server was started with: `apex serve RECORD`",
            )
        })
    }

    /// Returns the flights of this server.
    ///
    /// # Errors
    /// If the server was started without a folder of missions.
    pub(crate) fn tower(&self) -> ApiResult<&Tower> {
        self.tower.as_deref().ok_or_else(|| {
            ApiError::not_found(
                "this server flies no missions",
                "start it with a folder of missions: `apex serve --missions FOLDER`",
            )
        })
    }
}

/// Connections to one record. Each query uses one exclusively, so that a long query does not delay the others.
pub(crate) struct Views {
    free: Mutex<Connections>,
    returned: Condvar,
}

/// Connections that no query uses at present.
struct Connections {
    views: Vec<RecordView>,
    /// Number of the record's file, counted up when the record continues in a new file: connections to earlier files are not used again.
    file: u64,
}

impl Views {
    /// Returns the connection `first` and copies of it. They follow a record that is still being written into its next segments.
    ///
    /// # Errors
    /// The record cannot be read, or another connection to it cannot be opened.
    pub(crate) fn new(first: RecordView) -> Result<Arc<Views>, RecordError> {
        let is_growing = !first.growth()?.status.is_final();
        let free = Mutex::new(Connections { views: copies(first)?, file: 0 });
        let views = Arc::new(Views { free, returned: Condvar::new() });
        if is_growing {
            let followed = Arc::downgrade(&views);
            std::thread::spawn(move || follow(&followed));
        }
        Ok(views)
    }

    /// Connects to the file in which the record continues, if there is one. Returns true if the record cannot grow any longer.
    fn look_for_segment(&self) -> Result<bool, RecordError> {
        let looked = self.lend(|view| {
            let is_final = view.growth()?.status.is_final();
            Ok::<_, RecordError>((is_final, view.reader().successor()?, view.reader().agent_number()))
        });
        let (is_final, segment, agent) = looked.unwrap_or(Ok((true, None, 0)))?;
        let Some(segment) = segment else { return Ok(is_final) };
        apex_mission::recording::protect(&segment);
        let views = copies(RecordView::open(&segment, agent)?)?;
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        *free = Connections { views, file: free.file + 1 };
        drop(free);
        self.returned.notify_all();
        Ok(false)
    }

    /// Returns another connection, to the record's first agent.
    ///
    /// # Errors
    /// A record that has changed since it was checked.
    pub(crate) fn reader(&self) -> Result<RecordReader, RecordError> {
        self.lend(|view| view.reader().of_agent(0))
            .unwrap_or_else(|| Err(RecordError::Question("no connection".into())))
    }

    fn read<T>(&self, query: impl FnOnce(&mut RecordView) -> ApiResult<T>) -> ApiResult<T> {
        self.lend(query).unwrap_or_else(|| Err(no_record()))
    }

    /// Waits for a connection; `None` if there is none.
    fn lend<T>(&self, query: impl FnOnce(&mut RecordView) -> T) -> Option<T> {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let free = self.returned.wait_while(free, |free| free.views.is_empty());
        let mut free = free.unwrap_or_else(PoisonError::into_inner);
        let (view, file) = (free.views.pop()?, free.file);
        drop(free);
        // Also after a panic of the query: it has written nothing, so the connection is as good as before.
        let mut lent = Lent { views: self, view: Some(view), file };
        lent.view.as_mut().map(query)
    }
}

/// A connection in use; it is returned when it is dropped.
struct Lent<'a> {
    views: &'a Views,
    view: Option<RecordView>,
    /// The value of [`Connections::file`] when the connection was lent.
    file: u64,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        let mut free = self.views.free.lock().unwrap_or_else(PoisonError::into_inner);
        if free.file == self.file {
            free.views.extend(self.view.take());
        }
        drop(free);
        self.views.returned.notify_one();
    }
}

/// Returns a view and copies of it.
fn copies(first: RecordView) -> Result<Vec<RecordView>, RecordError> {
    let mut views = Vec::with_capacity(CONNECTIONS);
    for _ in 1..CONNECTIONS {
        views.push(first.reopened()?);
    }
    views.push(first);
    Ok(views)
}

/// Looks for the next segment of a record that is being written, until the record is complete or the server ends.
fn follow(views: &Weak<Views>) {
    loop {
        std::thread::sleep(SEGMENT_LOOK);
        let Some(views) = views.upgrade() else { return };
        // A segment that cannot be read yet is read at the next look.
        if views.look_for_segment().unwrap_or(false) {
            return;
        }
    }
}

/// Returns the answer to questions about a record of a server that serves none.
pub(crate) fn no_record() -> ApiError {
    ApiError::not_found("this server serves no flight record", "start it with one: `apex serve RECORD`")
}

pub(crate) type Shared = State<Arc<AppState>>;
pub(crate) type QueryParams<T> = Result<Query<T>, QueryRejection>;

/// Returns the parameters of a request, or the error in them.
pub(crate) fn checked<T>(params: QueryParams<T>) -> ApiResult<T> {
    params.map(|Query(query)| query).map_err(|rejection| {
        ApiError::bad_request(
            rejection.body_text(),
            "times are whole nanoseconds of mission time; docs/reference/server-api.md lists all parameters",
        )
    })
}

/// Does blocking work outside of the network threads.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> ApiResult<T> + Send + 'static) -> ApiResult<T> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|error| {
        Err(ApiError {
            status: StatusCode::INTERNAL_SERVER_ERROR,
            error: format!("the query was interrupted: {error}"),
            help: "this is a fault of Apex; please report it with the record".into(),
        })
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use apex_mission::Mission;
    use apex_mission::deliberation::PlanningResources;
    use apex_mission::flight::MissionFlight;
    use apex_runtime::record::RecordOptions;
    use std::path::Path;

    /// Flies for two minutes with a first file of at most 200 kB; returns the end of the flight.
    fn fly_into_a_segment(first: &Path, spare: &Path) -> i64 {
        let mission = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions/first-picture");
        let mission = Arc::new(Mission::load(&mission).unwrap());
        let options = RecordOptions {
            bytes_max: Some(200_000),
            spare_folder: Some(spare.to_path_buf()),
            ..RecordOptions::default()
        };
        let mut recorder = apex_simulation::create_record_with(first, &mission, Some(1), options).unwrap();
        let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
        let terms = MissionFlight::terms(&mission, None);
        let flown = apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut []).unwrap();
        assert_ne!(recorder.path(), first, "the record did not continue in a segment");
        flown.end.at.0
    }

    #[test]
    fn connections_change_over_to_the_segment_in_which_a_record_continues() {
        let (folder, spare) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let first = folder.path().join("flight.apex");
        let end_ns = fly_into_a_segment(&first, spare.path());
        let views = Views::new(RecordView::open(&first, 0).unwrap()).unwrap();
        let growth = |views: &Views| views.read(|view| Ok(view.growth()?)).unwrap();
        let before = growth(&views);
        assert!(before.end_ns < end_ns && !before.status.is_final(), "{before:?}");
        // The thread of the server does this, too; whichever comes first.
        while !views.look_for_segment().unwrap() {}
        let after = growth(&views);
        assert_eq!((after.end_ns, after.status), (end_ns, RecordStatus::Complete));
        assert!(after.batches > before.batches);
        let seen = views.read(|view| Ok(view.mission(Some(0))?.record)).unwrap();
        assert!(seen.contains("-segment-"), "{seen}");
        // All connections are of the new file.
        assert_eq!(views.free.lock().unwrap().views.len(), CONNECTIONS);
    }
}

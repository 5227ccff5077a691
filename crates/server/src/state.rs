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
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use tokio::sync::Semaphore;

/// Maximum number of queries answered at the same time.
const CONNECTIONS: usize = 8;

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
    pub(crate) views: Option<Views>,
    /// The record's checked program, loaded at its first use; the inner `None` if it cannot be loaded.
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
    free: Mutex<Vec<RecordView>>,
    returned: Condvar,
}

impl Views {
    /// Returns the connection `first` and copies of it.
    ///
    /// # Errors
    /// A view of the same record with another connection.
    pub(crate) fn new(first: RecordView) -> Result<Views, RecordError> {
        let mut views = Vec::with_capacity(CONNECTIONS);
        for _ in 1..CONNECTIONS {
            views.push(first.reopened()?);
        }
        views.push(first);
        Ok(Views { free: Mutex::new(views), returned: Condvar::new() })
    }

    /// Another connection, to the record's first agent.
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
        let mut free = self.returned.wait_while(free, |free| free.is_empty()).unwrap_or_else(PoisonError::into_inner);
        let view = free.pop()?;
        drop(free);
        // A panic of the query does not matter: it has written nothing, so the connection can be used again.
        let mut lent = Lent { views: self, view: Some(view) };
        lent.view.as_mut().map(query)
    }
}

/// A connection in use; it is returned when it is dropped.
struct Lent<'a> {
    views: &'a Views,
    view: Option<RecordView>,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        self.views.free.lock().unwrap_or_else(PoisonError::into_inner).extend(self.view.take());
        self.views.returned.notify_one();
    }
}

/// Returns the error for requests about a record if the server serves no record.
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

/// Does blocking work off the network threads.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> ApiResult<T> + Send + 'static) -> ApiResult<T> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|error| {
        Err(ApiError {
            status: StatusCode::INTERNAL_SERVER_ERROR,
            error: format!("the query was interrupted: {error}"),
            help: "this is a fault of Apex; please report it with the record".into(),
        })
    })
}

//! What request handlers share: the record's connection, the flights, and how they check parameters and block.

use crate::answer::{Answer, ApiError};
use crate::flights::Tower;
use apex_model::source::SourceFile;
use apex_runtime::record::Program;
use apex_runtime::record::view::RecordView;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Checks the PDL sources of a record again, so that an instant can be restored; the server knows no syntax.
pub type LoadSources = Arc<dyn Fn(&[SourceFile]) -> Result<Program, String> + Send + Sync>;

/// State shared by all request handlers.
pub(crate) struct AppState {
    /// The record's file; `None` if only missions are served.
    pub(crate) record: Option<PathBuf>,
    /// The number of the agent that is shown.
    pub(crate) agent: usize,
    /// Checks the recorded sources again; without it instants are not restored.
    pub(crate) load: Option<LoadSources>,
    /// The shared connection to the record, if there is one.
    pub(crate) view: Option<Mutex<RecordView>>,
    /// The flights of this server, if it may fly.
    pub(crate) tower: Option<Arc<Tower>>,
    /// True if only this machine can reach the server.
    pub(crate) loopback: bool,
}

impl AppState {
    /// Reads with the shared connection; blocks while another request reads.
    pub(crate) fn read<T>(&self, query: impl FnOnce(&mut RecordView) -> Answer<T>) -> Answer<T> {
        // A query that panicked has written nothing: the connection is as good as before.
        let view = self.view.as_ref().ok_or_else(no_record)?;
        let mut view = view.lock().unwrap_or_else(PoisonError::into_inner);
        query(&mut view)
    }

    /// The flights of this server.
    ///
    /// # Errors
    /// It was started without a folder of missions.
    pub(crate) fn tower(&self) -> Answer<&Tower> {
        self.tower.as_deref().ok_or_else(|| {
            ApiError::not_found(
                "this server flies no missions",
                "start it with a folder of missions: `apex serve --missions FOLDER`",
            )
        })
    }
}

/// The answer to questions about a record of a server that serves none.
pub(crate) fn no_record() -> ApiError {
    ApiError::not_found("this server serves no flight record", "start it with one: `apex serve RECORD`")
}

pub(crate) type Shared = State<Arc<AppState>>;
pub(crate) type QueryParams<T> = Result<Query<T>, QueryRejection>;

/// The parameters of a request, or what is wrong with them.
pub(crate) fn checked<T>(params: QueryParams<T>) -> Answer<T> {
    params.map(|Query(query)| query).map_err(|rejection| {
        ApiError::bad_request(
            rejection.body_text(),
            "times are whole nanoseconds of mission time; docs/reference/server-api.md lists all parameters",
        )
    })
}

/// Does blocking work off the network threads.
pub(crate) async fn blocking<T: Send + 'static>(work: impl FnOnce() -> Answer<T> + Send + 'static) -> Answer<T> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|error| {
        Err(ApiError {
            status: StatusCode::INTERNAL_SERVER_ERROR,
            error: format!("the query broke off: {error}"),
            help: "this is a fault of Apex; please report it with the record".into(),
        })
    })
}

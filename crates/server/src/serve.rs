//! Serves a record: opens it, binds the address, runs until Ctrl-C. Owns its tokio runtime, so that callers need none.

use crate::access::{AccessToken, Sessions};
use crate::flights::{FlightOptions, Tower};
use crate::listening::{TlsError, TlsIdentity, serve_connections};
use crate::operation::{FlightDoor, ReadDatum};
use crate::router::router;
use crate::scored_flight::ScoredFlight;
use crate::seen_ground::SeenGround;
use crate::shelf::Shelf;
use crate::state::{AppState, LoadSources, Views};
use crate::what_if::WhatIf;
use apex_mission::deliberation::PlanningResources;
use apex_model::time::Time;
use apex_runtime::RecordError;
use apex_runtime::record::view::RecordView;
use std::future::Future;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use tokio::sync::Semaphore;

/// Longest time for which open connections may delay the end of the program.
const STOP_PATIENCE: Duration = Duration::from_secs(1);

/// Time for which the index of the log is built without a pause; then follows `INDEXING_PAUSE`.
const INDEXING_TURN: Duration = Duration::from_millis(20);
const INDEXING_PAUSE: Duration = Duration::from_millis(10);
/// Maximum number of simultaneous WebSockets.
const LIVE_PLACES: usize = 64;

/// Tokens, names and encryption of a server.
#[derive(Default)]
pub struct AccessOptions {
    /// Tokens of operators and programs. A public address needs at least one; on a loopback address without tokens, every caller is the
    /// local user.
    pub tokens: Vec<AccessToken>,
    /// Names of this server in addition to its addresses: requests under other names are refused.
    pub names: Vec<String>,
    /// Encrypts connections; a public address needs it.
    pub tls: Option<TlsIdentity>,
}

/// Options of a server.
pub struct ServeOptions {
    /// The flight record, finished or still being written; `None` serves missions and flights only.
    pub record: Option<PathBuf>,
    /// The number of the agent to show, from 0, in the order of their declarations.
    pub agent: usize,
    /// The address to bind to; `127.0.0.1` keeps the record on this machine.
    pub address: IpAddr,
    /// The port; 0 for any free one.
    pub port: u16,
    /// Restores instants for `/api/why`; without it the answers come from the record's decisions alone.
    pub load: Option<LoadSources>,
    /// The connection to the run that writes the record; without it the page is read-only.
    pub door: Option<FlightDoor>,
    /// Further records that the page can show.
    pub others: Vec<PathBuf>,
    /// Planners and the reader of forms, for continuing flights with changes and for drafts of plans.
    pub what_if: Option<(PlanningResources, ReadDatum)>,
    /// The missions that the server may fly; `None` if it only reads.
    pub flights: Option<FlightOptions>,
    /// Tokens, names and encryption.
    pub access: AccessOptions,
    /// Called once with the page's address (`http://127.0.0.1:8040/`) when requests are answered.
    pub ready: Box<dyn FnOnce(&str) + Send>,
}

/// Failure to serve.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The file cannot be opened, or is not a flight record.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Another program has the port.
    #[error(
        "cannot serve on {0}: another program already uses that port; stop it, or choose another port with `--port` (0 takes any free one)"
    )]
    PortInUse(SocketAddr),
    /// The address cannot be bound for another reason.
    #[error(
        "cannot serve on {address}: {source}; give an address of this machine with `--address`, and a port above 1023 with `--port`"
    )]
    Bind {
        /// Requested address.
        address: SocketAddr,
        /// Error of the system.
        source: io::Error,
    },
    /// Other machines would reach the server without tokens, or without encryption.
    #[error(
        "cannot serve on {address} without {missing}: other machines reach this address; serve on 127.0.0.1, or state {missing}"
    )]
    Open {
        /// The requested address.
        address: SocketAddr,
        /// The missing option.
        missing: &'static str,
    },
    /// The certificate cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The network or the threads failed while serving.
    #[error("the server stopped: {0}; start it again, and if it stops again check the system's limits (`ulimit -a`)")]
    Stopped(io::Error),
}

/// Serves the record and flies missions until Ctrl-C (or SIGTERM); blocks. Flights under way are ended cleanly.
///
/// # Errors
/// If the record cannot be read, the port is not available, or the network fails; each error states the remedy.
pub fn serve(options: ServeOptions) -> Result<(), ServeError> {
    let ServeOptions { record, agent, load, door, others, what_if, flights, access, ready, address, port } = options;
    let view = record.as_ref().map(|record| RecordView::open(record, agent)).transpose()?;
    let background = view.as_ref().map(RecordView::reopened).transpose()?;
    let shelf = filled_shelf(view.as_ref(), agent, &others)?;
    let views = view.map(Views::new).transpose()?;
    if let Some(view) = background {
        std::thread::spawn(move || index_log(&view));
    }
    let what_if = what_if.map(|(means, read)| WhatIf::new(means, read));
    let forks = what_if.as_ref().map(|what_if| Arc::clone(&what_if.forks));
    let tower = flights.map(|flights| Arc::new(Tower::new(flights)));
    let asked = SocketAddr::new(address, port);
    let loopback = address.is_loopback();
    let missing =
        if access.tokens.is_empty() { Some("tokens") } else { access.tls.is_none().then_some("a certificate") };
    if let Some(missing) = missing.filter(|_| !loopback) {
        return Err(ServeError::Open { address: asked, missing });
    }
    let tls = access.tls.as_ref().map(TlsIdentity::config).transpose()?;
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(ServeError::Stopped)?;
    let flown = tower.clone();
    let result = runtime.block_on(async move {
        let listener = tokio::net::TcpListener::bind(asked).await.map_err(|source| bind_error(asked, source))?;
        let bound = listener.local_addr().map_err(ServeError::Stopped)?;
        let scheme = if tls.is_some() { "https" } else { "http" };
        ready(&format!("{scheme}://{bound}/"));
        let closing = tower.clone();
        let stop = stop_asked()?;
        let stop = async move {
            stop.await;
            // Flights and connections are ended at the same time.
            if let Some(tower) = closing {
                tower.close();
            }
        };
        let state = AppState {
            record,
            agent,
            load,
            views,
            program: OnceLock::new(),
            facts: OnceLock::new(),
            door,
            seen: SeenGround::default(),
            score: ScoredFlight::default(),
            tower,
            routes: router,
            shelf,
            what_if,
            sessions: Arc::new(Sessions::new(access.tokens, loopback, bound.port())),
            names: access.names,
            is_encrypted: tls.is_some(),
            live_places: Arc::new(Semaphore::new(LIVE_PLACES)),
        };
        serve_connections(listener, router(score_early(state)), tls, stop, STOP_PATIENCE).await;
        Ok(())
    });
    if let Some(forks) = forks {
        forks.close();
    }
    // Every flight is ended cleanly, whatever ended the server.
    if let Some(tower) = flown {
        tower.close();
        tower.join();
    }
    runtime.shutdown_timeout(STOP_PATIENCE);
    result
}

/// Returns the shelf with the record and the other records.
fn filled_shelf(record: Option<&RecordView>, agent: usize, others: &[PathBuf]) -> Result<Shelf, ServeError> {
    let shelf = Shelf::default();
    if let Some(record) = record {
        shelf.stand_reader(record.reader(), Some(agent))?;
    }
    for other in others {
        shelf.stand(other, None)?;
    }
    Ok(shelf)
}

/// Computes the score of the whole record on a thread, so that the first request finds it or a part of it.
fn score_early(state: AppState) -> Arc<AppState> {
    let state = Arc::new(state);
    if state.views.is_some() {
        let state = Arc::clone(&state);
        // An error occurs again in the first request, which reports it.
        std::thread::spawn(move || state.reader_of(0).and_then(|reader| state.score.at(&reader, Time::END)).is_ok());
    }
    state
}

/// Reads the log of the record into its index, in turns with pauses. A query that needs steps after the indexed ones reads them itself.
fn index_log(view: &RecordView) {
    // An error occurs again in the next query, which reports it.
    let _ = view.prepare();
    while view.index_effects(INDEXING_TURN).is_ok_and(|is_done| !is_done) {
        std::thread::sleep(INDEXING_PAUSE);
    }
}

fn bind_error(address: SocketAddr, source: io::Error) -> ServeError {
    match source.kind() {
        io::ErrorKind::AddrInUse => ServeError::PortInUse(address),
        _ => ServeError::Bind { address, source },
    }
}

/// Returns a future that completes when the user or the system requests the program to stop.
#[cfg(unix)]
fn stop_asked() -> Result<impl Future<Output = ()> + Send + 'static, ServeError> {
    use tokio::signal::unix::{SignalKind, signal};
    let mut interrupt = signal(SignalKind::interrupt()).map_err(ServeError::Stopped)?;
    let mut terminate = signal(SignalKind::terminate()).map_err(ServeError::Stopped)?;
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    })
}

/// Returns a future that completes when the user requests the program to stop.
#[cfg(not(unix))]
fn stop_asked() -> Result<impl Future<Output = ()> + Send + 'static, ServeError> {
    Ok(async {
        // Without the signal the server can still be ended by the system.
        if tokio::signal::ctrl_c().await.is_err() {
            std::future::pending::<()>().await;
        }
    })
}

//! Starts, finds and stops flights, and limits their number.

use crate::answer::{ApiError, ApiResult};
use crate::flights::FlightOptions;
use crate::flights::catalogue::{MissionEntry, folder_of, missions};
use crate::flights::flight::{Flight, FlightState, Preparation};
use crate::flights::plans;
use crate::flights::request::{FlightRequest, PlanParams};
use crate::operation::FlightDoor;
use apex_mission::Mission;
use apex_mission::flight::MissionFlight;
use apex_runtime::RunSettings;
use axum::http::StatusCode;
use std::collections::VecDeque;
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, TryAcquireError};

/// Maximum number of simultaneous flights: each uses a core, and so do its solvers.
const FLIGHTS_MAX: usize = 2;
/// Maximum number of simultaneous plans without a flight.
const PLANS_MAX: usize = 1;
/// Maximum number of flights that the server remembers; the oldest ended ones are forgotten, their records stay.
const REMEMBERED_MAX: usize = 100;
/// Stack of a flight's thread: as much as the main thread of `apex fly` has.
const STACK_BYTES: usize = 8 << 20;

/// The flights of a server.
pub(crate) struct Tower {
    options: FlightOptions,
    flying: Arc<Semaphore>,
    planning: Arc<Semaphore>,
    known: Mutex<KnownFlight>,
}

#[derive(Default)]
struct KnownFlight {
    last_id: u64,
    flights: VecDeque<Arc<Flight>>,
    threads: Vec<JoinHandle<()>>,
    closed: bool,
}

impl Tower {
    /// Returns a tower without flights.
    pub(crate) fn new(options: FlightOptions) -> Tower {
        let (flying, planning) = (Arc::new(Semaphore::new(FLIGHTS_MAX)), Arc::new(Semaphore::new(PLANS_MAX)));
        Tower { options, flying, planning, known: Mutex::default() }
    }

    /// Lists the missions.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub(crate) fn missions(&self) -> ApiResult<Vec<MissionEntry>> {
        missions(&self.options.missions)
    }

    /// Plans for the mission called `name`; the plan is JSON.
    ///
    /// # Errors
    /// A wrong name or budget, a mission that does not load, too many plans at a time, no plan.
    pub(crate) fn plan(&self, name: &str, params: &PlanParams) -> ApiResult<String> {
        let folder = folder_of(&self.options.missions, name)?;
        let budget = params.budget()?;
        let _place = place(&self.planning, || format!("{PLANS_MAX} plan is being made, which is the limit"))?;
        plans::plan(Mission::load(&folder)?, budget, &self.options.means)
    }

    /// Starts a flight.
    ///
    /// # Errors
    /// An invalid request, a mission that does not load or cannot be simulated, too many simultaneous flights, a record that cannot be
    /// written, a server that is shutting down.
    pub(crate) fn start(&self, request: FlightRequest) -> ApiResult<FlightState> {
        let folder = folder_of(&self.options.missions, &request.mission)?;
        let (until, pace) = (request.until()?, request.pace()?);
        let place = place(&self.flying, || format!("{FLIGHTS_MAX} missions are being flown, which is the limit"))?;
        let mission = Arc::new(Mission::load(&folder)?);
        let pace = apex_simulation::pace_of(&mission, pace)?;
        let seed = request.seed.unwrap_or(mission.settings.seed);
        // A mission that cannot be simulated leaves no record.
        apex_simulation::world(&mission, Some(seed))?;
        let (id, record) = self.reserve(&request.mission)?;
        let recorder = apex_simulation::create_record(&record, &mission, Some(seed))?;
        let (door, controls) = FlightDoor::new(&mission, pace, Arc::clone(&self.options.read));
        // The server sends no further commands, so the run need not wait for any.
        door.be_quiet();
        let terms = RunSettings {
            pace,
            controls: Some(controls),
            authority: door.authority(),
            ..MissionFlight::terms(&mission, until)
        };
        let flight = Arc::new(Flight::new(id, request.mission, record, seed, door));
        let preparation = Preparation { mission, means: self.options.means.clone(), terms, recorder };
        self.launch(&flight, preparation, place)?;
        Ok(flight.state())
    }

    /// Reserves the next number whose record does not exist yet, and creates its empty file so that no other program uses it.
    fn reserve(&self, mission: &str) -> ApiResult<(u64, PathBuf)> {
        let mut known = self.known();
        loop {
            known.last_id += 1;
            let id = known.last_id;
            let record = self.options.records.join(format!("{mission}-{id}.apex"));
            match std::fs::File::create_new(&record) {
                Ok(_) => return Ok((id, record)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => {
                    return Err(failure(
                        format!("the flight record {} cannot be written: {error}", record.display()),
                        "start the server again with a folder that can be written (`--records`)",
                    ));
                }
            }
        }
    }

    fn launch(&self, flight: &Arc<Flight>, preparation: Preparation, place: OwnedSemaphorePermit) -> ApiResult<()> {
        let mut known = self.known();
        if known.closed {
            return Err(closing());
        }
        let flown = Arc::clone(flight);
        let thread = std::thread::Builder::new()
            .name(format!("flight-{}", flight.id))
            .stack_size(STACK_BYTES)
            .spawn(move || flown.fly(preparation, place))
            .map_err(|error| {
                failure(format!("no thread can be started: {error}"), "check the system's limits (`ulimit -a`)")
            })?;
        known.threads.retain(|thread| !thread.is_finished());
        known.threads.push(thread);
        known.flights.push_back(Arc::clone(flight));
        while known.flights.len() > REMEMBERED_MAX
            && let Some(oldest) = known.flights.iter().position(|flight| !flight.is_flying())
        {
            known.flights.remove(oldest);
        }
        Ok(())
    }

    /// Returns all flights that are remembered, in the order of their start.
    pub(crate) fn flights(&self) -> Vec<FlightState> {
        self.known().flights.iter().map(|flight| flight.state()).collect()
    }

    /// Returns the flight with this number.
    ///
    /// # Errors
    /// If there is none, or it was removed.
    pub(crate) fn flight(&self, id: u64) -> ApiResult<Arc<Flight>> {
        self.known().flights.iter().find(|flight| flight.id == id).cloned().ok_or_else(|| {
            ApiError::not_found(
                format!("there is no flight {id}"),
                format!("`/api/flights` lists the last {REMEMBERED_MAX}; the records of earlier ones are files"),
            )
        })
    }

    /// Starts no more flights, and requests those in progress to end.
    pub(crate) fn close(&self) {
        self.flying.close();
        self.planning.close();
        let mut known = self.known();
        known.closed = true;
        known.flights.iter().for_each(|flight| flight.stop());
    }

    /// Waits until the flights have ended and their records are closed.
    pub(crate) fn join(&self) {
        let threads = std::mem::take(&mut self.known().threads);
        // A panic ends only the flight in which it occurs.
        threads.into_iter().for_each(|thread| thread.join().unwrap_or_default());
    }

    fn known(&self) -> MutexGuard<'_, KnownFlight> {
        // Every update is complete when the lock is released, even by a panic, so a poisoned lock is usable.
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns a permit of the limited number.
fn place(places: &Arc<Semaphore>, full: impl FnOnce() -> String) -> ApiResult<OwnedSemaphorePermit> {
    Arc::clone(places).try_acquire_owned().map_err(|refused| match refused {
        TryAcquireError::NoPermits => ApiError {
            status: StatusCode::TOO_MANY_REQUESTS,
            error: full(),
            help: "wait for the end of one; `POST /api/flights/ID/stop` ends a flight".into(),
        },
        TryAcquireError::Closed => closing(),
    })
}

fn closing() -> ApiError {
    ApiError {
        status: StatusCode::SERVICE_UNAVAILABLE,
        error: "the server is being stopped".into(),
        help: "start it again with `apex serve`".into(),
    }
}

fn failure(error: String, help: &str) -> ApiError {
    ApiError { status: StatusCode::INTERNAL_SERVER_ERROR, error, help: help.into() }
}

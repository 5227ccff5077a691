//! `/api/forks`: continues the served flight from an instant with changes, in the built-in simulator, one fork at a time.

use crate::answer::{ApiError, ApiResult};
use crate::state::{AppState, Shared, blocking, no_record};
use crate::what_if::fork_list::{FORKS_MAX, ForkEnd, ForkFlight, ForkState};
use crate::what_if::request::ForkRequest;
use apex_mission::comparison::Comparison;
use apex_mission::error::MissionResult;
use apex_mission::fork::{Changes, scaled_wind};
use apex_mission::{recorded, recording};
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::Control;
use apex_runtime::ports::Observer;
use apex_simulation::{ForkTerms, Forked, WorldChanges, check_fork, fork};
use axum::Json;
use axum::extract::rejection::{JsonRejection, PathRejection};
use axum::extract::{Path as UrlPath, State};
use axum::http::StatusCode;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex};

struct ForkProgress<'a>(&'a AtomicI64);

impl Observer for ForkProgress<'_> {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        self.0.store(batch.now.0, Ordering::Relaxed);
        Ok(())
    }
}

pub(crate) async fn list(State(state): Shared) -> ApiResult<Json<Vec<ForkState>>> {
    Ok(Json(state.what_if()?.forks.list().iter().map(|flight| flight.state()).collect()))
}

pub(crate) async fn stop(
    State(state): Shared,
    id: Result<UrlPath<usize>, PathRejection>,
) -> ApiResult<(StatusCode, Json<ForkState>)> {
    let UrlPath(id) =
        id.map_err(|rejection| ApiError::bad_request(rejection.body_text(), "`/api/forks` lists the forks"))?;
    let flight = state.what_if()?.forks.list().iter().find(|flight| flight.id == id).cloned();
    let flight =
        flight.ok_or_else(|| ApiError::not_found(format!("fork {id} not found"), "`/api/forks` lists the forks"))?;
    flight.stop();
    Ok((StatusCode::ACCEPTED, Json(flight.state())))
}

/// Starts a fork; answers when it flies, or with the reason for which it cannot.
pub(crate) async fn begin(
    State(state): Shared,
    body: Result<Json<ForkRequest>, JsonRejection>,
) -> ApiResult<(StatusCode, Json<ForkState>)> {
    let Json(request) = body.map_err(|rejection| ApiError {
        status: rejection.status(),
        error: rejection.body_text(),
        help: "send for example `{\"at_ns\": 32400000000000, \"wind_factor\": 2}` as application/json".into(),
    })?;
    let flight = blocking(move || start(&state, &request)).await?;
    Ok((StatusCode::CREATED, Json(flight.state())))
}

fn start(state: &Arc<AppState>, request: &ForkRequest) -> ApiResult<Arc<ForkFlight>> {
    let what_if = state.what_if()?;
    let record = state.record.clone().ok_or_else(no_record)?;
    let changes = request.changes(&*what_if.read)?;
    check_fork(&state.reader()?, Time(request.at_ns), &changes)?;
    let mut forks = what_if.forks.list();
    if forks.iter().any(|flight| flight.end().is_none()) {
        return Err(ApiError {
            status: StatusCode::TOO_MANY_REQUESTS,
            error: "another fork is flying".into(),
            help: "wait for its end, or stop it".into(),
        });
    }
    if forks.len() >= FORKS_MAX {
        forks.remove(0);
    }
    let id = forks.last().map_or(1, |flight| flight.id + 1);
    let (controls, receiver) = mpsc::channel();
    let flight = Arc::new(ForkFlight {
        id,
        at_ns: request.at_ns,
        with: request.words().unwrap_or_else(|| "nothing is changed".into()),
        path: free_path(&record),
        now_ns: AtomicI64::new(0),
        controls: Mutex::new(controls),
        end: Mutex::default(),
    });
    forks.push(Arc::clone(&flight));
    drop(forks);
    let (state, request, flown) = (Arc::clone(state), request.clone(), Arc::clone(&flight));
    std::thread::spawn(move || {
        let end = match fly(&state, &request, changes, &flown, receiver) {
            Ok(text) => ForkEnd::Ended(state.shelf.stand(&flown.path, None).ok().flatten(), text),
            Err(error) => ForkEnd::Failed(error.into()),
        };
        recording::release(&flown.path);
        *flown.end() = Some(end);
    });
    Ok(flight)
}

/// Returns the first path that does not exist among `flight-fork-1.apex`, `flight-fork-2.apex`, .. for the record `flight.apex`.
fn free_path(record: &Path) -> PathBuf {
    let stem = record.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let named = |number: u32| record.with_file_name(format!("{stem}-fork-{number}.apex"));
    (1..).map(named).find(|path| !path.exists()).unwrap_or_else(|| named(0))
}

fn fly(
    state: &AppState,
    request: &ForkRequest,
    changes: Changes,
    flight: &ForkFlight,
    controls: Receiver<Control>,
) -> MissionResult<String> {
    let (Some(views), Some(what_if)) = (&state.views, &state.what_if) else { return Ok(String::new()) };
    let reader = views.reader().map_err(recording::read)?;
    let wind = match request.wind_factor {
        Some(factor) => recorded::mission_of(&reader)?.map(|mission| scaled_wind(&mission.weather, factor)),
        None => None,
    };
    let world = WorldChanges { wind, seed: request.seed };
    let mut progress = ForkProgress(&flight.now_ns);
    let terms = ForkTerms { until: None, controls: Some(controls), observer: Some(&mut progress) };
    let at = Time(request.at_ns);
    let what = (changes, world, request.words());
    let Forked { recorded, forked } = fork(&reader, at, what, what_if.means.clone(), terms, &flight.path)?;
    Ok(Comparison { headings: ["recorded", "forked"], reports: [&recorded, &forked.report], from: at }.text())
}

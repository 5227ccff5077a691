//! The addresses of operation: for the flight of the served record, and for flights that the server started.

use crate::access::Caller;
use crate::answer::{ApiError, ApiResult};
use crate::operation::alarms::{self, StatedAlarm};
use crate::operation::door::{CommandRequest, CommandState, FlightDoor};
use crate::operation::request::Wish;
use crate::state::{AppState, Shared, blocking};
use apex_runtime::UniqueJson;
use apex_runtime::authority::Actor;
use apex_runtime::commands::Author;
use apex_runtime::record::view::RecordView;
use axum::extract::rejection::{JsonRejection, PathRejection};
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Json, Router};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Bytes of the largest body: a message of the longest size, escaped.
const BODY_MAX_BYTES: usize = 16 << 10;
/// Time between two checks of whether a command has an end.
const LOOK: Duration = Duration::from_millis(10);

/// Returns the routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/operation", get(operation))
        .route("/api/commands", post(command))
        .route("/api/flights/{id}/operation", get(flight_operation))
        .route("/api/flights/{id}/commands", post(flight_command))
        .layer(DefaultBodyLimit::max(BODY_MAX_BYTES))
}

type Who = Extension<Caller>;
type CommandBody = Result<Json<UniqueJson>, JsonRejection>;

/// Returns the run behind the served record; `null` if it is not flown by this program.
async fn operation(State(state): Shared, Extension(Caller(actor)): Who) -> ApiResult<Response> {
    Ok(Json(state.door.as_ref().map(|door| door.operation(&actor, stations(&state, &actor)))).into_response())
}

async fn command(State(state): Shared, Extension(caller): Who, body: CommandBody) -> ApiResult<Json<CommandState>> {
    let door = state.door.clone().ok_or_else(|| {
        ApiError::not_found(
            "this record's flight cannot be commanded from here",
            "fly with `apex fly MISSION --serve`; `POST /api/flights/ID/commands` commands flights of `apex serve --missions`",
        )
    })?;
    send((state, door), None, caller, body).await
}

async fn flight_operation(
    State(state): Shared,
    Extension(Caller(actor)): Who,
    id: Result<Path<u64>, PathRejection>,
) -> ApiResult<Response> {
    let (door, _) = flight_of(&state, id)?;
    door.hear(&actor.name);
    Ok(Json(door.operation(&actor, stations(&state, &actor))).into_response())
}

async fn flight_command(
    State(state): Shared,
    Extension(caller): Who,
    id: Result<Path<u64>, PathRejection>,
    body: CommandBody,
) -> ApiResult<Json<CommandState>> {
    let (door, record) = flight_of(&state, id)?;
    send((state, door), Some(record), caller, body).await
}

/// Returns the other callers that can receive authority from `actor`.
fn stations(state: &AppState, actor: &Actor) -> Vec<Actor> {
    state.sessions.stations.others(actor, Instant::now())
}

/// Returns the door and the record of a flight of this server.
fn flight_of(state: &AppState, id: Result<Path<u64>, PathRejection>) -> ApiResult<(FlightDoor, PathBuf)> {
    let Path(id) = id.map_err(|rejection| {
        ApiError::bad_request(rejection.body_text(), "flights have whole numbers; `/api/flights` lists them")
    })?;
    let flight = state.tower()?.flight(id)?;
    Ok((flight.door().clone(), flight.record.clone()))
}

/// Sends a command and waits for its end, which is reached even if the caller disconnects. `record` is that of the flight; `None` is the
/// served one.
async fn send(
    (state, door): (Arc<AppState>, FlightDoor),
    record: Option<PathBuf>,
    Caller(actor): Caller,
    body: CommandBody,
) -> ApiResult<Json<CommandState>> {
    let refused = |status, error| {
        ApiError {
        status,
        error,
        help: "send for example `{\"do\": \"pause\"}` as application/json; docs/reference/server-api.md lists the commands".into(),
    }
    };
    let Json(UniqueJson(body)) = body.map_err(|rejection| refused(rejection.status(), rejection.body_text()))?;
    let (wish, terms) = Wish::read(body).map_err(|error| refused(StatusCode::UNPROCESSABLE_ENTITY, error))?;
    door.hear(&actor.name);
    let objection = match &wish {
        Wish::OfferAuthority { to } => state.sessions.objection_to_holder(to),
        Wish::Acknowledge { at_ns, signal, .. } => {
            let alarm = StatedAlarm { at_ns: *at_ns, signal: signal.clone() };
            let state = Arc::clone(&state);
            let search = move || match record {
                None => state.read(|view| alarms::objection(view, &alarm)),
                Some(path) => alarms::objection(&mut RecordView::open(&path, 0)?, &alarm),
            };
            blocking(search).await?
        }
        _ => None,
    };
    let author = Author { actor, epoch: terms.epoch };
    let number = door.send(CommandRequest { wish, author, valid_until: terms.valid_until, objection });
    let forgotten = || ApiError::not_found(format!("command {number} is no longer kept"), "the record holds its end");
    let ended = tokio::spawn(async move {
        loop {
            let state = door.command(number)?;
            if !state.is_open() {
                return Some(state);
            }
            tokio::time::sleep(LOOK).await;
        }
    });
    ended.await.ok().flatten().map(Json).ok_or_else(forgotten)
}

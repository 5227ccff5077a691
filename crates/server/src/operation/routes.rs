//! The addresses for operating: the flight of the served record, and flights that the server started.

use crate::answer::{Answer, ApiError};
use crate::flights::routes::own_pages_only;
use crate::operation::door::{CommandState, FlightDoor};
use crate::operation::request::Wish;
use crate::state::{AppState, Shared};
use axum::extract::rejection::{JsonRejection, PathRejection};
use axum::extract::{DefaultBodyLimit, Path};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use std::sync::Arc;
use std::time::Duration;

/// Bytes of the largest body: a message of the longest size, escaped.
const BODY_MAX_BYTES: usize = 16 << 10;
/// How often a command is looked at until it has an end.
const LOOK: Duration = Duration::from_millis(10);

/// The routes; commands are taken from this server's own pages and from programs of this machine only.
pub(crate) fn routes(state: &Arc<AppState>) -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/operation", get(operation))
        .route("/api/commands", post(command))
        .route("/api/flights/{id}/operation", get(flight_operation))
        .route("/api/flights/{id}/commands", post(flight_command))
        .layer(DefaultBodyLimit::max(BODY_MAX_BYTES))
        .layer(middleware::from_fn_with_state(Arc::clone(state), own_pages_only))
}

/// The run behind the served record; `null` if it is not flown by this program.
async fn operation(axum::extract::State(state): Shared) -> Answer<Response> {
    Ok(Json(state.door.as_ref().map(FlightDoor::operation)).into_response())
}

async fn command(
    axum::extract::State(state): Shared,
    wish: Result<Json<Wish>, JsonRejection>,
) -> Answer<Json<CommandState>> {
    let door = state.door.clone().ok_or_else(|| {
        ApiError::not_found(
            "this record's flight cannot be commanded from here",
            "fly with `apex fly MISSION --serve`; `POST /api/flights/ID/commands` commands flights of `apex serve --missions`",
        )
    })?;
    send(door, wish).await
}

async fn flight_operation(
    axum::extract::State(state): Shared,
    id: Result<Path<u64>, PathRejection>,
) -> Answer<Response> {
    Ok(Json(door_of(&state, id)?.operation()).into_response())
}

async fn flight_command(
    axum::extract::State(state): Shared,
    id: Result<Path<u64>, PathRejection>,
    wish: Result<Json<Wish>, JsonRejection>,
) -> Answer<Json<CommandState>> {
    send(door_of(&state, id)?, wish).await
}

fn door_of(state: &AppState, id: Result<Path<u64>, PathRejection>) -> Answer<FlightDoor> {
    let Path(id) = id.map_err(|rejection| {
        ApiError::bad_request(rejection.body_text(), "flights have whole numbers; `/api/flights` lists them")
    })?;
    Ok(state.tower()?.flight(id)?.door().clone())
}

/// Sends a command and waits for its end, which comes also if the caller leaves.
async fn send(door: FlightDoor, wish: Result<Json<Wish>, JsonRejection>) -> Answer<Json<CommandState>> {
    let Json(wish) = wish.map_err(|rejection| ApiError {
        status: rejection.status(),
        error: rejection.body_text(),
        help: "send for example `{\"do\": \"pause\"}` as application/json; docs/reference/server-api.md lists the commands".into(),
    })?;
    let number = door.send(&wish);
    let forgotten = || ApiError::not_found(format!("command {number} is forgotten"), "the record holds its end");
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

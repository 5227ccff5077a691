//! Checks every request to the API: determines the caller, and whether the caller's role permits the address.

use super::table;
use crate::answer::{ApiError, Remedy};
use crate::state::Shared;
use apex_runtime::authority::Actor;
use axum::extract::{MatchedPath, Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::time::Instant;

/// The sender of a request: an extension of every request to the API that needs a role.
#[derive(Clone, Debug)]
pub(crate) struct Caller(pub(crate) Actor);

/// Middleware of all routes of the API.
pub(crate) async fn check(State(state): Shared, mut request: Request, next: Next) -> Response {
    let path = request.extensions().get::<MatchedPath>().map(|path| path.as_str().to_owned()).unwrap_or_default();
    let least = match table::least_role(request.method(), &path) {
        Some(least) => least,
        // The router answers 405 to a method that an address does not support.
        None if table::has_path(&path) => return next.run(request).await,
        None => {
            return ApiError::forbidden(format!("no role may use {path}"), "this is a fault of Apex; please report it")
                .into_response();
        }
    };
    let Some(least) = least else { return next.run(request).await };
    let actor = match state.sessions.caller(request.headers()) {
        Ok(actor) => actor,
        Err(error) => return error.into_response(),
    };
    if actor.role < least {
        return ApiError::forbidden(
            format!("{actor} is {}, and this needs {}", actor.role.word(), least.word()),
            Remedy::Role.help("begin a session with another token: POST /api/session"),
        )
        .into_response();
    }
    state.sessions.stations.hear(&actor, Instant::now());
    if let Some(door) = &state.door {
        door.hear(&actor.name);
    }
    request.extensions_mut().insert(Caller(actor));
    next.run(request).await
}

//! `/api/records` lists the records that the page can show; `/api/records/ID/..` is the API of one of them, like `/api/..` for the first.

use crate::answer::{ApiError, ApiResult, Remedy};
use crate::scored_flight::ScoredFlight;
use crate::seen_ground::SeenGround;
use crate::shelf::{Shelf, rows_of};
use crate::state::{AppState, Shared, Views, blocking};
use axum::extract::rejection::PathRejection;
use axum::extract::{MatchedPath, Path as UrlPath, Request, State};
use axum::http::Uri;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use std::sync::{Arc, OnceLock, PoisonError};
use tower::ServiceExt;

/// Returns the routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new().route("/api/records", get(list)).route("/api/records/{id}/{*what}", get(of_one))
}

async fn list(State(state): Shared) -> ApiResult<Response> {
    let answer = blocking(move || {
        // The reader is one of the open connections: a record is not checked again for each list.
        let first = rows_of(&state.reader()?)?.into_iter().nth(state.agent);
        let others = state.shelf.entries().iter().map(|entry| entry.shown.clone()).collect::<Vec<_>>();
        Ok(first.into_iter().chain(others).collect::<Vec<_>>())
    })
    .await?;
    Ok(Json(serde_json::json!({ "records": answer })).into_response())
}

async fn of_one(
    State(state): Shared,
    path: Result<UrlPath<(usize, String)>, PathRejection>,
    mut request: Request,
) -> ApiResult<Response> {
    let UrlPath((id, what)) = path.map_err(|rejection| {
        let help = Remedy::Records.help("records have whole numbers; `/api/records` lists them");
        ApiError::bad_request(rejection.body_text(), help)
    })?;
    let query = request.uri().query().map(|query| format!("?{query}")).unwrap_or_default();
    let routes = blocking(move || routes_of(&state, id)).await?;
    // The entry's own router names the address again; roles are checked by that name.
    request.extensions_mut().remove::<MatchedPath>();
    *request.uri_mut() = format!("/api/{what}{query}").parse::<Uri>().map_err(|error| {
        ApiError::bad_request(error.to_string(), "docs/reference/server-api.md lists the addresses")
    })?;
    Ok(routes.oneshot(request).await.into_response())
}

/// Returns the routes of one entry, made at the first query about it.
fn routes_of(state: &Arc<AppState>, id: usize) -> ApiResult<Router> {
    if id == 0 {
        return Ok((state.routes)(Arc::clone(state)));
    }
    let entry = id.checked_sub(1).and_then(|index| state.shelf.entries().get(index).cloned());
    let unknown = || {
        ApiError::not_found(
            format!("this server has no record {id}"),
            Remedy::Records.help("`/api/records` lists them"),
        )
    };
    let entry = entry.ok_or_else(unknown)?;
    if let Some(routes) = entry.routes.get() {
        return Ok(routes.clone());
    }
    let is_same = entry.opened.is_none();
    // No record is opened as a new one: its file may be that of another flight by now.
    let view = match &entry.opened {
        None => state.read(|view| Ok(view.of_agent(entry.agent)?))?,
        Some(opened) => opened.lock().unwrap_or_else(PoisonError::into_inner).of_agent(entry.agent)?,
    };
    let of_entry = AppState {
        views: Some(Views::new(view)?),
        record: Some(entry.path),
        agent: entry.agent,
        load: state.load.clone(),
        program: OnceLock::new(),
        facts: OnceLock::new(),
        door: state.door.clone().filter(|_| is_same),
        seen: SeenGround::default(),
        score: ScoredFlight::default(),
        tower: None,
        routes: state.routes,
        shelf: Shelf::default(),
        what_if: None,
        sessions: Arc::clone(&state.sessions),
        names: state.names.clone(),
        is_encrypted: state.is_encrypted,
        live_places: Arc::clone(&state.live_places),
    };
    Ok(entry.routes.get_or_init(|| (state.routes)(Arc::new(of_entry))).clone())
}

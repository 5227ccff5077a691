//! Routes of the HTTP API: each maps a request to a query of the record view.

use crate::answer::{ApiError, ApiResult};
use crate::params::{
    AtParams, EventsParams, MonitorsParams, ProgramTextParams, SamplesParams, SourceParams, TasksParams,
    TimelineParams, TrackParams, WhyParams,
};
use crate::state::{AppState, QueryParams, Shared, blocking, checked, no_record};
use crate::{access, assets, flights, guard, hardening, live, operation, seen, shelf_routes, what_if, why};
use apex_runtime::RecordError;
use apex_runtime::record::view::{Mission, RecordView, SourceLine};
use axum::Json;
use axum::Router;
use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::http::StatusCode;
use axum::middleware::{from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;
use std::sync::Arc;
use tower_http::CompressionLevel;
use tower_http::compression::CompressionLayer;

/// Maximum bytes of a message from a client of `/api/live`; the server expects none.
const LIVE_MESSAGE_MAX_BYTES: usize = 1 << 10;

/// Returns all routes. The layers, from outside to inside: headers of answers, the requesting site, compression, the body, the caller's
/// role.
pub(crate) fn router(state: Arc<AppState>) -> Router {
    Router::new()
        .route("/api/mission", get(mission))
        .route("/api/track", get(track))
        .route("/api/tasks", get(tasks))
        .route("/api/timeline", get(timeline))
        .route("/api/events", get(events))
        .route("/api/why", get(why))
        .route("/api/targets", get(targets))
        .route("/api/surroundings", get(surroundings))
        .route("/api/plan", get(plan))
        .route("/api/troubles", get(troubles)) // english: allow
        .route("/api/questions", get(questions))
        .route("/api/signals", get(signals))
        .route("/api/samples", get(samples))
        .route("/api/report", get(report))
        .route("/api/source", get(source))
        .route("/api/live", get(live))
        .route("/api/monitors", get(monitors))
        .route("/api/program", get(program))
        .route("/api/program-text", get(program_text))
        .route("/api/command-log", get(command_log))
        .merge(flights::routes::routes())
        .merge(operation::routes::routes())
        .merge(access::routes::routes())
        .merge(seen::routes())
        .merge(shelf_routes::routes())
        .merge(what_if::routes::routes())
        .route_layer(from_fn_with_state(Arc::clone(&state), access::check))
        .fallback(assets::page)
        .method_not_allowed_fallback(other_method)
        .layer(from_fn(hardening::whole_body))
        .layer(CompressionLayer::new().quality(CompressionLevel::Fastest))
        .layer(from_fn_with_state(Arc::clone(&state), guard::own_site_only))
        .layer(from_fn_with_state(Arc::clone(&state), hardening::add_headers))
        .with_state(state)
}

async fn mission(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    let known = Arc::clone(&state);
    read(state, move |view| {
        let mission = view.mission(at)?;
        Ok(Mission { growth: known.with_life(mission.growth), ..mission })
    })
    .await
}

async fn track(State(state): Shared, params: QueryParams<TrackParams>) -> ApiResult<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.track(&query)?)).await
}

async fn tasks(State(state): Shared, params: QueryParams<TasksParams>) -> ApiResult<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.tasks(&query)?)).await
}

async fn timeline(State(state): Shared, params: QueryParams<TimelineParams>) -> ApiResult<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.timeline(&query)?)).await
}

async fn events(State(state): Shared, params: QueryParams<EventsParams>) -> ApiResult<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.events(&query)?)).await
}

async fn why(State(state): Shared, params: QueryParams<WhyParams>) -> ApiResult<Response> {
    let WhyParams { task, at, explain } = checked(params)?;
    let answer = blocking(move || why::why(&state, task, at, explain.unwrap_or(true))).await?;
    Ok(Json(answer).into_response())
}

async fn monitors(State(state): Shared, params: QueryParams<MonitorsParams>) -> ApiResult<Response> {
    let MonitorsParams { at, task } = checked(params)?;
    let answer = blocking(move || why::monitors(&state, at, task)).await?;
    Ok(Json(answer).into_response())
}

async fn program(State(state): Shared) -> ApiResult<Response> {
    let program = state.program();
    read(state, move |view| Ok(view.program(program.as_ref().map(|program| &*program.0))?)).await
}

async fn program_text(State(state): Shared, params: QueryParams<ProgramTextParams>) -> ApiResult<Response> {
    let name = checked(params)?.name;
    read(state, move |view| {
        view.program_text(&name)?.ok_or_else(|| {
            ApiError::not_found(format!("the record has no file `{name}`"), "`/api/program` lists the files")
        })
    })
    .await
}

async fn command_log(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.operator_commands(at)?)).await
}

async fn targets(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.targets(at)?)).await
}

async fn surroundings(State(state): Shared) -> ApiResult<Response> {
    read(state, |view| Ok(view.surroundings()?)).await
}

async fn plan(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.plan(at)?)).await
}

async fn troubles(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.troubles(at)?)).await
}

async fn questions(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.questions(at)?)).await
}

async fn report(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.report(at)?)).await
}

async fn signals(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    let program = state.program();
    read(state, move |view| Ok(view.signals(at, program.as_ref())?)).await
}

async fn samples(State(state): Shared, params: QueryParams<SamplesParams>) -> ApiResult<Response> {
    let query = checked(params)?.into();
    let program = state.program();
    read(state, move |view| match view.signal_windows(&query, program.as_ref()) {
        Err(RecordError::Question(error)) => {
            Err(ApiError::bad_request(error, "`/api/signals` lists the state variables of the record"))
        }
        other => Ok(other?),
    })
    .await
}

async fn source(State(state): Shared, params: QueryParams<SourceParams>) -> ApiResult<Response> {
    let place = checked(params)?.place;
    let line = SourceLine::parse(&place)
        .ok_or_else(|| ApiError::bad_request(format!("`{place}` is not a place"), "a place is `file:line:column`"))?;
    read(state, move |view| {
        view.source(&line)?.ok_or_else(|| {
            ApiError::not_found(
                format!("the record has no file `{}`", line.name),
                "procedures made from plans are in the record's events of kind `procedure-added`",
            )
        })
    })
    .await
}

async fn live(State(state): Shared, upgrade: WebSocketUpgrade) -> Response {
    if state.views.is_none() {
        return no_record().into_response();
    }
    let Ok(place) = Arc::clone(&state.live_places).try_acquire_owned() else {
        let status = StatusCode::SERVICE_UNAVAILABLE;
        let (error, help) = ("too many pages watch this record", "close some of them");
        return ApiError { status, error: error.into(), help: help.into() }.into_response();
    };
    upgrade.max_message_size(LIVE_MESSAGE_MAX_BYTES).on_upgrade(async move |socket| {
        live::tell_growth(socket, state).await;
        drop(place);
    })
}

async fn other_method() -> ApiError {
    ApiError {
        status: StatusCode::METHOD_NOT_ALLOWED,
        error: "this address does not accept that method".into(),
        help: "use GET; docs/reference/server-api.md names the addresses that take POST".into(),
    }
}

/// Runs a query off the network threads and sends its answer as JSON.
async fn read<T, Q>(state: Arc<AppState>, query: Q) -> ApiResult<Response>
where
    T: Serialize + Send + 'static,
    Q: FnOnce(&mut RecordView) -> ApiResult<T> + Send + 'static,
{
    let answer = blocking(move || state.read(query)).await?;
    Ok(Json(answer).into_response())
}

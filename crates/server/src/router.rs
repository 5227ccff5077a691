//! The table of addresses: from a request to the record view and back.

use crate::answer::{Answer, ApiError};
use crate::params::{
    AtParams, EventsParams, MonitorsParams, ProgramTextParams, SamplesParams, SourceParams, TasksParams,
    TimelineParams, TrackParams, WhyParams,
};
use crate::state::{AppState, QueryParams, Shared, blocking, checked, no_record};
use crate::{assets, flights, guard, live, operation, seen, shelf_routes, what_if, why};
use apex_runtime::RecordError;
use apex_runtime::record::view::{Mission, RecordView, SourceLine};
use axum::Json;
use axum::Router;
use axum::extract::State;
use axum::extract::ws::WebSocketUpgrade;
use axum::http::header::{CONTENT_SECURITY_POLICY, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;
use std::sync::Arc;

/// The page needs nothing from elsewhere: no fonts, no tiles, no scripts.
const CONTENT_RULES: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
worker-src 'self' blob:; connect-src 'self' ws: wss:; frame-ancestors 'none'";

/// All routes. On a loopback address callers that use another name for this machine are kept out.
pub(crate) fn router(state: Arc<AppState>) -> Router {
    let loopback = state.loopback;
    let routes = Router::new()
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
        .route("/api/signals", get(signals))
        .route("/api/samples", get(samples))
        .route("/api/report", get(report))
        .route("/api/source", get(source))
        .route("/api/live", get(live))
        .route("/api/monitors", get(monitors))
        .route("/api/program", get(program))
        .route("/api/program-text", get(program_text))
        .route("/api/command-log", get(command_log))
        .merge(flights::routes::routes(&state))
        .merge(operation::routes::routes(&state))
        .merge(seen::routes())
        .merge(shelf_routes::routes())
        .merge(what_if::routes::routes(&state))
        .fallback(assets::page)
        .method_not_allowed_fallback(other_method)
        .layer(middleware::from_fn(add_headers))
        .with_state(state);
    if loopback { routes.layer(middleware::from_fn(guard::loopback_names_only)) } else { routes }
}

async fn mission(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    let known = Arc::clone(&state);
    read(state, move |view| {
        let mission = view.mission(at)?;
        Ok(Mission { growth: known.with_life(mission.growth), ..mission })
    })
    .await
}

async fn track(State(state): Shared, params: QueryParams<TrackParams>) -> Answer<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.track(&query)?)).await
}

async fn tasks(State(state): Shared, params: QueryParams<TasksParams>) -> Answer<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.tasks(&query)?)).await
}

async fn timeline(State(state): Shared, params: QueryParams<TimelineParams>) -> Answer<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.timeline(&query)?)).await
}

async fn events(State(state): Shared, params: QueryParams<EventsParams>) -> Answer<Response> {
    let query = checked(params)?.into();
    read(state, move |view| Ok(view.events(&query)?)).await
}

async fn why(State(state): Shared, params: QueryParams<WhyParams>) -> Answer<Response> {
    let WhyParams { task, at, explain } = checked(params)?;
    let answer = blocking(move || why::why(&state, task, at, explain.unwrap_or(true))).await?;
    Ok(Json(answer).into_response())
}

async fn monitors(State(state): Shared, params: QueryParams<MonitorsParams>) -> Answer<Response> {
    let MonitorsParams { at, task } = checked(params)?;
    let answer = blocking(move || why::monitors(&state, at, task)).await?;
    Ok(Json(answer).into_response())
}

async fn program(State(state): Shared) -> Answer<Response> {
    let program = state.program();
    read(state, move |view| Ok(view.program(program.as_ref().map(|program| &*program.0))?)).await
}

async fn program_text(State(state): Shared, params: QueryParams<ProgramTextParams>) -> Answer<Response> {
    let name = checked(params)?.name;
    read(state, move |view| {
        view.program_text(&name)?.ok_or_else(|| {
            ApiError::not_found(format!("the record has no file `{name}`"), "`/api/program` lists the files")
        })
    })
    .await
}

async fn command_log(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.operator_commands(at)?)).await
}

async fn targets(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.targets(at)?)).await
}

async fn surroundings(State(state): Shared) -> Answer<Response> {
    read(state, |view| Ok(view.surroundings()?)).await
}

async fn plan(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.plan(at)?)).await
}

async fn troubles(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.troubles(at)?)).await
}

async fn report(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    read(state, move |view| Ok(view.report(at)?)).await
}

async fn signals(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    let program = state.program();
    read(state, move |view| Ok(view.signals(at, program.as_ref())?)).await
}

async fn samples(State(state): Shared, params: QueryParams<SamplesParams>) -> Answer<Response> {
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

async fn source(State(state): Shared, params: QueryParams<SourceParams>) -> Answer<Response> {
    let place = checked(params)?.place;
    let line = SourceLine::parse(&place)
        .ok_or_else(|| ApiError::bad_request(format!("`{place}` is no place"), "a place is `file:line:column`"))?;
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

async fn live(State(state): Shared, headers: HeaderMap, upgrade: WebSocketUpgrade) -> Response {
    if state.views.is_none() {
        return no_record().into_response();
    }
    if !guard::same_origin(&headers) {
        return ApiError::forbidden("this page comes from another site", "open the page that this server serves")
            .into_response();
    }
    upgrade.on_upgrade(move |socket| live::tell_growth(socket, state))
}

async fn other_method() -> ApiError {
    ApiError {
        status: StatusCode::METHOD_NOT_ALLOWED,
        error: "this address does not take that method".into(),
        help: "use GET; docs/reference/server-api.md names the addresses that take POST".into(),
    }
}

async fn add_headers(request: axum::extract::Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(CONTENT_RULES));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    response
}

/// Runs a query off the network threads and sends its answer as JSON.
async fn read<T, Q>(state: Arc<AppState>, query: Q) -> Answer<Response>
where
    T: Serialize + Send + 'static,
    Q: FnOnce(&mut RecordView) -> Answer<T> + Send + 'static,
{
    let answer = blocking(move || state.read(query)).await?;
    Ok(Json(answer).into_response())
}

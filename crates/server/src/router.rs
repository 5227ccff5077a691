//! The table of addresses, and the way from a request to a query and back.

use crate::answer::{Answer, ApiError};
use crate::explain::Explainer;
use crate::queries::{events, mission, report, source, targets, tasks, timeline, track, why};
use crate::record::{Reader, Record};
use crate::{assets, guard, live};
use axum::Json;
use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Query, State};
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

/// What all requests share.
pub(crate) struct Hall {
    /// The record.
    pub(crate) record: Record,
    /// The command's explainer, if it gave one.
    pub(crate) explainer: Option<Arc<dyn Explainer>>,
}

type Hold = State<Arc<Hall>>;
type Asked<T> = Result<Query<T>, QueryRejection>;

/// All routes; `loopback` keeps out callers that use another name for this machine.
pub(crate) fn router(hall: Arc<Hall>, loopback: bool) -> Router {
    let routes = Router::new()
        .route("/api/mission", get(mission))
        .route("/api/track", get(track))
        .route("/api/tasks", get(tasks))
        .route("/api/timeline", get(timeline))
        .route("/api/events", get(events))
        .route("/api/why", get(why))
        .route("/api/targets", get(targets))
        .route("/api/report", get(report))
        .route("/api/source", get(source))
        .route("/api/live", get(live))
        .fallback(assets::page)
        .method_not_allowed_fallback(read_only)
        .layer(middleware::from_fn(add_headers))
        .with_state(hall);
    if loopback { routes.layer(middleware::from_fn(guard::loopback_names_only)) } else { routes }
}

async fn mission(State(hall): Hold) -> Answer<Response> {
    read(hall, mission::mission).await
}

async fn track(State(hall): Hold, asked: Asked<track::TrackQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    read(hall, move |reader| track::track(reader, &query)).await
}

async fn tasks(State(hall): Hold, asked: Asked<tasks::TasksQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    read(hall, move |reader| tasks::tasks(reader, &query)).await
}

async fn timeline(State(hall): Hold, asked: Asked<timeline::TimelineQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    read(hall, move |reader| timeline::timeline(reader, &query)).await
}

async fn events(State(hall): Hold, asked: Asked<events::EventsQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    read(hall, move |reader| events::events(reader, &query)).await
}

async fn why(State(hall): Hold, asked: Asked<why::WhyQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    let explainer = hall.explainer.clone().filter(|_| query.explain.unwrap_or(true));
    let (task, at_ns) = (query.task, query.at);
    let mut answer = blocking(move || hall.record.read(|reader| why::why(reader, &query))).await?;
    if let Some(explainer) = explainer {
        // Restoring an instant may take a while: outside the lock on the record.
        match blocking(move || Ok(explainer.why(task, at_ns))).await? {
            Ok(value) => answer.explainer = Some(value),
            Err(text) => answer.explainer_error = Some(text),
        }
    }
    Ok(Json(answer).into_response())
}

async fn targets(State(hall): Hold, asked: Asked<targets::TargetsQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    read(hall, move |reader| targets::targets(reader, &query)).await
}

async fn report(State(hall): Hold) -> Answer<Response> {
    read(hall, |reader| report::report(reader)).await
}

async fn source(State(hall): Hold, asked: Asked<source::SourceQuery>) -> Answer<Response> {
    let query = checked(asked)?;
    read(hall, move |reader| source::source(reader, &query)).await
}

async fn live(State(hall): Hold, headers: HeaderMap, upgrade: WebSocketUpgrade) -> Response {
    if !guard::same_origin(&headers) {
        return ApiError::forbidden("this page comes from another site", "open the page that this server serves")
            .into_response();
    }
    upgrade.on_upgrade(move |socket| live::tell_growth(socket, hall))
}

async fn read_only() -> ApiError {
    ApiError { status: StatusCode::METHOD_NOT_ALLOWED, error: "this API only reads".into(), help: "use GET".into() }
}

async fn add_headers(request: axum::extract::Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(CONTENT_RULES));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    response
}

fn checked<T>(asked: Asked<T>) -> Answer<T> {
    asked.map(|Query(query)| query).map_err(|rejection| {
        ApiError::bad_request(
            rejection.body_text(),
            "times are whole nanoseconds of mission time; docs/reference/server-api.md lists all parameters",
        )
    })
}

/// Runs a query off the network threads and sends its answer as JSON.
async fn read<T, Q>(hall: Arc<Hall>, query: Q) -> Answer<Response>
where
    T: Serialize + Send + 'static,
    Q: FnOnce(&mut Reader) -> Answer<T> + Send + 'static,
{
    let answer = blocking(move || hall.record.read(query)).await?;
    Ok(Json(answer).into_response())
}

async fn blocking<T: Send + 'static>(work: impl FnOnce() -> Answer<T> + Send + 'static) -> Answer<T> {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|error| {
        Err(ApiError {
            status: StatusCode::INTERNAL_SERVER_ERROR,
            error: format!("the query broke off: {error}"),
            help: "this is a fault of Apex; please report it with the record".into(),
        })
    })
}

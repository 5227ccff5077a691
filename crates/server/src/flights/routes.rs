//! The addresses of missions and flights.

use crate::access::Caller;
use crate::answer::{ApiError, ApiResult};
use crate::flights::request::{FlightRequest, PlanParams};
use crate::state::{AppState, Shared, blocking, checked};
use axum::extract::rejection::{JsonRejection, PathRejection, QueryRejection};
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, LOCATION};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Json, Router};
use serde::Serialize;
use serde_json::json;
use std::sync::Arc;

/// Bytes of the largest body: a request is a few words.
const BODY_MAX_BYTES: usize = 4096;

/// Returns the routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/missions", get(missions))
        .route("/api/missions/{name}/plan", get(plan))
        .route("/api/flights", get(flights).post(start))
        .route("/api/flights/{id}", get(flight))
        .route("/api/flights/{id}/report", get(report))
        .route("/api/flights/{id}/stop", post(stop))
        .layer(DefaultBodyLimit::max(BODY_MAX_BYTES))
}

async fn missions(State(state): Shared) -> ApiResult<Response> {
    ask(move || Ok(json!({"missions": state.tower()?.missions()?}))).await
}

async fn plan(
    State(state): Shared,
    name: Result<Path<String>, PathRejection>,
    params: Result<Query<PlanParams>, QueryRejection>,
) -> ApiResult<Response> {
    state.tower()?;
    let (name, params) = (of_path(name)?, checked(params)?);
    let text = blocking(move || state.tower()?.plan(&name, &params)).await?;
    Ok(([(CONTENT_TYPE, "application/json")], text).into_response())
}

async fn flights(State(state): Shared) -> ApiResult<Response> {
    ask(move || Ok(json!({"flights": state.tower()?.flights()}))).await
}

async fn start(State(state): Shared, request: Result<Json<FlightRequest>, JsonRejection>) -> ApiResult<Response> {
    state.tower()?;
    let Json(request) = request.map_err(|rejection| ApiError {
        status: rejection.status(),
        error: rejection.body_text(),
        help: "send `{\"mission\": NAME}` as application/json, with `seed`, `until_s` and `pace` if wanted".into(),
    })?;
    let (id, flight) = blocking(move || {
        let flight = state.tower()?.start(request)?;
        Ok((flight.id(), flight))
    })
    .await?;
    Ok((StatusCode::CREATED, [(LOCATION, format!("/api/flights/{id}"))], Json(flight)).into_response())
}

async fn flight(State(state): Shared, id: Result<Path<u64>, PathRejection>) -> ApiResult<Response> {
    let flight = state.tower()?.flight(of_path(id)?)?;
    Ok(Json(flight.state()).into_response())
}

async fn report(State(state): Shared, id: Result<Path<u64>, PathRejection>) -> ApiResult<Response> {
    let flight = state.tower()?.flight(of_path(id)?)?;
    let report = flight.report().ok_or_else(|| ApiError {
        status: StatusCode::CONFLICT,
        error: format!(
            "flight {} has no report: it has {}",
            flight.id,
            if flight.is_flying() { "not ended" } else { "failed" }
        ),
        help: format!("`/api/flights/{}` gives its state", flight.id).into(),
    })?;
    Ok(Json(report).into_response())
}

async fn stop(
    State(state): Shared,
    Extension(Caller(actor)): Extension<Caller>,
    id: Result<Path<u64>, PathRejection>,
) -> ApiResult<Response> {
    let flight = state.tower()?.flight(of_path(id)?)?;
    if let Some(holder) = flight.door().other_holder(&actor) {
        return Err(ApiError::forbidden(
            format!("{holder} holds authority over flight {}", flight.id),
            "take authority first, or ask its holder to offer it",
        ));
    }
    flight.stop();
    let status = if flight.is_flying() { StatusCode::ACCEPTED } else { StatusCode::OK };
    Ok((status, Json(flight.state())).into_response())
}

fn of_path<T>(value: Result<Path<T>, PathRejection>) -> ApiResult<T> {
    value.map(|Path(value)| value).map_err(|rejection| {
        ApiError::bad_request(rejection.body_text(), "flights have whole numbers; `/api/flights` lists them")
    })
}

/// Answers as JSON, off the network threads.
async fn ask<T: Serialize + Send + 'static>(
    query: impl FnOnce() -> ApiResult<T> + Send + 'static,
) -> ApiResult<Response> {
    Ok(Json(blocking(query).await?).into_response())
}

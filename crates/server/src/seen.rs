//! `/api/footprints`, `/api/score` and `/api/plans`: the ground that the sensors have seen, the score so far, and all plans, as known at an
//! instant.

use crate::answer::ApiResult;
use crate::mission_facts::MissionFacts;
use crate::params::{AtParams, WindowParams};
use crate::state::{AppState, QueryParams, Shared, blocking, checked};
use apex_mission::recorded::mission_of;
use apex_model::time::Time;
use axum::Json;
use axum::Router;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::sync::Arc;

/// Returns the routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/footprints", get(footprints))
        .route("/api/plans", get(plans))
        .route("/api/facts", get(facts))
        .route("/api/holdings", get(holdings))
        .route("/api/score", get(score))
}

async fn footprints(State(state): Shared, params: QueryParams<WindowParams>) -> ApiResult<Response> {
    let WindowParams { from, to, at } = checked(params)?;
    let to_ns = to.unwrap_or(i64::MAX).min(at.unwrap_or(i64::MAX));
    let seen = blocking(move || state.seen.between(&state.reader_of(0)?, from.unwrap_or(i64::MIN), to_ns)).await?;
    Ok(Json(seen).into_response())
}

/// Returns the score at an instant, by default the last one; `null` for missions without a score.
async fn score(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at.map_or(Time::END, Time);
    let score = blocking(move || state.score.at(&state.reader_of(0)?, at)).await?;
    Ok(Json(score).into_response())
}

async fn plans(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at;
    let plans = blocking(move || state.read(|view| Ok(view.plans(at)?))).await?;
    Ok(Json(plans).into_response())
}

async fn holdings(State(state): Shared, params: QueryParams<WindowParams>) -> ApiResult<Response> {
    let WindowParams { from, to, at } = checked(params)?;
    let holdings = blocking(move || state.read(|view| Ok(view.holdings((from, to), at)?))).await?;
    Ok(Json(holdings).into_response())
}

/// Returns facts of the record's mission; `null` if the record is not of a mission.
async fn facts(State(state): Shared) -> ApiResult<Response> {
    let facts = blocking(move || {
        if let Some(known) = state.facts.get() {
            return Ok(known.clone());
        }
        let mission = mission_of(&state.reader()?)?;
        let facts = mission.as_ref().map(MissionFacts::of);
        Ok(state.facts.get_or_init(|| facts).clone())
    })
    .await?;
    Ok(Json(facts).into_response())
}

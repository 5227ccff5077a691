//! `/api/footprints`, `/api/score` and `/api/plans`: the ground that the sensors have seen, the score so far, and all plans, as known at an
//! instant.

use crate::answer::ApiResult;
use crate::params::{AtParams, WindowParams};
use crate::state::{AppState, QueryParams, Shared, blocking, checked, no_record};
use apex_mission::recorded::mission_of;
use apex_mission::vehicle::Airframe;
use apex_mission::{Target, TargetKind};
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use axum::Json;
use axum::Router;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;
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
    let seen = blocking(move || {
        let path = state.record.as_ref().ok_or_else(no_record)?;
        state.seen.between(path, from.unwrap_or(i64::MIN), to_ns)
    })
    .await?;
    Ok(Json(seen).into_response())
}

/// The score at an instant, the last one by default; `null` for missions that are not measured by a score.
async fn score(State(state): Shared, params: QueryParams<AtParams>) -> ApiResult<Response> {
    let at = checked(params)?.at.map_or(Time::END, Time);
    let score = blocking(move || {
        let reader = state.reader()?.of_agent(0)?;
        state.score.at(&reader, at)
    })
    .await?;
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

/// Facts of the mission that the page needs next to its record: all of them are in the mission's files.
#[derive(Debug, Serialize)]
struct MissionFacts {
    /// `fixed-wing` or `rotorcraft`.
    kind: &'static str,
    /// Greatest distance from a landing place that the mission allows, metres; none if it states none.
    landing_distance_m_max: Option<f64>,
    /// Windows of the wanted looks of targets. The page shows those of targets that are known.
    windows: Vec<WantedWindow>,
}

/// A window in which an image of a target has its full worth.
#[derive(Debug, Serialize)]
struct WantedWindow {
    target: String,
    look: String,
    from_ns: i64,
    to_ns: i64,
}

fn windows_of(target: &Target) -> Vec<WantedWindow> {
    let TargetKind::Fire(fire) = &target.kind else { return Vec::new() };
    let looks = fire.wanted.looks.iter();
    let windows = looks.flat_map(|look| look.windows.iter().map(|window| (look.name.clone(), window)));
    let wanted = windows.map(|(look, window)| WantedWindow {
        target: target.id.clone(),
        look,
        from_ns: Time::from_seconds(window.from_s).0,
        to_ns: Time::from_seconds(window.until_s).0,
    });
    wanted.collect()
}

/// Facts of the record's mission; `null` if the record is not of a mission.
async fn facts(State(state): Shared) -> ApiResult<Response> {
    let facts = blocking(move || {
        let path = state.record.as_ref().ok_or_else(no_record)?;
        let mission = mission_of(&RecordReader::open(path)?)?;
        Ok(mission.map(|mission| MissionFacts {
            kind: match mission.model.airframe {
                Airframe::FixedWing => "fixed-wing",
                Airframe::Rotorcraft => "rotorcraft",
            },
            landing_distance_m_max: mission.requirements.landing_distance_m_max(),
            windows: mission.targets.iter().flat_map(windows_of).collect(),
        }))
    })
    .await?;
    Ok(Json(facts).into_response())
}

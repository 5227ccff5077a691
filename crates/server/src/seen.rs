//! `/api/footprints` and `/api/plans`: the ground that the sensors have seen, and all plans, as known at an instant.

use crate::answer::{Answer, ApiError};
use crate::params::{AtParams, WindowParams};
use crate::state::{AppState, QueryParams, Shared, blocking, checked, no_record};
use apex_mission::recorded::mission_of;
use apex_mission::score::{FlownScore, Footprints};
use apex_mission::vehicle::Airframe;
use apex_mission::{Target, TargetKind};
use apex_model::time::Time;
use apex_observation::target::WantedLook;
use apex_observation::timing::WindowNeed;
use apex_runtime::record::RecordReader;
use axum::Json;
use axum::Router;
use axum::extract::State;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Serialize;
use std::sync::{Arc, Mutex, PoisonError};

/// The fold over the record's steps, as far as it has come. A finished record is folded once.
#[derive(Default)]
pub(crate) struct SeenGround(Mutex<Option<Fold>>);

struct Fold {
    /// None: the mission observes nothing, or cannot be loaded.
    flown: Option<FlownScore>,
    last: (i64, Time),
}

/// The routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/footprints", get(footprints))
        .route("/api/plans", get(plans))
        .route("/api/facts", get(facts))
        .route("/api/holdings", get(holdings))
}

async fn footprints(State(state): Shared, params: QueryParams<WindowParams>) -> Answer<Response> {
    let WindowParams { from, to, at } = checked(params)?;
    let to_ns = to.unwrap_or(i64::MAX).min(at.unwrap_or(i64::MAX));
    let seen = blocking(move || state.seen.between(&state, from.unwrap_or(i64::MIN), to_ns)).await?;
    Ok(Json(seen).into_response())
}

async fn plans(State(state): Shared, params: QueryParams<AtParams>) -> Answer<Response> {
    let at = checked(params)?.at;
    let plans = blocking(move || state.read(|view| Ok(view.plans(at)?))).await?;
    Ok(Json(plans).into_response())
}

async fn holdings(State(state): Shared, params: QueryParams<WindowParams>) -> Answer<Response> {
    let WindowParams { from, to, at } = checked(params)?;
    let holdings = blocking(move || state.read(|view| Ok(view.holdings((from, to), at)?))).await?;
    Ok(Json(holdings).into_response())
}

/// What the page must know of the mission beside its record: all of it is in the mission's files.
#[derive(Debug, Serialize)]
struct MissionFacts {
    /// `fixed-wing` or `rotorcraft`.
    kind: &'static str,
    /// Greatest distance from a landing place that the mission allows, metres; none if it states none.
    landing_distance_m_max: Option<f64>,
    /// Windows of the wanted looks of targets. The page shows those of targets that are known.
    windows: Vec<WantedWindow>,
}

/// A window in which a look at a target has its full worth.
#[derive(Debug, Serialize)]
struct WantedWindow {
    target: String,
    look: String,
    from_ns: i64,
    to_ns: i64,
}

fn windows_of(target: &Target) -> Vec<WantedWindow> {
    let TargetKind::Fire(fire) = &target.kind else { return Vec::new() };
    let window = |look: &WantedLook, window: &WindowNeed| WantedWindow {
        target: target.id.clone(),
        look: look.name.clone(),
        from_ns: Time::from_seconds(window.from_s).0,
        to_ns: Time::from_seconds(window.until_s).0,
    };
    fire.wanted.looks.iter().flat_map(|look| look.windows.iter().map(move |each| window(look, each))).collect()
}

/// Facts of the record's mission; `null` if the record is not of a mission.
async fn facts(State(state): Shared) -> Answer<Response> {
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

impl SeenGround {
    /// The footprints in a window. One caller at a time folds; the others wait for what it finds.
    fn between(&self, state: &AppState, from_ns: i64, to_ns: i64) -> Answer<Footprints> {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let path = state.record.as_ref().ok_or_else(no_record)?;
        let reader = RecordReader::open(path)?.of_agent(0)?;
        let fold = match slot.take() {
            Some(fold) => fold,
            None => Fold { flown: flown_of(&reader)?, last: (0, Time::BEGINNING) },
        };
        let fold = slot.insert(fold);
        fold.advance(&reader)?;
        let seen = fold.flown.as_ref().and_then(FlownScore::footprints);
        Ok(seen.map(|seen| seen.between(from_ns, to_ns)).unwrap_or_default())
    }
}

fn flown_of(reader: &RecordReader) -> Answer<Option<FlownScore>> {
    let Some(mission) = mission_of(reader)? else { return Ok(None) };
    let flown = FlownScore::new(&mission)
        .map_err(|reason| ApiError::bad_request(reason, "look at the targets of the record's mission"))?;
    Ok(flown.map(FlownScore::only_footprints))
}

impl Fold {
    /// Takes the steps that were recorded since the last time.
    fn advance(&mut self, reader: &RecordReader) -> Answer<()> {
        let Some(flown) = &mut self.flown else { return Ok(()) };
        for step in reader.steps_between(self.last.1, Time::END)?.without_effects() {
            let step = step?;
            if step.batch_number > self.last.0 {
                flown.observe(&step.batch);
                self.last = (step.batch_number, step.batch.now);
            }
        }
        Ok(())
    }
}

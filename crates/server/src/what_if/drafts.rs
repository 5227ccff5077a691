//! `POST /api/drafts`: an order of visits, planned and checked from the situation at an instant.

use crate::answer::{ApiError, ApiResult};
use crate::state::{Shared, blocking};
use crate::what_if::request::DraftRequest;
use apex_mission::deliberation::{Deliberation, OrderFault, draft as plan_draft};
use apex_mission::recorded::mission_of;
use apex_mission::situation::OperatorPlan;
use apex_model::time::Time;
use apex_runtime::record::view::PlanInForce;
use axum::Json;
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use serde::Serialize;
use std::sync::PoisonError;

/// A draft with the checker's verdict.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct DraftAnswer {
    at_ns: i64,
    /// The plan, if all visits can be made.
    #[cfg_attr(test, ts(type = "PlanInForce | null"))]
    plan: Option<PlanInForce>,
    /// The expected score of the plan, or its expected cost of ignorance.
    worth: Option<Worth>,
    /// The reason, if there is no plan.
    violation: Option<DraftViolation>,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Worth {
    what: &'static str,
    value: f64,
}

/// A mistake in a draft, and its place.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct DraftViolation {
    reason: String,
    /// The place among the visits, from 0; `None` if the whole draft is wrong.
    visit: Option<usize>,
}

pub(crate) async fn draft(
    State(state): Shared,
    body: Result<Json<DraftRequest>, JsonRejection>,
) -> ApiResult<Json<DraftAnswer>> {
    let Json(request) = body.map_err(|rejection| ApiError {
        status: rejection.status(),
        error: rejection.body_text(),
        help: "send for example `{\"visits\": [\"zaca\", \"lick\"]}` as application/json".into(),
    })?;
    let answer = blocking(move || {
        let what_if = state.what_if()?;
        let reader = state.reader()?;
        let mission = mission_of(&reader)?.ok_or_else(|| {
            ApiError::bad_request(
                "the record is not of a mission",
                "open the record of a mission: a draft visits its targets",
            )
        })?;
        let end = reader.span()?.map_or(Time::ZERO, |(_, end)| end);
        let at = request.at_ns.map_or(end, |at| Time(at).min(end));
        let visits = OperatorPlan { visits: request.visits.clone(), repeat: request.repeat };
        let _one = what_if.drafting.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(answer(at, plan_draft(&reader, &mission, at, &visits, &what_if.means)?))
    })
    .await?;
    Ok(Json(answer))
}

type Planned = Result<Deliberation, OrderFault>;

fn answer(at: Time, planned: Planned) -> DraftAnswer {
    match planned {
        Ok(planned) => {
            let worth = match &planned.plan {
                apex_model::problem::Plan::SingleVisit(plan) => Worth { what: "score", value: plan.score },
                apex_model::problem::Plan::Surveillance(plan) => {
                    Worth { what: "expected cost of ignorance", value: plan.expected_cost }
                }
            };
            let plan = Some(PlanInForce::of_plan(planned.plan, at.0));
            DraftAnswer { at_ns: at.0, plan, worth: Some(worth), violation: None }
        }
        Err(OrderFault { visit, reason }) => {
            let violation = Some(DraftViolation { reason, visit });
            DraftAnswer { at_ns: at.0, plan: None, worth: None, violation }
        }
    }
}

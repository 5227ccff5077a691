//! Plans a mission from its start, without flying it.

use crate::answer::{ApiError, ApiResult};
use apex_mission::Mission;
use apex_mission::deliberation::{PlanningResources, SolveOptions, name_obstacles, solve_for_landing};
use apex_mission::export::json;
use apex_mission::export::table::PlanFacts;
use apex_mission::plan::input::PlanInput;
use apex_mission::plan::{proof, turns};
use apex_model::time::Duration;
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use axum::http::StatusCode;

/// Plans for `mission` within `budget`, or within that of its first solver, and writes the plan like `apex plan --json`. The proof of its
/// bound takes no longer than the plan.
///
/// # Errors
/// The mission has nothing to plan, or no plan is found.
pub(crate) fn plan(mission: Mission, budget: Option<Duration>, means: &PlanningResources) -> ApiResult<String> {
    let input = PlanInput::of_mission(mission)?;
    let budget = budget.unwrap_or(input.budget);
    let wish = SolveOptions { means, solver: None, budget, seed: input.seed, previous: None };
    let (mut invocations, cancel) = (Invocations::new(), CancelToken::new());
    let solved = solve_for_landing(input.mission(), input.problem.clone(), wish, &mut invocations, &cancel);
    let mut solved = solved.map_err(|reason| ApiError {
        status: StatusCode::UNPROCESSABLE_ENTITY,
        error: format!("no plan was found: {reason}"),
        help: "check the mission's data, or give more time with `budget_s`".into(),
    })?;
    if let Some(mission) = input.mission() {
        name_obstacles(mission, &mut solved);
    }
    let proven = proof::prove(&mut solved, input.is_tour(), budget)?;
    let turns = turns::of(&solved.problem, &solved.plan, input.mission());
    let facts = PlanFacts { proven: &proven, turns, survival: None, air_changes: input.air_changes() };
    Ok(json::write(&input.name, None, &solved, &facts))
}

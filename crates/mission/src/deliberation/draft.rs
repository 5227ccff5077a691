//! Drafts of plans: an order of visits that an operator proposes, planned and checked from the situation at an instant as the flight
//! would plan it. Nothing is recorded or flown.

use super::operator_plan::{HUMAN, means};
use super::{BUDGET_DEFAULT, Deliberation, PlanningResources, SolveOptions, solve_for_landing};
use crate::Mission;
use crate::error::MissionResult;
use crate::problem::{here, pose};
use crate::recorded::folded_until;
use crate::situation::OperatorPlan;
use apex_model::problem::Problem;
use apex_model::time::Time;
use apex_planning::solver::{Environment, WorkBudget};
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use apex_runtime::record::RecordReader;
use apex_solvers::planners::human::{Human, OrderFault};

/// Plans `visits` in this order from the situation of the recorded flight at `at`. The inner error has the visit that is impossible and
/// the reason, or the reason for which nothing can be planned.
///
/// # Errors
/// A record that cannot be read.
pub fn draft(
    reader: &RecordReader,
    mission: &Mission,
    at: Time,
    visits: &OperatorPlan,
    resources: &PlanningResources,
) -> MissionResult<Result<Deliberation, OrderFault>> {
    let (situation, flown) = folded_until(reader, mission, at)?;
    let believed = situation.updates.believed(mission);
    let here_now = here(&believed, &situation);
    let believed = situation.links.without_weak_links(believed, here_now);
    let believed = situation.storms.without_storms(believed, here_now, at.seconds());
    let flown = flown.as_ref().ok().and_then(Option::as_ref);
    let seed = mission.settings.seed;
    Ok(pose(&believed, &situation, flown, at).map_err(|none| none.to_string().into()).and_then(|problem| {
        let posed = problem.clone();
        let means = means(resources, Some(HUMAN), Some(visits))?;
        let wish = SolveOptions { means: &means, solver: Some(HUMAN), budget: BUDGET_DEFAULT, seed, previous: None };
        solve_for_landing(Some(&believed), problem, wish, &mut Invocations::default(), &CancelToken::default())
            .map_err(|none| fault(&posed, visits, seed).unwrap_or_else(|| none.to_string().into()))
    }))
}

/// Returns the visit that cannot be made; `None` if the order can be flown, or no single visit is at fault.
fn fault(problem: &Problem, visits: &OperatorPlan, seed: u64) -> Option<OrderFault> {
    // The first visit at fault is found before any work that the budget limits.
    let mut budget = WorkBudget::new(0);
    let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
    let planner = Human { visits: visits.visits.clone(), repeat: visits.repeat };
    planner.plan(problem, &mut environment).err().filter(|fault| fault.visit.is_some())
}

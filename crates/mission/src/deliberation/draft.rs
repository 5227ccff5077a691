//! Drafts of plans: an order of visits that an operator proposes, planned and checked from the situation at an instant as the flight
//! would plan it. Nothing is recorded or flown.

use super::operator_plan::{HUMAN, means};
use super::{BUDGET_DEFAULT, Deliberation, PlanningResources, SolveOptions, solve_for_landing};
use crate::Mission;
use crate::error::MissionResult;
use crate::problem::{NoPlan, here, pose};
use crate::recorded::folded_until;
use crate::situation::OperatorPlan;
use apex_model::time::Time;
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use apex_runtime::record::RecordReader;

/// Plans `visits` in this order from the situation of the recorded flight at `at`. The inner error names the visit that is impossible and
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
) -> MissionResult<Result<Deliberation, String>> {
    let (situation, flown) = folded_until(reader, mission, at)?;
    let believed = situation.updates.believed(mission);
    let here_now = here(&believed, &situation);
    let believed = situation.links.without_weak_links(believed, here_now);
    let believed = situation.storms.without_storms(believed, here_now, at.seconds());
    let flown = flown.as_ref().ok().and_then(Option::as_ref);
    let planned = pose(&believed, &situation, flown, at).and_then(|problem| {
        let means = means(resources, Some(HUMAN), Some(visits)).map_err(NoPlan::Fault)?;
        let seed = mission.settings.seed;
        let wish = SolveOptions { means: &means, solver: Some(HUMAN), budget: BUDGET_DEFAULT, seed, previous: None };
        solve_for_landing(Some(&believed), problem, wish, &mut Invocations::default(), &CancelToken::default())
    });
    Ok(planned.map_err(|none| none.to_string()))
}

//! Equal ranks (TC)
//! What: decides whether queues by rank determine the result when several tasks have the same rank.
//! Runs: contend phase, after `front` and `gaps`.  Reads: ResourceTable, ranks.  Writes: nothing.
//! Bound: O(r * g + h) for g groups of claimants and h holders of r resources.
//! PDL: `rank`, section 9, conflict; decision 0201.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::Arbitration;
use crate::control::conflicts::resources::needs_of;
use crate::control::conflicts::{priority, queues};
use crate::control::cycle::Cycle;
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use apex_model::because::ConflictRule;
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet};

/// Returns true if all tasks need one common resource and holders lose by rank alone. Otherwise priorities of tasks behind them can
/// count: if tasks of one rank share no resource, or if a task is displaced by one of equal rank.
pub(crate) fn are_decided(
    cycle: &Cycle<'_>,
    resources: &BTreeMap<ResourceId, &Resource>,
    parent: TaskId,
    result: &Arbitration,
) -> bool {
    let agent = &*cycle.agent;
    let equal = resources.values().any(|resource| queues::has_equal_ranks(agent, resource, parent));
    if !equal && result.displaced.is_empty() {
        return true;
    }
    if !result.displaced.is_empty() && have_tied_holders(cycle, resources, parent) {
        return false;
    }
    let mut holders = resources.values().flat_map(|resource| &resource.holders);
    let unsteady = |task: TaskId| priority::moves(agent, task) || priority::reads_inputs(agent, task);
    let by_rank = result.displaced.iter().all(|loss| loss.rule == ConflictRule::Rank);
    let steady = !equal || by_rank && !holders.any(|holding| unsteady(holding.task));
    steady && all_need_one(cycle, resources)
}

/// Returns true if two holders of a resource have the same rank below the parent. Which of them is the weaker one depends on the
/// priorities of the tasks that they precede, and on ranks below them.
pub(crate) fn have_tied_holders(
    cycle: &Cycle<'_>,
    resources: &BTreeMap<ResourceId, &Resource>,
    parent: TaskId,
) -> bool {
    resources.values().any(|resource| {
        let mut seen: Vec<f64> = Vec::new();
        let ranks = resource.holders.iter().map(|holding| queues::rank_below(cycle.agent, holding.task, parent).1);
        ranks.flatten().any(|rank| {
            let is_tied = seen.contains(&rank.rank);
            seen.push(rank.rank);
            is_tied
        })
    })
}

/// Returns true if all claimants and holders need one common resource.
fn all_need_one(cycle: &Cycle<'_>, resources: &BTreeMap<ResourceId, &Resource>) -> bool {
    let mut common: Option<BTreeSet<ResourceId>> = None;
    let mut meet = |needs: BTreeSet<ResourceId>| {
        let met = common.as_ref().map_or_else(|| needs.clone(), |common| common & &needs);
        let any = !met.is_empty();
        common = Some(met);
        any
    };
    resources.iter().all(|(id, resource)| {
        let mut together = resource.waiting.together();
        let mut holders = resource.holders.iter();
        together.all(|others| meet(others.iter().map(|other| other.0).chain([*id]).collect()))
            && holders.all(|holding| meet(needs_of(cycle, holding.task).iter().map(|need| need.resource).collect()))
    })
}

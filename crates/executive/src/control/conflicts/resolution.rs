//! Ways to arbitrate (TC)
//! What: lets the first claimants in queues decide where they can, and all claimants where they must.
//! Runs: contend phase, over the whole batch.  Reads: ResourceTable, ranks.  Writes: nothing.
//! Bound: that of `front`, or of `conflict` for resources whose claimants must be compared.
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::Arbitration;
use crate::control::conflicts::conflict::{arbitrate_all, orphans};
use crate::control::conflicts::resources::needs_of;
use crate::control::conflicts::{front, queues};
use crate::control::cycle::Cycle;
use crate::state::resource_id::ResourceId;
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet};

/// Arbitrates all resources in `dirty`; `fresh` says who claims them since this round. Where the first ones in queues decide
/// for all, the others are not inspected.
pub(crate) fn arbitrate(
    cycle: &Cycle<'_>,
    dirty: &BTreeSet<ResourceId>,
    fresh: &BTreeMap<ResourceId, Vec<TaskId>>,
) -> Arbitration {
    let (queued, rest): (BTreeSet<_>, BTreeSet<_>) = dirty.iter().partition(|id| queues::is_queued(cycle, **id));
    let joint = |id: &ResourceId| {
        let Some(resource) = cycle.agent.resources.get(*id) else { return false };
        let mut holders = resource.holders.iter();
        resource.waiting.others().next().is_some() || holders.any(|holding| needs_of(cycle, holding.task).len() > 1)
    };
    if !are_many(cycle, &queued) || !rest.is_empty() && queued.iter().any(joint) {
        return arbitrate_all(cycle, dirty);
    }
    let claim: BTreeSet<TaskId> = queued.iter().filter_map(|id| fresh.get(id)).flatten().copied().collect();
    let Some(mut result) = front::decide(cycle, &queued, &claim) else { return arbitrate_all(cycle, dirty) };
    if !rest.is_empty() {
        result.absorb(arbitrate_all(cycle, &rest));
        // Failures are reported in the order in which the tasks were created.
        result.impossible.sort_by_key(|each| each.0);
    }
    if orphans(cycle, &result).next().is_some() { arbitrate_all(cycle, dirty) } else { result }
}

/// Up to this many claimants are compared with one another: that costs no more than queues, and also lets a task use a gap that
/// opened without a change of its resource.
const COMPARED_MAX: usize = 32;

/// Are there more claimants than are compared with one another?
fn are_many(cycle: &Cycle<'_>, queued: &BTreeSet<ResourceId>) -> bool {
    let waiting = |id: &ResourceId| cycle.agent.resources.get(*id).map_or(0, |resource| resource.waiting.len());
    queued.iter().map(waiting).sum::<usize>() > COMPARED_MAX
}

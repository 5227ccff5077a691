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
    if queued.is_empty() || !rest.is_empty() && queued.iter().any(joint) {
        return arbitrate_all(cycle, dirty);
    }
    let claim: BTreeSet<TaskId> = queued.iter().filter_map(|id| fresh.get(id)).flatten().copied().collect();
    let Some(mut result) = front::decide(cycle, &queued, &claim) else { return arbitrate_all(cycle, dirty) };
    debug_assert!(says_the_same(cycle, &queued, &result), "the queues of {queued:?} and all their claimants disagree");
    if !rest.is_empty() {
        result.absorb(arbitrate_all(cycle, &rest));
        // Failures are reported in the order in which the tasks were created.
        result.impossible.sort_by_key(|each| each.0);
    }
    if orphans(cycle, &result).next().is_some() { arbitrate_all(cycle, dirty) } else { result }
}

/// The naive twin of queues, in debug builds: all claimants before the arbiter. Not for long queues, which they are there for.
fn says_the_same(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, part: &Arbitration) -> bool {
    const CLAIMANTS_MAX: usize = 32;
    if orphans(cycle, part).next().is_some() {
        return true;
    }
    let losers = |of: &Arbitration| of.displaced.iter().map(|loss| (loss.loser, loss.winner)).collect::<BTreeSet<_>>();
    let granted = |of: &Arbitration| of.granted.iter().copied().collect::<BTreeSet<_>>();
    let waiting = |id: &ResourceId| cycle.agent.resources.get(*id).map_or(0, |resource| resource.waiting.len());
    if dirty.iter().map(waiting).sum::<usize>() > CLAIMANTS_MAX {
        return true;
    }
    let all = arbitrate_all(cycle, dirty);
    granted(&all) == granted(part) && losers(&all) == losers(part)
}

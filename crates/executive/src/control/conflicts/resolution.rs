//! Choice of the arbitration method (TC)
//! What: arbitrates by the first claimants of queues if that suffices, and otherwise by comparison of all claimants.
//! Runs: contend phase, over the whole batch.  Reads: ResourceTable, ranks.  Writes: nothing.
//! Bound: that of `front`, or of `conflict` for resources whose claimants must be compared.
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::Arbitration;
use crate::control::conflicts::competition::{as_claimant, by_priority};
use crate::control::conflicts::conflict::{arbitrate_all, orphans};
use crate::control::conflicts::resources::needs_of;
use crate::control::conflicts::{families, front, queues};
use crate::control::cycle::Cycle;
use crate::state::resource_id::ResourceId;
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet};
use std::mem;

/// Arbitrates all resources in `dirty`; `fresh` are the claims of this round. If the first claimants of the queues decide, the others are
/// not inspected. Builds with assertions also compare all claimants if they are few, and check that both results agree.
pub(crate) fn arbitrate(
    cycle: &Cycle<'_>,
    dirty: &BTreeSet<ResourceId>,
    fresh: &BTreeMap<ResourceId, Vec<TaskId>>,
) -> Arbitration {
    let result = decide(cycle, dirty, fresh);
    debug_assert!(
        are_many(cycle, dirty) || says_the_same(&result, &arbitrate_all(cycle, dirty)),
        "queues and comparison decide otherwise at {}: {:?}",
        cycle.now,
        result.granted
    );
    result
}

/// Returns true if both results have the same grants, losses and failures. The order of grants does not count, because tasks begin in
/// written order.
fn says_the_same(one: &Arbitration, other: &Arbitration) -> bool {
    let losses = |result: &Arbitration| -> BTreeSet<_> {
        result.displaced.iter().map(|loss| (loss.loser, loss.winner, loss.resource)).collect()
    };
    let granted = |result: &Arbitration| -> BTreeSet<_> { result.granted.iter().copied().collect() };
    let never = |result: &Arbitration| -> Vec<_> { result.impossible.iter().map(|each| each.0).collect() };
    granted(one) == granted(other) && losses(one) == losses(other) && never(one) == never(other)
}

/// Returns true if there are so many claimants that assertions would take most of the time.
fn are_many(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>) -> bool {
    const MANY: usize = 64;
    let waiting = |id: &ResourceId| cycle.agent.resources.get(*id).map_or(0, |resource| resource.waiting.len());
    dirty.iter().map(waiting).sum::<usize>() > MANY
}

fn decide(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, fresh: &BTreeMap<ResourceId, Vec<TaskId>>) -> Arbitration {
    let (queued, rest): (BTreeSet<_>, BTreeSet<_>) = dirty.iter().partition(|id| queues::is_queued(cycle, **id));
    let joint = |id: &ResourceId| {
        let Some(resource) = cycle.agent.resources.get(*id) else { return false };
        let mut holders = resource.holders.iter();
        resource.waiting.others().next().is_some() || holders.any(|holding| needs_of(cycle, holding.task).len() > 1)
    };
    if queued.is_empty() || !rest.is_empty() && queued.iter().any(joint) {
        return decide_families(cycle, dirty, fresh);
    }
    let claim: BTreeSet<TaskId> = queued.iter().filter_map(|id| fresh.get(id)).flatten().copied().collect();
    let Some(mut result) = front::decide(cycle, &queued, &claim) else { return decide_families(cycle, dirty, fresh) };
    if !rest.is_empty() {
        let mut compared = arbitrate_all(cycle, &rest);
        let never = (mem::take(&mut result.impossible), mem::take(&mut compared.impossible));
        result.absorb(compared);
        result.impossible = in_turns(cycle, never, |each| each.0);
    }
    if orphans(cycle, &result).next().is_some() { arbitrate_all(cycle, dirty) } else { result }
}

/// Arbitrates by the first claimants of ranked families if that suffices, otherwise by comparison.
fn decide_families(
    cycle: &Cycle<'_>,
    dirty: &BTreeSet<ResourceId>,
    fresh: &BTreeMap<ResourceId, Vec<TaskId>>,
) -> Arbitration {
    let claims: BTreeSet<TaskId> = fresh.values().flatten().copied().collect();
    let found = families::decide(cycle, dirty, &claims).filter(|found| orphans(cycle, found).next().is_none());
    found.unwrap_or_else(|| arbitrate_all(cycle, dirty))
}

/// Merges two lists of claimants, the better claimant first; each list keeps its order.
fn in_turns<T>(cycle: &Cycle<'_>, (one, other): (Vec<T>, Vec<T>), task: impl Fn(&T) -> TaskId) -> Vec<T> {
    let claimant = |each: &T| as_claimant(cycle, task(each));
    let (mut one, mut other) = (one.into_iter().peekable(), other.into_iter().peekable());
    let mut all = Vec::new();
    while let (Some(a), Some(b)) = (one.peek(), other.peek()) {
        let next = if by_priority(&claimant(b), &claimant(a)).is_lt() { other.next() } else { one.next() };
        all.extend(next);
    }
    all.extend(one.chain(other));
    all
}

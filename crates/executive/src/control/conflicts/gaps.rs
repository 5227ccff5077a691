//! Gaps (TC)
//! What: arbitrates resources with free capacity while tasks wait for them, in the order of turns, until no claimant that
//! is left can get anything.
//! Runs: contend phase, where a task that says how long it takes could be done before one in front of it can begin.
//! Reads: ResourceTable, priorities, ranks.  Writes: nothing.
//! Bound: O(g * (g + log c)) for each of the claimants that are placed, for g groups of the c claimants: those that need the
//! same for nearly as long. Of a group that was refused, others are placed only while their claims change the remaining capacity.
//! PDL: `expected-duration`, `duration`, section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::{Arbitration, Refusal};
use crate::control::conflicts::competition::{as_claimant, is_eligible};
use crate::control::conflicts::conflict::{Placement, left_behind};
use crate::control::conflicts::equal_ranks;
use crate::control::conflicts::gap_lines::GapLines;
use crate::control::conflicts::queues::{key_in, key_of_loser_in, order_with_gaps, usable};
use crate::control::cycle::Cycle;
use crate::state::queue_place::{QueueKey, TurnOrder};
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet};

/// Among this few all are placed: each refusal then names what was in the way at its turn.
const FEW: usize = 64;

/// Arbitrates the resources in `dirty`, all that claimants need in addition, and all that tasks leave that are displaced;
/// `fresh` claim since this round. None where the claimants must be compared with one another.
pub(crate) fn decide(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, fresh: &BTreeSet<TaskId>) -> Option<Arbitration> {
    let mut dirty = dirty.clone();
    loop {
        let result = decide_in(cycle, &dirty, fresh)?;
        let known = dirty.len();
        dirty.extend(left_behind(cycle, &result));
        if dirty.len() == known {
            return Some(result);
        }
    }
}

fn decide_in(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, fresh: &BTreeSet<TaskId>) -> Option<Arbitration> {
    let concerned = Concerned::of(cycle, dirty)?;
    let mut untold = concerned.keys(cycle, fresh);
    let mut lines = GapLines::of(cycle, &concerned.resources, concerned.order);
    lines.visits_all = !untold.is_empty() && (untold.len() * 4 >= concerned.count || concerned.count <= FEW);
    let mut result = Arbitration::default();
    let mut refused: Vec<(QueueKey, Refusal)> = Vec::new();
    while let Some((key, line)) = lines.next() {
        untold.remove(&key);
        lines.visits_all &= !untold.is_empty();
        let claimant = as_claimant(cycle, key.task());
        match lines.field.place(&claimant) {
            Placement::Granted(losses) => {
                for loss in losses {
                    lines.add_loser(key_of_loser_in(cycle, &loss, concerned.order)?);
                    result.displaced.push(loss);
                }
                result.granted.push(claimant.id);
            }
            Placement::Refused(refusal) => {
                lines.was_refused(line, claimant.id, refusal.claim);
                refused.push((key, refusal));
            }
            Placement::Impossible(need, total) => {
                result.impossible.push((claimant.id, need.resource, need.amount, total));
            }
        }
    }
    // A task that begins to wait behind others that need the same is refused, too.
    for key in untold {
        match lines.field.place(&as_claimant(cycle, key.task())) {
            Placement::Refused(refusal) => refused.push((key, refusal)),
            Placement::Impossible(need, total) => {
                result.impossible.push((key.task(), need.resource, need.amount, total));
            }
            Placement::Granted(_) => return None,
        }
    }
    refused.sort_by_key(|each| each.0);
    result.refused = refused.into_iter().map(|(_, refusal)| refusal).collect();
    result.watched = lines.watched(&result);
    concerned.is_decided(cycle, &result).then_some(result)
}

/// All resources that claimants need together, and the order of turns among all of them.
struct Concerned<'a> {
    resources: BTreeMap<ResourceId, &'a Resource>,
    order: TurnOrder,
    /// The number of claims.
    count: usize,
}

impl<'a> Concerned<'a> {
    /// None where the queues have no order in common.
    fn of(cycle: &'a Cycle<'_>, dirty: &BTreeSet<ResourceId>) -> Option<Concerned<'a>> {
        let mut open: Vec<ResourceId> = dirty.iter().copied().collect();
        let mut seen = dirty.clone();
        let (mut resources, mut common, mut count) = (BTreeMap::new(), None, 0);
        while let Some(id) = open.pop() {
            let resource = usable(cycle, id)?;
            let waiting = &resource.waiting;
            if waiting.has_many_groups() {
                return None;
            }
            if !waiting.is_empty() {
                let order = order_with_gaps(cycle.agent, resource)?;
                if *common.get_or_insert(order) != order {
                    return None;
                }
            }
            count += waiting.len();
            resources.insert(id, resource);
            open.extend(waiting.others().filter(|other| seen.insert(*other)));
        }
        Some(Concerned { resources, order: common.unwrap_or(TurnOrder::Plain), count })
    }

    /// The places of those that claim since this round.
    fn keys(&self, cycle: &Cycle<'_>, fresh: &BTreeSet<TaskId>) -> BTreeSet<QueueKey> {
        let claimed = |task: &TaskId| self.resources.values().find(|resource| resource.waiting.contains(*task));
        let eligible = fresh.iter().filter(|task| is_eligible(cycle.agent, **task));
        let key = |task| key_in(cycle, claimed(task)?, *task, self.order);
        eligible.filter_map(key).collect()
    }

    /// Ranks put only those in order that share something, and represent priorities behind them.
    fn is_decided(&self, cycle: &Cycle<'_>, result: &Arbitration) -> bool {
        let TurnOrder::Below(parent) = self.order else { return true };
        equal_ranks::are_decided(cycle, &self.resources, parent, result)
    }
}

//! Gaps (TC)
//! What: arbitrates resources with free capacity while tasks wait for them, in the order of turns, until no remaining claimant can get a
//! resource.
//! Runs: contend phase, if a task with a stated duration could end before a task in front of it can begin.
//! Reads: ResourceTable, priorities, ranks.  Writes: nothing.
//! Bound: O(g * (g + log c)) for each placed claimant, for g groups of the c claimants; a group needs the same resources for nearly as
//! long. Of a refused group, further claimants are placed only while their claims change the remaining capacity.
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

/// Up to this number of claims every claimant is placed: each refusal then names what was in the way at its turn.
const FEW: usize = 64;

/// Arbitrates the resources in `dirty`, the other resources that claimants need, and those that displaced tasks leave; `fresh` are the
/// claims of this round. `None` if the claimants must be compared with one another.
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
    // A task that begins to wait behind others that need the same resources is refused, too.
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
    /// Returns `None` if the queues have no common order.
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

    /// Returns the places of the claims of this round.
    fn keys(&self, cycle: &Cycle<'_>, fresh: &BTreeSet<TaskId>) -> BTreeSet<QueueKey> {
        let claimed = |task: &TaskId| self.resources.values().find(|resource| resource.waiting.contains(*task));
        let eligible = fresh.iter().filter(|task| is_eligible(cycle.agent, **task));
        let key = |task| key_in(cycle, claimed(task)?, *task, self.order);
        eligible.filter_map(key).collect()
    }

    /// Returns true if the queues decide. Ranks order only tasks that share a resource, and let priorities behind them count.
    fn is_decided(&self, cycle: &Cycle<'_>, result: &Arbitration) -> bool {
        let TurnOrder::Below(parent) = self.order else { return true };
        equal_ranks::are_decided(cycle, &self.resources, parent, result)
    }
}

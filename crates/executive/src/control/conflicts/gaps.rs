//! Gaps (TC)
//! What: arbitrates resources with free capacity while tasks wait for them, in the order of turns, until no claimant that
//! is left can get anything.
//! Runs: contend phase, where a task that says how long it takes could be done before one in front of it can begin.
//! Reads: ResourceTable, priorities.  Writes: nothing.
//! Bound: O(n * r * log c) for the n claimants that come before the last one that gets something, of c, plus O(s) for each
//! of them, for s sets of resources that claimants need together.
//! PDL: `expected-duration`, `duration`, section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::Arbitration;
use crate::control::conflicts::competition::{as_claimant, is_eligible};
use crate::control::conflicts::conflict::{Field, Placement, left_behind};
use crate::control::conflicts::priority;
use crate::control::conflicts::queues::{in_turn, key_of, key_of_loser, usable};
use crate::control::conflicts::sharing::{TOLERANCE, UseKind};
use crate::control::cycle::Cycle;
use crate::state::queue_place::QueueKey;
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::collections::{BTreeMap, BTreeSet};
use std::iter::Peekable;

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
    let mut turns = ClaimOrder::of(cycle, dirty)?;
    let mut untold: BTreeSet<TaskId> = fresh.iter().copied().filter(|task| key_of(cycle, *task).is_some()).collect();
    let mut result = Arbitration::default();
    while let Some(key) = turns.next() {
        if untold.is_empty() && turns.is_over(key) {
            break;
        }
        let claimant = as_claimant(cycle, key.task());
        untold.remove(&claimant.id);
        match turns.field.place(&claimant) {
            Placement::Granted(losses) => {
                for loss in losses {
                    turns.losers.insert(key_of_loser(cycle, &loss)?);
                    result.displaced.push(loss);
                }
                result.granted.push(claimant.id);
            }
            Placement::Refused(refusal) => result.refused.push(refusal),
            Placement::Impossible(need, total) => {
                result.impossible.push((claimant.id, need.resource, need.amount, total));
            }
        }
    }
    Some(result)
}

/// Claimants of several resources, in the order of their turns.
struct ClaimOrder<'a, 'c> {
    cycle: &'a Cycle<'c>,
    field: Field<'a, 'c>,
    queues: Vec<Peekable<Box<dyn Iterator<Item = QueueKey> + 'a>>>,
    resources: BTreeMap<ResourceId, &'a Resource>,
    /// Those that lost what they had, and claim it again.
    losers: BTreeSet<QueueKey>,
}

impl<'a, 'c> ClaimOrder<'a, 'c> {
    /// Returns the order of the claimants; `None` if a claimant or a holder has a rank, or a priority that changes with time or an input.
    fn of(cycle: &'a Cycle<'c>, dirty: &BTreeSet<ResourceId>) -> Option<ClaimOrder<'a, 'c>> {
        let agent = &*cycle.agent;
        let mut open: Vec<ResourceId> = dirty.iter().copied().collect();
        let mut seen = dirty.clone();
        let (mut queues, mut resources) = (Vec::new(), BTreeMap::new());
        while let Some(id) = open.pop() {
            let resource = usable(cycle, id)?;
            let waiting = &resource.waiting;
            let unsteady = |task: TaskId| {
                priority::moves(agent, task) || priority::reads_inputs(agent, task) || priority::is_ranked(agent, task)
            };
            if waiting.has_rising()
                || waiting.priority_of_ranked() != Ok(None)
                || resource.holders.iter().any(|holding| unsteady(holding.task))
            {
                return None;
            }
            let eligible = in_turn(cycle, waiting).filter(|key| is_eligible(agent, key.task()));
            let queue: Box<dyn Iterator<Item = QueueKey> + 'a> = Box::new(eligible);
            queues.push(queue.peekable());
            resources.insert(id, resource);
            open.extend(waiting.others().filter(|other| seen.insert(*other)));
        }
        Some(ClaimOrder { cycle, field: Field::grouped(cycle), queues, resources, losers: BTreeSet::new() })
    }

    fn next(&mut self) -> Option<QueueKey> {
        let queued = self.queues.iter_mut().filter_map(|queue| queue.peek().copied());
        let next = queued.chain(self.losers.first().copied()).min()?;
        self.losers.remove(&next);
        for queue in &mut self.queues {
            queue.next_if(|key| *key == next);
        }
        Some(next)
    }

    /// Returns true if neither `next` nor a later claimant can get anything: they beat no holder, and each needs something that is taken,
    /// or that is awaited for longer than a gap allows.
    fn is_over(&self, next: QueueKey) -> bool {
        if !self.losers.is_empty() {
            return false;
        }
        let (mut latest, mut room) = (None, BTreeMap::new());
        for (id, resource) in &self.resources {
            let mut taken = 0.0;
            for each in self.field.users(*id, resource) {
                if each.kind == UseKind::Held && next.priority > self.field.defence(each.task).total() {
                    return false;
                }
                taken += each.amount;
                latest = latest.max(self.field.expected_end(&each));
            }
            let awaited = self.field.uses_of(*id).iter().filter(|each| matches!(each.kind, UseKind::Awaited(_)));
            let awaited: f64 = awaited.map(|each| each.amount).sum();
            if taken < resource.total - TOLERANCE {
                let free = resource.total - taken + TOLERANCE;
                room.insert(*id, (free, taken + awaited < resource.total - TOLERANCE));
            }
        }
        let is_open = |id: &ResourceId, resource: &Resource| {
            let free = room.get(id).map_or(0.0, |(free, _)| *free);
            resource.waiting.together(free).any(|(others, shortest)| {
                let mut all = others.iter().chain([id]);
                let unclaimed = others.iter().chain([id]).all(|each| room.get(each).is_some_and(|room| room.1));
                let fits = |(latest, shortest): (Time, _)| self.cycle.now + shortest <= latest;
                all.all(|each| room.contains_key(each)) && (unclaimed || latest.zip(shortest).is_some_and(fits))
            })
        };
        !self.resources.iter().any(|(id, resource)| room.contains_key(id) && is_open(id, resource))
    }
}

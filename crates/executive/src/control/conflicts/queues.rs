//! Queues of claimants (TC)
//! What: says whether the queues of a resource can decide who gets it, in which order they give turns, and which place a task
//! has in them.
//! Runs: contend phase.  Reads: ResourceTable, priorities, ranks, ancestors.  Writes: nothing.
//! Bound: O(h * (h + depth)) for h holders of a resource; O(r * log c) for the place of a task that claims r resources, of c
//! claimants.
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::Defeat;
use crate::control::conflicts::competition::{Claimant, as_claimant};
use crate::control::conflicts::curve::RisingTerm;
use crate::control::conflicts::resources::needs_in;
use crate::control::conflicts::{claim_queue, priority};
use crate::control::cycle::Cycle;
use crate::state::agent::Agent;
use crate::state::queue_place::{QueueKey, QueuePlace};
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use crate::state::turns::InTurn;
use crate::state::waiting::{Claim, Waiting};
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::iter::successors;

/// Returns true if this resource permits a decision by its queues alone.
pub(crate) fn is_queued(cycle: &Cycle<'_>, id: ResourceId) -> bool {
    let agent = &*cycle.agent;
    let Some(resource) = agent.resources.get(id) else { return false };
    let waiting = &resource.waiting;
    if resource.depletable || !resource.holders.iter().all(|holding| is_alone(agent, resource, holding.task)) {
        return false;
    }
    if !waiting.all_in_queues() {
        return waiting.parent_of_ranks().is_some_and(|parent| are_below(agent, resource, parent));
    }
    let Ok(ranked) = waiting.priority_of_ranked() else { return false };
    let mut holders = resource.holders.iter();
    holders.all(|holding| !may_stand_for_others(cycle, holding.task, resource, ranked))
}

/// Returns true if ranks alone put claimants and holders of the resource in order.
pub(crate) fn is_by_rank(cycle: &Cycle<'_>, id: ResourceId) -> bool {
    let resource = cycle.agent.resources.get(id);
    resource.is_some_and(|resource| !resource.waiting.all_in_queues()) && is_queued(cycle, id)
}

/// Returns true if the holder holds nothing for its steps, and no task above it waits for the resource or holds it.
fn is_alone(agent: &Agent, resource: &Resource, holder: TaskId) -> bool {
    let holder = agent.task(holder);
    // What it holds for its steps it may have begun to hold when they claimed already.
    let shares = holder.is_some_and(|task| task.extras.as_ref().is_some_and(|extras| !extras.held.is_empty()));
    let mut above = successors(holder, |task| agent.task(task.parent?)).skip(1);
    let holds = |id: TaskId| resource.holders.iter().any(|other| other.task == id);
    !shares && !above.any(|task| resource.waiting.contains(task.id) || holds(task.id))
}

/// Returns true if the rank below `parent` decides between each holder and each claimant.
fn are_below(agent: &Agent, resource: &Resource, parent: TaskId) -> bool {
    resource.holders.iter().all(|holding| {
        let rank = claim_queue::fixed_ranks(agent, holding.task).find(|rank| rank.parent == parent);
        rank.is_some_and(|rank| !resource.waiting.has_rank(rank))
    })
}

/// Returns true if the priority of claimants behind a holder with a rank may count for the holder, or that of the holder for them. This is
/// false if the holder holds nothing else and all ranked tasks are equally important.
fn may_stand_for_others(cycle: &Cycle<'_>, holder: TaskId, resource: &Resource, ranked: Option<f64>) -> bool {
    let agent = &*cycle.agent;
    if !priority::is_ranked(agent, holder) {
        return false;
    }
    let own = priority::priority(agent, holder, cycle.now);
    let others = resource.holders.iter().map(|holding| holding.task).filter(|other| priority::is_ranked(agent, *other));
    let mut priorities = others.map(|other| priority::priority(agent, other, cycle.now)).chain(ranked);
    needs_in(agent, holder).len() > 1 || priorities.any(|priority| priority != own)
}

/// Returns the resource, if its queues can decide alone.
pub(crate) fn usable<'a>(cycle: &'a Cycle<'_>, id: ResourceId) -> Option<&'a Resource> {
    cycle.agent.resources.get(id).filter(|_| is_queued(cycle, id))
}

/// Returns a function for the present value of a priority of a given importance that rises until `due`.
fn risen_to<'a>(cycle: &'a Cycle<'_>) -> impl Fn(f64, Time) -> f64 + 'a {
    let (agent, now): (&'a Agent, Time) = (cycle.agent, cycle.now);
    move |importance, due| priority::risen(agent, RisingTerm { importance, due }, now)
}

/// Claimants of a resource, the first first.
pub(crate) fn in_turn<'a>(cycle: &'a Cycle<'_>, waiting: &'a Waiting) -> InTurn<'a, impl Fn(f64, Time) -> f64 + 'a> {
    waiting.in_turn(cycle.now, risen_to(cycle))
}

/// Returns the position of a task that loses its resource among its claimants; `None` if that position is not in a queue.
pub(crate) fn key_of_loser(cycle: &Cycle<'_>, loss: &Defeat) -> Option<QueueKey> {
    let claimant = as_claimant(cycle, loss.loser);
    let takes_in = |key: &QueueKey| {
        let mut needed = claimant.needs.iter().filter_map(|need| cycle.agent.resources.get(need.resource));
        needed.all(|resource| resource.waiting.takes_in(key))
    };
    let Claim::Queued { place, by_rank, .. } = claim_queue::claim_of(cycle, loss.loser, &claimant.needs) else {
        return None;
    };
    if cycle.agent.resources.get(loss.resource)?.waiting.ordered_below().is_some() {
        return by_rank.into_iter().find(|key| ranks_among_all(cycle, &claimant, key));
    }
    match place? {
        QueuePlace::Steady(key) => Some(key).filter(takes_in),
        QueuePlace::Rising(key) => {
            let priority = risen_to(cycle)(key.importance, key.due);
            Some(QueueKey { priority, rank: None, begun: key.begun, order: key.order })
        }
    }
}

/// Returns true if the rank decides between the claimant and all who wait for one of its resources.
fn ranks_among_all(cycle: &Cycle<'_>, claimant: &Claimant, key: &QueueKey) -> bool {
    let Some(rank) = key.rank else { return false };
    let mut needed = claimant.needs.iter().filter_map(|need| cycle.agent.resources.get(need.resource));
    needed.all(|Resource { waiting, .. }| {
        waiting.is_empty() || waiting.ordered_below() == Some(rank.parent) && !waiting.has_rank(rank)
    })
}

/// Returns the place of a task that claims, if it is in a queue.
pub(crate) fn key_of(cycle: &Cycle<'_>, task: TaskId) -> Option<QueueKey> {
    let agent = &*cycle.agent;
    let need = agent.task(task)?.selection.as_ref()?.needs.first().copied();
    let need = need.or_else(|| agent.task(task)?.extras.as_ref()?.held.first().copied())?;
    agent.resources.get(need.resource)?.waiting.key_of(task, risen_to(cycle))
}

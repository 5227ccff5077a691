//! Queues of claimants (TC)
//! What: decides whether the queues of a resource suffice to arbitrate it, in which order they give turns, and which place a task has in
//! them.
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
use crate::state::claim::{Claim, QueuedClaim};
use crate::state::orders::Group;
use crate::state::queue_place::{QueueKey, RankAmong, TurnOrder};
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use crate::state::turns::InTurn;
use crate::state::waiting::Waiting;
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
    match waiting.order() {
        None => false,
        Some(TurnOrder::Below(parent)) => are_below(agent, resource, parent),
        Some(TurnOrder::Level(rank)) => {
            resource.holders.iter().all(|holding| claim_queue::fixed_ranks(agent, holding.task).next() == Some(rank))
        }
        Some(TurnOrder::Plain) => {
            let Ok(ranked) = waiting.priority_of_ranked() else { return false };
            let mut holders = resource.holders.iter();
            holders.all(|holding| !may_stand_for_others(cycle, holding.task, resource, ranked))
        }
    }
}

/// Returns true if ranks alone put claimants and holders of the resource in order.
pub(crate) fn is_by_rank(cycle: &Cycle<'_>, id: ResourceId) -> bool {
    let resource = cycle.agent.resources.get(id);
    let parent = resource.and_then(|resource| Some((resource, resource.waiting.ordered_below()?)));
    parent.is_some_and(|(resource, parent)| !has_equal_ranks(cycle.agent, resource, parent)) && is_queued(cycle, id)
}

/// Returns true if the holder holds nothing for its steps, and no task above it waits for the resource or holds it.
pub(crate) fn is_alone(agent: &Agent, resource: &Resource, holder: TaskId) -> bool {
    let holder = agent.task(holder);
    // A holder may have begun to hold resources for its steps while they were claiming already.
    let shares = holder.is_some_and(|task| task.extras.as_ref().is_some_and(|extras| !extras.held.is_empty()));
    let mut above = successors(holder, |task| agent.task(task.parent?)).skip(1);
    let holds = |id: TaskId| resource.holders.iter().any(|other| other.task == id);
    !shares && !above.any(|task| resource.waiting.contains(task.id) || holds(task.id))
}

/// Returns true if the ranks below `parent` decide between every holder and every claimant.
fn are_below(agent: &Agent, resource: &Resource, parent: TaskId) -> bool {
    resource.holders.iter().all(|holding| {
        let (lowest, rank) = rank_below(agent, holding.task, parent);
        rank.is_some_and(|rank| !resource.waiting.has_rank(rank) || lowest && resource.waiting.admits_rank(rank))
    })
}

/// Returns the rank of a task below `parent`, and true if the task has no rank of a lower level.
pub(crate) fn rank_below(agent: &Agent, task: TaskId, parent: TaskId) -> (bool, Option<RankAmong>) {
    let mut ranks = claim_queue::fixed_ranks(agent, task).enumerate();
    let found = ranks.find(|(_, rank)| rank.parent == parent);
    (found.is_some_and(|(index, _)| index == 0), found.map(|(_, rank)| rank))
}

/// Returns true if two claimants, or a claimant and a holder, have the same rank below `parent`.
pub(crate) fn has_equal_ranks(agent: &Agent, resource: &Resource, parent: TaskId) -> bool {
    resource.waiting.has_equal_ranks(parent)
        || resource.holders.iter().any(|holding| {
            rank_below(agent, holding.task, parent).1.is_some_and(|rank| resource.waiting.has_rank(rank))
        })
}

/// Returns true if priorities of claimants behind a ranked holder may count for the holder, or its priority for them. Not if the holder
/// holds nothing else and all ranked tasks have the same priority.
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
pub(crate) fn risen_to<'a>(cycle: &'a Cycle<'_>) -> impl Fn(f64, Time) -> f64 + 'a {
    let (agent, now): (&'a Agent, Time) = (cycle.agent, cycle.now);
    move |importance, due| priority::risen(agent, RisingTerm { importance, due }, now)
}

/// Returns the claimants of a resource in the order of turns.
pub(crate) fn in_turn<'a>(cycle: &'a Cycle<'_>, waiting: &'a Waiting) -> InTurn<'a, impl Fn(f64, Time) -> f64 + 'a> {
    waiting.in_turn(cycle.now, risen_to(cycle))
}

/// Returns the claimants of a group in the order of turns.
pub(crate) fn group_in_turn<'a>(
    cycle: &'a Cycle<'_>,
    group: &'a Group,
    order: TurnOrder,
) -> InTurn<'a, impl Fn(f64, Time) -> f64 + 'a> {
    group.in_turn(order, cycle.now, risen_to(cycle))
}

/// Returns the order of a queue in which gaps can be filled: by ranks if a claimant has one and the ranks differ.
pub(crate) fn order_with_gaps(agent: &Agent, resource: &Resource) -> Option<TurnOrder> {
    let waiting = &resource.waiting;
    match waiting.order()? {
        TurnOrder::Plain if waiting.priority_of_ranked() != Ok(None) => {
            let parent = waiting.parent_of_ranks().filter(|parent| are_below(agent, resource, *parent))?;
            Some(TurnOrder::Below(parent))
        }
        order => Some(order),
    }
}

/// Returns the place of a claimant of the resource in this order; `None` if it has none.
pub(crate) fn key_in(cycle: &Cycle<'_>, resource: &Resource, task: TaskId, order: TurnOrder) -> Option<QueueKey> {
    resource.waiting.key_of(task, order, risen_to(cycle))
}

/// Returns the position of a task that loses its resource among its claimants; `None` if that position is not in a queue.
pub(crate) fn key_of_loser(cycle: &Cycle<'_>, loss: &Defeat) -> Option<QueueKey> {
    let order = cycle.agent.resources.get(loss.resource)?.waiting.order();
    key_of_loser_in(cycle, loss, order.unwrap_or(TurnOrder::Plain))
}

/// Returns the position of a task that loses its resource in the given order; `None` if it is not in such a queue.
pub(crate) fn key_of_loser_in(cycle: &Cycle<'_>, loss: &Defeat, order: TurnOrder) -> Option<QueueKey> {
    let claimant = as_claimant(cycle, loss.loser);
    let Claim::Queued(claim) = claim_queue::claim_of(cycle, loss.loser, &claimant.needs) else { return None };
    let key = claim.key_in(order, risen_to(cycle))?;
    let mut needed = claimant.needs.iter().filter_map(|need| cycle.agent.resources.get(need.resource));
    let fits = match order {
        TurnOrder::Below(_) => ranks_among_all(cycle, &claimant, &claim, &key),
        TurnOrder::Level(rank) => {
            let alike = |resource: &Resource| {
                resource.waiting.is_empty() || resource.waiting.order() == Some(TurnOrder::Level(rank))
            };
            claim.by_rank.first().and_then(|key| key.rank) == Some(rank) && needed.all(alike)
        }
        // A task that precedes others by rank may inherit a higher priority from them.
        TurnOrder::Plain => {
            let rises = claim.place.as_ref().is_some_and(|place| !place.rising.is_empty());
            rises || needed.all(|resource| resource.waiting.takes_in(&key))
        }
    };
    fits.then_some(key)
}

/// Returns true if ranks order the claimant and all tasks that wait for one of its resources.
fn ranks_among_all(cycle: &Cycle<'_>, claimant: &Claimant, claim: &QueuedClaim, key: &QueueKey) -> bool {
    let Some(rank) = key.rank else { return false };
    let mut needed = claimant.needs.iter().filter_map(|need| cycle.agent.resources.get(need.resource));
    needed.all(|Resource { waiting, .. }| {
        let separate = || !waiting.has_rank(rank) || claim.is_steady_within(key) && waiting.admits_rank(rank);
        waiting.is_empty() || waiting.parent_of_ranks() == Some(rank.parent) && separate()
    })
}

/// Returns the place of a task that claims, if it is in a queue.
pub(crate) fn key_of(cycle: &Cycle<'_>, task: TaskId) -> Option<QueueKey> {
    let agent = &*cycle.agent;
    let need = agent.task(task)?.selection.as_ref()?.needs.first().copied();
    let need = need.or_else(|| agent.task(task)?.extras.as_ref()?.held.first().copied())?;
    let waiting = &agent.resources.get(need.resource)?.waiting;
    waiting.key_of(task, waiting.order()?, risen_to(cycle))
}

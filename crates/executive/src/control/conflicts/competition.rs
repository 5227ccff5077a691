//! Competition (TC)
//! What: states the claims, the relations between claimants, and the order of arbitration.
//! Runs: contend phase.  Reads: Task, priorities, ranks.  Writes: nothing.
//! Bound: O(depth) per claimant.
//! PDL: `rank`, `priority`, section 9.  Paper: section III, highest priority competitor.

use crate::control::conflicts::precedence::Precedence;
use crate::control::conflicts::{priority, resources};
use crate::control::cycle::Cycle;
use crate::planted::{self, Bug};
use crate::state::agent::Agent;
use crate::state::queue_place::FamilyOrder;
use crate::state::resource::Need;
use crate::state::resource_id::ResourceId;
use crate::state::task::{Origin, Task};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use std::cmp::Ordering;
use std::collections::{BTreeSet, VecDeque};

/// A task that needs resources to become or remain ongoing.
#[derive(Clone)]
pub(crate) struct Claimant {
    /// Its number.
    pub(crate) id: TaskId,
    /// Required resources.
    pub(crate) needs: Vec<Need>,
    /// Its priority now. Where ranks count, at least that of every task that it precedes by rank.
    pub(crate) priority: f64,
    /// True if it has begun; it then precedes equal claimants that have not.
    pub(crate) begun: bool,
    order: FamilyOrder,
    /// Its place among all competitors where ranks count; equal for all if no task has a rank.
    pub(crate) turn: usize,
}

/// Returns true if the tasks are the same, or one is the ancestor of the other.
pub(crate) fn related(agent: &Agent, a: TaskId, b: TaskId) -> bool {
    let depth = |id: TaskId| agent.task(id).map_or(0, |task| task.depth);
    let (mut low, high) = if depth(a) >= depth(b) { (a, b) } else { (b, a) };
    while depth(low) > depth(high) {
        match agent.task(low).and_then(|task| task.parent) {
            Some(parent) => low = parent,
            None => return false,
        }
    }
    low == high
}

/// Compares the ranks of the two sibling ancestors, if both have one and they differ.
pub(crate) fn rank_order(agent: &Agent, a: TaskId, b: TaskId, now: Time) -> Option<(Ordering, f64, f64)> {
    let (mut a, mut b) = (agent.task(a)?, agent.task(b)?);
    while a.depth > b.depth {
        a = agent.task(a.parent?)?;
    }
    while b.depth > a.depth {
        b = agent.task(b.parent?)?;
    }
    while a.parent != b.parent {
        a = agent.task(a.parent?)?;
        b = agent.task(b.parent?)?;
    }
    let (first, second) = (priority::rank(agent, a.id, now)?, priority::rank(agent, b.id, now)?);
    let (first, second) = if planted::is(Bug::RanksReversed) { (second, first) } else { (first, second) };
    let order = first.partial_cmp(&second).filter(|order| *order != Ordering::Equal)?;
    Some((order, first, second))
}

/// Returns true if the task may work at all: no ancestor is suspended, and its parent is ongoing.
pub(crate) fn is_eligible(agent: &Agent, id: TaskId) -> bool {
    let Some(task) = agent.task(id) else { return false };
    let starts = match task.state {
        TaskState::Interrupted => true,
        TaskState::Enabled => {
            task.parent.is_none_or(|parent| agent.task(parent).is_some_and(|parent| parent.state == TaskState::Ongoing))
        }
        TaskState::Pending | TaskState::Ongoing | TaskState::Terminated => false,
    };
    if !starts || agent.suspended == 0 {
        return starts;
    }
    let mut family = std::iter::successors(Some(task), |task| agent.task(task.parent?));
    !family.any(|task| task.suspended)
}

/// Returns all claimants, best first, and the precedence that ordered them if ranks are stated.
pub(crate) fn in_order(
    agent: &Agent,
    now: Time,
    dirty: &BTreeSet<ResourceId>,
    orphans: &BTreeSet<TaskId>,
) -> (VecDeque<Claimant>, Option<Precedence>) {
    let mut found = competitors(agent, now, dirty, orphans, false);
    let mut precedence = None;
    let mut everybody = found.claimants.iter().map(|each| each.id).chain(found.holders.iter().copied());
    if everybody.any(|id| priority::is_ranked(agent, id)) {
        // A task that precedes a holder by rank, now or until now, may not claim what that holder has while others wait for it.
        found = competitors(agent, now, dirty, orphans, true);
        let holders = found.holders.iter().map(|id| claimant_in(agent, *id, now));
        precedence = Some(Precedence::of(agent, now, found.claimants.iter().cloned().chain(holders).collect()));
    }
    let mut claimants = found.claimants;
    if let Some(precedence) = &precedence {
        claimants.iter_mut().for_each(|claimant| precedence.apply(claimant));
        claimants.sort_by(compare);
    }
    (claimants.into(), precedence)
}

/// Competitors for a set of resources and for all other resources that these competitors need.
#[derive(Default)]
struct Competitors {
    /// Eligible claimants, best first.
    claimants: Vec<Claimant>,
    /// Holders of one of the resources.
    holders: BTreeSet<TaskId>,
}

/// Returns all tasks that compete for the resources in `dirty` and for the other resources of those claimants, without `orphans`. With
/// `through_holders` it also follows the needs of holders.
fn competitors(
    agent: &Agent,
    now: Time,
    dirty: &BTreeSet<ResourceId>,
    orphans: &BTreeSet<TaskId>,
    through_holders: bool,
) -> Competitors {
    let mut resources: Vec<ResourceId> = dirty.iter().copied().collect();
    let mut seen: BTreeSet<ResourceId> = dirty.clone();
    let mut tasks = orphans.clone();
    let mut found = Competitors::default();
    while let Some(id) = resources.pop() {
        let Some(resource) = agent.resources.get(id) else { continue };
        for task in resource.waiting.tasks() {
            if tasks.insert(task) && is_eligible(agent, task) {
                let claimant = claimant_in(agent, task, now);
                resources.extend(claimant.needs.iter().map(|need| need.resource).filter(|each| seen.insert(*each)));
                found.claimants.push(claimant);
            }
        }
        for holding in &resource.holders {
            if found.holders.insert(holding.task) && through_holders {
                let needs = resources::needs_in(agent, holding.task);
                resources.extend(needs.iter().map(|need| need.resource).filter(|each| seen.insert(*each)));
            }
        }
    }
    found.claimants.sort_by(compare);
    found
}

/// Returns the claim of the task with its priority.
pub(crate) fn as_claimant(cycle: &Cycle<'_>, id: TaskId) -> Claimant {
    claimant_in(cycle.agent, id, cycle.now)
}

/// Returns the claim of the task with its priority, outside of a cycle.
fn claimant_in(agent: &Agent, id: TaskId, now: Time) -> Claimant {
    let priority = priority::priority(agent, id, now);
    let begun = has_begun(agent, id);
    let (needs, order) = (resources::needs_in(agent, id), order_of(agent, id));
    Claimant { id, needs, priority, begun, order, turn: 0 }
}

/// Returns true if the task is at work, or was interrupted at work.
pub(crate) fn has_begun(agent: &Agent, id: TaskId) -> bool {
    agent.task(id).is_some_and(|task| matches!(task.state, TaskState::Ongoing | TaskState::Interrupted))
}

/// Returns the instant from which the task has been ongoing without a break, with its number: of tasks that began at one instant the one
/// created last counts as the latest.
pub(crate) fn at_work_since(agent: &Agent, id: TaskId) -> (Option<Time>, TaskId) {
    (agent.task(id).map(|task| task.since), id)
}

/// Returns the order of equal claimants: written order among siblings, creation order among others. Repeated tasks that have been ongoing
/// before come last.
pub(crate) fn order_of(agent: &Agent, id: TaskId) -> FamilyOrder {
    let Some(task) = agent.task(id) else { return (Time::BEGINNING, id, 0, id) };
    let step = match task.origin {
        Origin::Step(step) => step.step,
        Origin::Initial | Origin::Item(_) | Origin::OnFailure(_) | Origin::Meanwhile(_) | Origin::Probe(_) => 0,
    };
    (repeated_at(agent, task), task.parent.unwrap_or(id), step, id)
}

/// Returns the last repetition of the task or of its nearest repeated ancestor; the beginning of time if none was repeated.
fn repeated_at(agent: &Agent, task: &Task) -> Time {
    let family = std::iter::successors(Some(task), |task| agent.task(task.parent?));
    let repeated = |task: &Task| task.extras.as_ref().and_then(|extras| extras.ended_before);
    family.filter_map(repeated).max().unwrap_or(Time::BEGINNING)
}

/// Compares claimants: the lesser one precedes.
pub(crate) fn compare(a: &Claimant, b: &Claimant) -> Ordering {
    a.turn.cmp(&b.turn).then_with(|| by_priority(a, b))
}

/// Compares claimants without their ranks.
pub(crate) fn by_priority(a: &Claimant, b: &Claimant) -> Ordering {
    b.priority.total_cmp(&a.priority).then(b.begun.cmp(&a.begun)).then(a.order.cmp(&b.order))
}

/// Inserts a claimant at its place in the ordered list.
pub(crate) fn insert_in_order(list: &mut VecDeque<Claimant>, claimant: Claimant) {
    let index = list.partition_point(|each| compare(each, &claimant) == Ordering::Less);
    list.insert(index, claimant);
}

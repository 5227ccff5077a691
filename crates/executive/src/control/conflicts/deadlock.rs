//! Deadlocks (TC)
//! What: finds circles of tasks that wait for each other's resources, each held by the work of the next one, and reports them.
//! Runs: at the end of an instant, if a claim was refused whose ancestors hold a resource.
//! Reads: ResourceTable, Task.  Writes: Decision.
//! Bound: O(depth) for a refused claim; where its ancestors hold something, O(tasks below the holders) a round of the search.
//! PDL: `profile`, `hold-resource`, section 9.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::{competition, resources, sharing};
use crate::control::cycle::Cycle;
use crate::control::tasks::goal;
use crate::state::agent::Agent;
use crate::state::resource::{Holding, Need};
use crate::state::resource_id::ResourceId;
use apex_model::because::{Because, Cause, CircleLink};
use apex_model::effect::DecisionKind;
use apex_model::task::TaskId;
use apex_model::value::Value;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// A claim that was refused: each resource that it lacks, with its holders.
type Lacks = Vec<(ResourceId, Vec<Holding>)>;

/// The waits that one claim leads to.
#[derive(Default)]
struct Waits {
    /// Claims that wait for the work of others.
    claims: BTreeMap<TaskId, Lacks>,
    /// The claims below each holder: the holder continues only after they do.
    below: BTreeMap<TaskId, Vec<TaskId>>,
}

/// Reports the circles that the claims refused at this instant have closed.
pub(crate) fn look(cycle: &mut Cycle<'_>) {
    for id in std::mem::take(&mut cycle.work.refused) {
        if !has_holding_ancestor(cycle.agent, id) || !is_waiting(cycle.agent, id) {
            continue;
        }
        let Some(links) = circle(cycle.agent, id) else { continue };
        let circle: BTreeSet<TaskId> = links.iter().map(|link| link.task).collect();
        let agent = &*cycle.agent;
        let known = agent.circles.iter().filter(|circle| circle.iter().all(|id| is_waiting(agent, *id)));
        let mut known: Vec<BTreeSet<TaskId>> = known.cloned().collect();
        if !known.contains(&circle) {
            known.push(circle);
            report(cycle, id, links);
        }
        cycle.agent.circles = known;
    }
}

/// Returns true if the task claims a resource that it does not get.
fn is_waiting(agent: &Agent, id: TaskId) -> bool {
    let waits = |need: &Need| agent.resources.get(need.resource).is_some_and(|resource| resource.waiting.contains(id));
    resources::needs_in(agent, id).iter().any(waits)
}

fn has_holding_ancestor(agent: &Agent, id: TaskId) -> bool {
    let mut above = agent.task(id).and_then(|task| task.parent);
    while let Some(task) = above.and_then(|id| agent.task(id)) {
        let needs = task.selection.as_ref().is_some_and(|selection| !selection.needs.is_empty());
        if needs || task.extras.as_ref().is_some_and(|extras| !extras.held.is_empty()) {
            return true;
        }
        above = task.parent;
    }
    false
}

/// Returns all claims that `start` waits for, directly or through others. Leaves out claims that can be granted: the other holders leave
/// enough, or the holder has no such claim below it.
fn waits_from(agent: &Agent, start: TaskId) -> Waits {
    let mut waits = Waits::default();
    let mut open = vec![start];
    while let Some(id) = open.pop() {
        if waits.claims.contains_key(&id) {
            continue;
        }
        let lacks = lacks(agent, id);
        for holding in lacks.iter().flat_map(|(_, holders)| holders) {
            if let Entry::Vacant(slot) = waits.below.entry(holding.task) {
                let below = claims_below(agent, holding.task);
                open.extend(&below);
                slot.insert(below);
            }
        }
        waits.claims.insert(id, lacks);
    }
    loop {
        let before = waits.claims.len();
        let below = &waits.below;
        let keeps = |holder: &TaskId, claims: &BTreeMap<TaskId, Lacks>| {
            below.get(holder).is_some_and(|claims_of| claims_of.iter().any(|id| claims.contains_key(id)))
        };
        let known = waits.claims.clone();
        waits.claims.retain(|id, lacks| {
            lacks.retain_mut(|(_, holders)| {
                holders.retain(|holding| keeps(&holding.task, &known));
                !holders.is_empty()
            });
            lacks.iter().any(|(resource, holders)| is_short(agent, *id, *resource, holders))
        });
        if waits.claims.len() == before {
            return waits;
        }
    }
}

/// Returns the resources that the claim is refused, each with its holders outside of the claimant's family.
fn lacks(agent: &Agent, id: TaskId) -> Lacks {
    let waiting = |need: &Need| {
        let resource = agent.resources.get(need.resource)?;
        let others = resource.holders.iter().filter(|holding| !competition::related(agent, id, holding.task));
        let others: Vec<Holding> = others.copied().collect();
        (resource.waiting.contains(id) && !resource.depletable && !others.is_empty()).then_some((need.resource, others))
    };
    resources::needs_in(agent, id).iter().filter_map(waiting).collect()
}

/// Returns the claims below a task that are refused a resource.
fn claims_below(agent: &Agent, top: TaskId) -> Vec<TaskId> {
    let (mut found, mut open) = (Vec::new(), vec![top]);
    while let Some(id) = open.pop() {
        let Some(task) = agent.task(id) else { continue };
        if id != top && is_waiting(agent, id) {
            found.push(id);
        }
        open.extend(task.controller.iter().flat_map(|controller| controller.children()));
    }
    found.sort_unstable();
    found
}

/// Returns true if these holders leave less than `id` needs.
fn is_short(agent: &Agent, id: TaskId, resource: ResourceId, holders: &[Holding]) -> bool {
    let total = agent.resources.get(resource).map_or(f64::INFINITY, |resource| resource.total);
    let kept: f64 = holders.iter().map(|holding| holding.amount).sum();
    let needs = resources::needs_in(agent, id);
    needs.iter().any(|need| need.resource == resource && need.amount > total - kept + sharing::TOLERANCE)
}

/// Returns the shortest circle of waits that begins and ends with the claim of `start`.
fn circle_through(waits: &Waits, agent: &Agent, start: TaskId) -> Option<Vec<CircleLink>> {
    let mut came_from: BTreeMap<TaskId, (TaskId, CircleLink)> = BTreeMap::new();
    let mut open = VecDeque::from([start]);
    while let Some(id) = open.pop_front() {
        for (resource, holders) in waits.claims.get(&id).into_iter().flatten() {
            let name = agent.resources.get(*resource).map_or_else(Value::nil, |resource| resource.name.clone());
            for holding in holders {
                let link = CircleLink { task: id, resource: name.clone(), holder: holding.task };
                for next in waits.below.get(&holding.task).into_iter().flatten() {
                    if *next == start {
                        return Some(links_back(&came_from, start, link));
                    }
                    if waits.claims.contains_key(next) && !came_from.contains_key(next) {
                        came_from.insert(*next, (id, link.clone()));
                        open.push_back(*next);
                    }
                }
            }
        }
    }
    None
}

/// Returns the links of the search from `start` to `last`.
fn links_back(came_from: &BTreeMap<TaskId, (TaskId, CircleLink)>, start: TaskId, last: CircleLink) -> Vec<CircleLink> {
    let mut at = last.task;
    let mut links = vec![last];
    while at != start {
        let Some((before, link)) = came_from.get(&at) else { break };
        links.push(link.clone());
        at = *before;
    }
    links.reverse();
    links
}

/// Returns the circle of waits that contains the task, through its own claim or one below it; `None` if there is none.
pub(crate) fn circle_at(agent: &Agent, id: TaskId) -> Option<Vec<CircleLink>> {
    std::iter::once(id)
        .filter(|id| is_waiting(agent, *id))
        .chain(claims_below(agent, id))
        .find_map(|id| circle(agent, id))
}

fn circle(agent: &Agent, id: TaskId) -> Option<Vec<CircleLink>> {
    circle_through(&waits_from(agent, id), agent, id)
}

/// Returns the circle as one sentence, with the goals of the tasks.
pub(crate) fn circle_text(agent: &Agent, links: &[CircleLink]) -> String {
    let named = |task: TaskId| format!("{task} {}", goal::goal_in(agent, task, agent.now));
    let sentence = |link: &CircleLink| {
        format!("{} waits for {}, which {} holds", named(link.task), link.resource, named(link.holder))
    };
    links.iter().map(sentence).collect::<Vec<_>>().join("; ")
}

fn report(cycle: &mut Cycle<'_>, id: TaskId, links: Vec<CircleLink>) {
    let message = format!(
        "tasks wait for each other in a circle: {}; none of them continues unless something else ends one of them",
        circle_text(cycle.agent, &links)
    );
    let place = cycle.place_of(id);
    cycle.decide(Some(id), DecisionKind::Trouble { message }, Because::new(Cause::WaitsInCircle { links }, place));
}

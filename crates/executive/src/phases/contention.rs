//! Contention (TC)
//! What: submits the claimants to arbitration and commits the result: losses first, then grants.
//! Runs: contend and commit phases.  Reads: claims, ResourceTable.  Writes: ResourceTable, Task state, Decision, wakes.
//! Bound: O(claims) plus arbitration of the resources that changed.  PDL: section 9.  Paper: section III.

use crate::control::conflicts::arbitration::{Arbitration, Defeat, Refusal, Rival};
use crate::control::conflicts::crossing;
use crate::control::conflicts::crossing::Defender;
use crate::control::conflicts::curve::Curve;
use crate::control::conflicts::{claim_queue, competition, priority, queues, resolution, resources};
use crate::control::cycle::{Cycle, in_order};
use crate::control::tasks::{interruption, termination};
use crate::control::transition::{Trigger, transition};
use crate::planted;
use crate::planted::Bug;
use crate::state::agent::Agent;
use crate::state::resource::Need;
use crate::state::resource_id::ResourceId;
use crate::state::task::Task;
use crate::state::wake::Wake;
use apex_model::because::{Because, Cause, Share};
use apex_model::effect::DecisionKind;
use apex_model::quantity::Dimension;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Runs the contend phase and returns the arbitration to commit.
pub(crate) fn contend(cycle: &mut Cycle<'_>) -> Arbitration {
    let work = &cycle.work;
    let changed = work.priorities_changed || work.inheritance_changed;
    if work.claims.is_empty() && work.dirty.is_empty() && !changed {
        return Arbitration::default();
    }
    let mut free = Vec::new();
    let mut fresh: BTreeMap<ResourceId, Vec<TaskId>> = BTreeMap::new();
    for id in in_order(&mut cycle.work.claims) {
        if !competition::is_eligible(cycle.agent, id) || waits_for_parent(cycle, id) {
            continue;
        }
        let needs = resources::needs_of(cycle, id);
        if needs.is_empty() {
            free.push(id);
            continue;
        }
        let claim = claim_queue::claim_of(cycle, id, &needs);
        for need in needs {
            if let Some(resource) = cycle.agent.resources.get_mut(need.resource) {
                resource.waiting.insert(id, claim.clone().of(need.resource, need.amount));
                cycle.work.dirty.insert(need.resource);
                fresh.entry(need.resource).or_default().push(id);
            }
        }
    }
    look_again(cycle);
    let dirty = std::mem::take(&mut cycle.work.dirty);
    for id in &dirty {
        if let Some(resource) = cycle.agent.resources.get_mut(*id) {
            resource.waiting.settle(cycle.now);
        }
    }
    let mut result =
        if dirty.is_empty() { Arbitration::default() } else { resolution::arbitrate(cycle, &dirty, &fresh) };
    result.granted.extend(free);
    // Ancestors stop before their descendants, as in a suspension.
    result.displaced.sort_by_key(|loss| (cycle.task(loss.loser).map_or(0, |task| task.depth), loss.loser));
    // Interrupted tasks come first, leaves before their ancestors; then new ones in written order.
    result.granted.sort_by_key(|id| {
        let task = cycle.task(*id);
        let depth = task.map_or(0, |task| task.depth);
        match task.map(|task| task.state) {
            Some(TaskState::Interrupted) if planted::is(Bug::AncestorsFirst) => (0, depth, *id),
            // A task that loses its resources and is granted them again at once is interrupted in between.
            Some(TaskState::Interrupted | TaskState::Ongoing) => (0, u32::MAX - depth, *id),
            _ => (1, 0, *id),
        }
    });
    result
}

/// Returns true if the parent of an enabled task may resume at this instant: all of its steps compete together once it has resumed.
fn waits_for_parent(cycle: &Cycle<'_>, id: TaskId) -> bool {
    let resuming = &cycle.work.resuming;
    if resuming.is_empty() || cycle.state(id) != TaskState::Enabled {
        return false;
    }
    cycle.task(id).and_then(|task| task.parent).is_some_and(|parent| resuming.contains(&parent))
}

/// Marks resources for arbitration because an input of priorities changed, and discards all computed turns.
fn look_again(cycle: &mut Cycle<'_>) {
    let values = std::mem::take(&mut cycle.work.priorities_changed);
    let inherited = std::mem::take(&mut cycle.work.inheritance_changed);
    if !values && !inherited {
        return;
    }
    let contested = cycle.agent.resources.iter().filter(|(_, resource)| !resource.waiting.is_empty());
    let concerned = contested.filter(|(id, resource)| {
        let mut holders = resource.holders.iter();
        inherited
            || resource.waiting.is_sensitive() && !queues::is_by_rank(cycle, *id)
            || holders.any(|holding| !claim_queue::is_steady(cycle.agent, holding.task))
    });
    let concerned: Vec<ResourceId> = concerned.map(|(id, _)| id).collect();
    for id in &concerned {
        let Some(resource) = cycle.agent.resources.get(*id) else { continue };
        // A claimant whose place does not depend on measurements is considered only if its inherited priority changed.
        let waiting: Vec<TaskId> = match inherited {
            true => resource.waiting.tasks().collect(),
            false if queues::is_by_rank(cycle, *id) => Vec::new(),
            false => resource.waiting.sensitive().collect(),
        };
        for task in waiting {
            let needs = resources::needs_of(cycle, task);
            let amount = needs.iter().find(|need| need.resource == *id).map_or(0.0, |need| need.amount);
            let claim = claim_queue::claim_of(cycle, task, &needs).of(*id, amount);
            if let Some(resource) = cycle.agent.resources.get_mut(*id) {
                resource.waiting.insert(task, claim);
            }
        }
    }
    cycle.work.dirty.extend(concerned);
}

/// Executes the commit phase: changes states as arbitrated.
pub(crate) fn commit(cycle: &mut Cycle<'_>, arbitration: Arbitration) {
    let begun = begun_by(cycle, &arbitration);
    let changes = !arbitration.granted.is_empty() || !arbitration.displaced.is_empty();
    for loss in &arbitration.displaced {
        let because = Because::new(outranked(cycle, loss), cycle.place_of(loss.loser));
        interruption::outrank(cycle, loss.loser, because);
        // The refusal of a displaced task is the loss itself, so it is not reported again.
        if let Some(task) = cycle.agent.task_mut(loss.loser) {
            let extras = task.extras_mut();
            (extras.refused, extras.refusal_told) = (Some((loss.resource, loss.winner)), true);
        }
    }
    for (id, resource, needed, left) in arbitration.impossible {
        // A renewable resource may be replenished, and most tasks wait for that instead of failing.
        let full = cycle.agent.resources.get(resource).and_then(|resource| resource.renewable);
        if full.is_some_and(|full| needed <= full) && !refuses_to_wait(cycle, id) {
            continue;
        }
        let name = resource_name(cycle, resource);
        let dimension = cycle.agent.resources.get(resource).map_or(Dimension::NONE, |resource| resource.dimension);
        let (needed, left) = (amount(needed, dimension), amount(left, dimension));
        let cause = Cause::ResourceExhausted { resource: name, needed, left };
        let place = cycle.place_of(id);
        termination::fail(cycle, id, Because::new(cause, place));
    }
    for id in arbitration.granted {
        grant(cycle, id);
    }
    for refusal in &arbitration.refused {
        let displaced = arbitration.displaced.iter().any(|loss| loss.loser == refusal.loss.loser);
        if !displaced {
            refuse(cycle, &refusal.loss);
        }
        watch_crossing(cycle, refusal.loss.loser, &refusal.stands_for, &refusal.rivals);
    }
    for watch in &arbitration.watched {
        watch_crossing(cycle, watch.task, &watch.stands_for, &watch.rivals);
    }
    look_behind(cycle, &begun, &arbitration.refused);
    give_up(cycle, &arbitration.refused);
    if changes {
        // The parents of barred tasks continue, so these tasks compete again.
        for id in arbitration.barred {
            let needs = resources::needs_of(cycle, id);
            cycle.work.dirty.extend(needs.into_iter().map(|need| need.resource));
        }
    }
    // Clearing an empty collection has a cost.
    if !cycle.work.resumed.is_empty() {
        cycle.work.resumed.clear();
    }
}

/// Fails refused tasks whose profile contains `:refuse-if-busy` and that have not begun.
fn give_up(cycle: &mut Cycle<'_>, refused: &[Refusal]) {
    let mut losses: Vec<&Defeat> = refused.iter().map(|refusal| &refusal.loss).collect();
    losses.sort_by_key(|loss| loss.loser);
    for loss in losses {
        if refuses_to_wait(cycle, loss.loser) {
            let cause = Cause::ResourceBusy { resource: resource_name(cycle, loss.resource), holder: loss.winner };
            let place = cycle.place_of(loss.loser);
            termination::fail(cycle, loss.loser, Because::new(cause, place));
        }
    }
}

/// Returns true if the task has not begun and fails instead of waiting.
fn refuses_to_wait(cycle: &Cycle<'_>, id: TaskId) -> bool {
    let refuses = |task: &Task| task.selection.as_ref().is_some_and(|selection| selection.refuses);
    cycle.task(id).is_some_and(|task| task.state == TaskState::Enabled && refuses(task))
}

/// Returns the tasks that begin by this arbitration while others are refused; only tasks that may precede others by rank.
fn begun_by(cycle: &Cycle<'_>, arbitration: &Arbitration) -> Vec<TaskId> {
    if arbitration.refused.is_empty() {
        return Vec::new();
    }
    let begins = |id: &TaskId| cycle.state(*id) == TaskState::Enabled && priority::is_ranked(cycle.agent, *id);
    arbitration.granted.iter().copied().filter(begins).collect()
}

/// Marks the claims of interrupted tasks that a beginning task precedes: begun work precedes its equals unless a task that has not begun
/// precedes it by rank.
fn look_behind(cycle: &mut Cycle<'_>, begun: &[TaskId], refused: &[Refusal]) {
    if begun.is_empty() {
        return;
    }
    for waits in refused.iter().map(|refusal| refusal.loss.loser) {
        let before = |id: &TaskId| competition::rank_order(cycle.agent, *id, waits, cycle.now);
        let is_behind = |id: &TaskId| before(id).is_some_and(|(order, ..)| order == Ordering::Less);
        if cycle.state(waits) == TaskState::Interrupted && begun.iter().any(is_behind) {
            let needs = resources::needs_of(cycle, waits);
            cycle.work.dirty.extend(needs.into_iter().map(|need| need.resource));
        }
    }
}

/// Returns an amount of a resource for operators: whole units of a capacity, a quantity of a depletable.
fn amount(number: f64, dimension: Dimension) -> Value {
    if dimension == Dimension::NONE && libm::trunc(number) == number {
        return Value::Integer(number as i64);
    }
    Value::measured(number, dimension)
}

fn resource_name(cycle: &Cycle<'_>, id: ResourceId) -> Value {
    cycle.agent.resources.get(id).map_or_else(Value::nil, |resource| resource.name.clone())
}

/// Returns the granted share; all of a resource needs no amount.
fn share(cycle: &Cycle<'_>, need: &Need) -> Share {
    let Some(resource) = cycle.agent.resources.get(need.resource) else {
        return Share { resource: Value::nil(), amount: None };
    };
    let part = need.amount < resource.total || resource.depletable;
    Share { resource: resource.name.clone(), amount: part.then(|| amount(need.amount, resource.dimension)) }
}

fn outranked(cycle: &Cycle<'_>, loss: &Defeat) -> Cause {
    Cause::Outranked {
        by: loss.winner,
        resource: resource_name(cycle, loss.resource),
        rule: loss.rule,
        winner: loss.winner_strength,
        loser: loss.loser_strength,
    }
}

fn grant(cycle: &mut Cycle<'_>, id: TaskId) {
    if !competition::is_eligible(cycle.agent, id) {
        return;
    }
    let needs = resources::needs_of(cycle, id);
    resources::take(cycle, id, &needs);
    cycle.agent.unsteady.remove(&id);
    if let Some(extras) = cycle.agent.task_mut(id).and_then(|task| task.extras.as_mut()) {
        (extras.refused, extras.refusal_told) = (None, false);
        if let Some(wake) = extras.crossing.take() {
            cycle.agent.wakes.cancel(wake);
        }
    }
    let resources = needs.iter().map(|need| share(cycle, need)).collect();
    let resumed = cycle.work.resumed.remove(&id).filter(|_| cycle.state(id) == TaskState::Interrupted);
    let because = resumed.unwrap_or_else(|| Because::new(Cause::ResourcesGranted { resources }, cycle.place_of(id)));
    if transition(cycle, id, Trigger::Granted, None, because) {
        cycle.work.starting.push(id);
    }
}

/// Reports the refusal once for each claim, with the task that won. Later holders are visible in the resource: a hundred thousand waiting
/// tasks must not report each of them.
fn refuse(cycle: &mut Cycle<'_>, loss: &Defeat) {
    let Some(extras) = cycle.agent.task_mut(loss.loser).map(|task| task.extras_mut()) else { return };
    let is_new = extras.refused.replace((loss.resource, loss.winner)) != Some((loss.resource, loss.winner));
    let is_told = extras.refusal_told;
    if is_new || !is_told {
        cycle.work.refused.push(loss.loser);
    }
    let Some(extras) = cycle.agent.task_mut(loss.loser).map(|task| task.extras_mut()) else { return };
    if std::mem::replace(&mut extras.refusal_told, true) {
        return;
    }
    let kind = DecisionKind::Refused { resource: resource_name(cycle, loss.resource), winner: loss.winner };
    let because = Because::new(outranked(cycle, loss), cycle.place_of(loss.loser));
    cycle.decide(Some(loss.loser), kind, because);
}

/// Returns the instant at which a priority that counts for the refused task may exceed that of a blocking task.
fn next_crossing(
    agent: &Agent,
    stands_for: &[TaskId],
    contests: Vec<(TaskId, Option<TaskId>)>,
    now: Time,
) -> Option<Time> {
    let challengers: Vec<Curve<'_>> = stands_for.iter().map(|id| Curve::new(agent, *id, now)).collect();
    let defender = |(rival, holder): (TaskId, Option<TaskId>)| Defender::new(agent, rival, holder, now);
    let defenders: Vec<Defender<'_>> = contests.into_iter().map(defender).collect();
    crossing::next_look(agent, &challengers, &defenders, now)
}

/// Schedules a wake for the instant at which the priorities of the task and of its rivals may cross.
fn watch_crossing(cycle: &mut Cycle<'_>, loser: TaskId, stands_for: &[TaskId], rivals: &[Rival]) {
    // Many rivals can be represented by the same tasks.
    let mut concerned = stands_for.to_vec();
    let mut contests: Vec<(TaskId, Option<TaskId>)> = Vec::new();
    for rival in rivals {
        let holds = rival.holds || cycle.state(rival.task) == TaskState::Ongoing;
        concerned.push(rival.task);
        concerned.extend(rival.stands_for.iter());
        if competition::rank_order(cycle.agent, loser, rival.task, cycle.now).is_none() {
            contests.extend(rival.stands_for.iter().map(|other| (*other, holds.then_some(rival.task))));
        }
    }
    contests.sort_unstable();
    contests.dedup();
    concerned.sort_unstable();
    concerned.dedup();
    let agent: &Agent = cycle.agent;
    let moving = !contests.is_empty() && concerned.iter().any(|each| priority::moves(agent, *each));
    let at = moving.then(|| next_crossing(agent, stands_for, contests, cycle.now)).flatten();
    if concerned.iter().any(|each| priority::reads_inputs(cycle.agent, *each)) {
        cycle.agent.unsteady.insert(loser);
    }
    let Some(task) = cycle.agent.task_mut(loser) else { return };
    let before = task.extras_mut().crossing;
    if before.map(|wake| wake.at) == at {
        return;
    }
    if let Some(wake) = before {
        cycle.agent.wakes.cancel(wake);
    }
    let wake = at.map(|at| cycle.agent.wakes.schedule(at, Wake::PriorityCrossing(loser)));
    if let Some(task) = cycle.agent.task_mut(loser) {
        task.extras_mut().crossing = wake;
    }
}

//! Priorities of ranked families that may cross (TC)
//! What: names the claimants of ranked families whose priorities may rise above those of tasks in their way.
//! Runs: contend phase, for `families`.  Reads: ResourceTable, priorities, ranks.  Writes: nothing.
//! Bound: O(q * (f + h) + (f + h) * m) for q kinds of priorities, f claimants that could fit, h holders and m claimants of one family.
//! PDL: `priority`, `rank`, section 9, conflict; decision 0204.  Paper: section III, priority of competitors.
//!
//! Who gets a resource follows from the order of the first claimants and the holders by their own priorities. Of the claimants behind
//! them, those of one importance never overtake one another, so the first of each kind suffices.

use crate::control::conflicts::arbitration::{Arbitration, PriorityWatch, Rival};
use crate::control::conflicts::claim_queue::{fixed_ranks, worth_of};
use crate::control::conflicts::competition::is_eligible;
use crate::control::conflicts::family_turns::{OwnTurns, is_greater, is_lower};
use crate::control::conflicts::priority;
use crate::control::cycle::Cycle;
use crate::state::queue_place::QueuePlace;
use crate::state::waiting::Waiting;
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// The claimants and holders that a pass through ranked families has reached.
pub(super) struct Reached<'a, 'c> {
    pub(super) cycle: &'a Cycle<'c>,
    pub(super) waiting: &'a Waiting,
    /// Tasks that held the common resource before.
    pub(super) holders: Vec<TaskId>,
    /// Claimants for whose priority others took their turns, and claimants that had been reached before.
    pub(super) roots: Vec<TaskId>,
}

/// Returns the claimants of the pass whose priorities may cross those of tasks in their way.
pub(super) fn watched(
    pass: &Reached<'_, '_>,
    turns: &mut OwnTurns<'_, '_>,
    result: &Arbitration,
) -> Vec<PriorityWatch> {
    let agent = &*pass.cycle.agent;
    let moves = |task: TaskId| priority::moves(agent, task);
    if !pass.waiting.has_rising() && !pass.holders.iter().any(|holder| moves(*holder)) {
        return Vec::new();
    }
    let granted: BTreeSet<TaskId> = result.granted.iter().copied().collect();
    let lost: BTreeSet<TaskId> =
        result.displaced.iter().map(|loss| loss.loser).filter(|id| !granted.contains(id)).collect();
    let stays = pass.holders.iter().copied().filter(|id| !lost.contains(id));
    let holders: BTreeSet<TaskId> = granted.iter().copied().chain(stays).collect();
    let waits = pass.roots.iter().copied().chain(lost).filter(|id| !holders.contains(id));
    let waits: BTreeSet<TaskId> = waits.collect();
    let mut challengers: BTreeMap<TaskId, Vec<TaskId>> = BTreeMap::new();
    for task in turns.heads(&holders).into_iter().chain(waits.iter().copied()).filter(|id| !holders.contains(id)) {
        challengers.entry(task).or_insert_with(|| vec![task]);
    }
    // The priority of a holder counts for the claimants that precede it, too.
    for holder in holders.iter().filter(|id| moves(**id)) {
        if let Some(first) = first_before(pass, *holder, &holders) {
            challengers.entry(first).or_insert_with(|| vec![first]).push(*holder);
        }
    }
    let held = holders.iter().map(|id| rival(pass, *id, &holders));
    let rivals: Vec<(Rival, Option<QueuePlace>)> = held
        .chain(waits.iter().map(|id| Rival { task: *id, holds: false, stands_for: Rc::new([*id]) }))
        .map(|rival| (worth_of(pass.cycle, rival.task), rival))
        .map(|(worth, rival)| (rival, worth))
        .collect();
    let watch = |(task, stands_for): (TaskId, Vec<TaskId>)| {
        let places: Vec<Option<QueuePlace>> = stands_for.iter().map(|id| worth_of(pass.cycle, *id)).collect();
        let may_overtake = |other: &Option<QueuePlace>| {
            places.iter().any(|own| own.as_ref().zip(other.as_ref()).is_none_or(|(own, other)| own.may_overtake(other)))
        };
        let rivals = rivals.iter().filter(|(rival, place)| rival.task != task && may_overtake(place));
        PriorityWatch { task, stands_for: stands_for.into(), rivals: rivals.map(|(rival, _)| rival.clone()).collect() }
    };
    challengers.into_iter().map(watch).collect()
}

/// Returns a task that has the resource, with the tasks of its family that it precedes.
fn rival(pass: &Reached<'_, '_>, task: TaskId, holders: &BTreeSet<TaskId>) -> Rival {
    let mut stands_for = vec![task];
    if let Some(rank) = fixed_ranks(pass.cycle.agent, task).next() {
        let waiting = pass.waiting.below(rank.parent).filter(|key| is_greater(key, rank.rank)).map(|key| key.task());
        stands_for.extend(waiting.filter(|id| is_eligible(pass.cycle.agent, *id) && !holders.contains(id)));
        let behind = |id: &TaskId| {
            let other = fixed_ranks(pass.cycle.agent, *id).next();
            other.is_some_and(|other| other.parent == rank.parent && other.rank > rank.rank)
        };
        stands_for.extend(holders.iter().copied().filter(behind));
    }
    Rival { task, holds: true, stands_for: stands_for.into() }
}

/// Returns the first claimant that precedes the holder by rank.
fn first_before(pass: &Reached<'_, '_>, holder: TaskId, holders: &BTreeSet<TaskId>) -> Option<TaskId> {
    let rank = fixed_ranks(pass.cycle.agent, holder).next()?;
    let mut before = pass.waiting.below(rank.parent).take_while(|key| is_lower(key, rank.rank)).map(|key| key.task());
    before.find(|id| is_eligible(pass.cycle.agent, *id) && !holders.contains(id))
}

//! Arbitration at the front of queues (TC)
//! What: arbitrates resources by inspecting only those claimants in their queues that could get a resource.
//! Runs: contend phase, before conflict resolution, which arbitrates the cases that queues cannot decide.
//! Reads: ResourceTable, priorities, ancestors.  Writes: nothing.
//! Bound: O((f + n) * r * log c) for c claimants, f of which fit at the front, n that claim since this round, and r
//! resources of one claimant; plus O(q) for q resources that claimants need together, where tasks say how long they take.
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.
//!
//! A refused claimant keeps its place, so everything that the claimants in front need is not free for the next one. Once that sum, plus
//! what stronger tasks hold, exceeds a resource, all further claimants are refused. The claimants before this point, and those before
//! them in any of their queues, go through conflict resolution. Only a task that fills a gap can begin ahead of others: if one might, all
//! claimants are compared.

use crate::control::conflicts::arbitration::{Arbitration, PriorityWatch, Refusal};
use crate::control::conflicts::claim_queue::watches;
use crate::control::conflicts::competition::{Claimant, as_claimant, is_eligible};
use crate::control::conflicts::conflict::{Field, Placement, left_behind};
use crate::control::conflicts::queues::{has_equal_ranks, in_turn, key_of, key_of_loser, usable};
use crate::control::conflicts::sharing::{TOLERANCE, Use, UseKind};
use crate::control::conflicts::{equal_ranks, gaps, priority};
use crate::control::cycle::Cycle;
use crate::state::queue_place::{QueueKey, TurnOrder};
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use crate::state::turns::TurnSource;
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::collections::{BTreeMap, BTreeSet};
use std::iter::Peekable;

/// Arbitrates the resources in `dirty` and those that displaced tasks leave; `fresh` are the claims of this round. `None` if the
/// claimants must be compared with one another.
pub(crate) fn decide(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, fresh: &BTreeSet<TaskId>) -> Option<Arbitration> {
    let mut dirty = dirty.clone();
    let mut gone = BTreeSet::new();
    loop {
        let mut front = Front::new(cycle, gone.clone());
        dirty.iter().try_for_each(|id| front.look_at(*id))?;
        let result = front.place_all(fresh)?;
        let known = (dirty.len(), gone.len());
        dirty.extend(left_behind(cycle, &result));
        gone.extend(result.displaced.iter().map(|loss| loss.loser));
        if (dirty.len(), gone.len()) == known {
            let whole = !front.may_leave_a_gap(&dirty, &result);
            return if whole { Some(result) } else { gaps::decide(cycle, &dirty, fresh) };
        }
    }
}

/// Claimants at the front while they are placed.
struct Front<'a, 'c> {
    cycle: &'a Cycle<'c>,
    field: Field<'a, 'c>,
    /// Tasks that lose their resources: what they hold counts as free.
    gone: BTreeSet<TaskId>,
    candidates: BTreeSet<QueueKey>,
    placed: BTreeSet<TaskId>,
    queues: BTreeMap<ResourceId, Queue<'a>>,
    /// The first claimant of each queue that does not fit, with the resource.
    outside: Vec<(TaskId, ResourceId)>,
    /// The order of the queues: by rank below one task, or without ranks.
    order: Option<TurnOrder>,
}

/// A queue, with the state of the pass through it.
struct Queue<'a> {
    rest: Peekable<Box<dyn Iterator<Item = QueueKey> + 'a>>,
    /// Sum of the needs of the claimants passed so far.
    claimed: f64,
    /// The last claimant passed.
    last: Option<QueueKey>,
}

impl<'a, 'c> Front<'a, 'c> {
    fn new(cycle: &'a Cycle<'c>, gone: BTreeSet<TaskId>) -> Front<'a, 'c> {
        let field = Field::brief(cycle);
        let (candidates, placed) = (BTreeSet::new(), BTreeSet::new());
        Front { cycle, field, gone, candidates, placed, queues: BTreeMap::new(), outside: Vec::new(), order: None }
    }

    /// Finds the claimants of a resource that could fit into it.
    fn look_at(&mut self, id: ResourceId) -> Option<()> {
        let resource = usable(self.cycle, id)?;
        self.meet_ranks(resource)?;
        let holders: Vec<Use> = resource
            .holders
            .iter()
            .filter(|holding| !self.gone.contains(&holding.task))
            .map(|holding| Use { task: holding.task, amount: holding.amount, kind: UseKind::Held })
            .collect();
        let held: f64 = holders.iter().map(|each| each.amount).sum();
        let ranked = resource.waiting.priority_of_ranked() != Ok(None);
        let (mut claimed, mut beats, mut last) = (0.0, true, None);
        let mut turns = in_turn(self.cycle, &resource.waiting);
        let outside = loop {
            let Some(key) = Iterator::next(&mut turns) else { break None };
            if !is_eligible(self.cycle.agent, key.task()) {
                continue;
            }
            same_rank_is_unbegun(&mut last, key)?;
            let claimant = as_claimant(self.cycle, key.task());
            let amount = amount_of(&claimant, id);
            let beaten = if beats { self.beaten(&claimant, id, &holders) } else { 0.0 };
            // Later claimants are weaker, except where ranks count.
            beats = ranked || beaten > 0.0;
            let finds_room = held - beaten + claimed + amount <= resource.total + TOLERANCE;
            if finds_room {
                self.candidates.insert(key);
            } else if !ranked || claimed > resource.total + TOLERANCE {
                break Some(key);
            }
            claimed += amount;
        };
        let heads = turns.heads_that(&|task| is_eligible(self.cycle.agent, task));
        self.outside.extend(outside.into_iter().chain(heads).map(|key| (key.task(), id)));
        Some(())
    }

    /// Checks that all queues in the order of ranks are below one task; `None` if they are below several, because a claimant then has a
    /// place below each.
    fn meet_ranks(&mut self, resource: &Resource) -> Option<()> {
        match resource.waiting.order()? {
            TurnOrder::Plain => Some(()),
            order => (*self.order.get_or_insert(order) == order).then_some(()),
        }
    }

    fn beaten(&self, claimant: &Claimant, id: ResourceId, holders: &[Use]) -> f64 {
        let beaten = holders.iter().filter(|rival| self.field.confront(claimant, id, rival).is_ok());
        beaten.map(|rival| rival.amount).sum()
    }

    /// Places the candidates and the claims of this round in the order of their turns.
    fn place_all(&mut self, fresh: &BTreeSet<TaskId>) -> Option<Arbitration> {
        for task in fresh {
            self.candidates.extend(key_of(self.cycle, *task));
        }
        let mut result = Arbitration::default();
        while let Some(key) = self.candidates.pop_first() {
            let claimant = as_claimant(self.cycle, key.task());
            for need in &claimant.needs {
                self.pass_until(need.resource, key)?;
            }
            self.placed.insert(claimant.id);
            match self.field.place(&claimant) {
                Placement::Granted(losses) => {
                    for loss in losses {
                        self.candidates.insert(key_of_loser(self.cycle, &loss)?);
                        result.displaced.push(loss);
                    }
                    result.granted.push(claimant.id);
                }
                // Only the first claimant outside is watched for a change by time, so the others keep no rivals.
                Placement::Refused(refusal) => result.refused.push(Refusal { rivals: Vec::new(), ..refusal }),
                Placement::Impossible(need, total) => {
                    result.impossible.push((claimant.id, need.resource, need.amount, total));
                }
            }
        }
        result.watched = self.watched(&result);
        let has_order = match self.order {
            Some(TurnOrder::Below(parent)) => self.is_decided(parent, &result),
            _ => true,
        };
        has_order.then_some(result)
    }

    /// Returns true if ranks below `parent` decide for all tasks that need one of the inspected resources.
    fn is_decided(&self, parent: TaskId, result: &Arbitration) -> bool {
        if !result.displaced.is_empty() && !self.all_need_one() {
            return false;
        }
        let resources = &self.cycle.agent.resources;
        let mut open: Vec<ResourceId> =
            self.queues.keys().copied().chain(self.outside.iter().map(|each| each.1)).collect();
        let mut concerned = BTreeMap::new();
        while let Some((id, resource)) = open.pop().and_then(|id| Some((id, resources.get(id)?))) {
            if concerned.insert(id, resource).is_none() {
                open.extend(resource.waiting.others());
            }
        }
        if !result.displaced.is_empty() && equal_ranks::have_tied_holders(self.cycle, &concerned, parent) {
            return false;
        }
        let equal = concerned.values().any(|resource| has_equal_ranks(self.cycle.agent, resource, parent));
        !equal || equal_ranks::are_decided(self.cycle, &concerned, parent, result)
    }

    /// Returns true if all placed tasks need one common resource. Ranks order only tasks that share a resource: the order of the others
    /// matters if holders are displaced.
    fn all_need_one(&self) -> bool {
        let needs = |task: &TaskId| as_claimant(self.cycle, *task).needs.into_iter().map(|need| need.resource);
        let mut placed = self.placed.iter().map(|task| needs(task).collect::<BTreeSet<ResourceId>>());
        let common = placed.next().map(|first| placed.fold(first, |common, each| &common & &each));
        common.is_none_or(|common| !common.is_empty())
    }

    /// Notes the needs of the claimants before `key` in the queue of a resource.
    fn pass_until(&mut self, id: ResourceId, key: QueueKey) -> Option<()> {
        if !self.queues.contains_key(&id) {
            let resource = usable(self.cycle, id)?;
            self.meet_ranks(resource)?;
            let rest: Box<dyn Iterator<Item = QueueKey> + 'a> = Box::new(in_turn(self.cycle, &resource.waiting));
            self.queues.insert(id, Queue { rest: rest.peekable(), claimed: 0.0, last: None });
        }
        let total = self.field.total(id);
        let queue = self.queues.get_mut(&id)?;
        // Once the claims exceed the resource, all further claimants are refused.
        while queue.claimed <= total + TOLERANCE
            && let Some(next) = queue.rest.next_if(|next| *next <= key)
        {
            let task = next.task();
            if !is_eligible(self.cycle.agent, task) {
                continue;
            }
            same_rank_is_unbegun(&mut queue.last, next)?;
            let claimant = as_claimant(self.cycle, task);
            queue.claimed += amount_of(&claimant, id);
            if next != key && !self.placed.contains(&task) {
                let awaited = Use { task, amount: amount_of(&claimant, id), kind: UseKind::Awaited(None) };
                self.field.add(id, awaited);
            }
        }
        Some(())
    }

    /// Returns the first claimants that do not fit, whose priorities may rise above those of tasks in their way.
    fn watched(&mut self, result: &Arbitration) -> Vec<PriorityWatch> {
        // If no claimant was placed, no resource has been inspected yet.
        self.outside.iter().for_each(|(_, id)| self.field.load(*id));
        let agent = &*self.cycle.agent;
        let mut contests: BTreeMap<TaskId, BTreeMap<TaskId, bool>> = BTreeMap::new();
        for (task, id) in &self.outside {
            let Some(resource) = agent.resources.get(*id) else { continue };
            let moves = |task: TaskId| priority::moves(agent, task) || priority::reads_inputs(agent, task);
            let rivals = || self.field.uses_of(*id).iter().filter(|each| each.task != *task);
            let any = resource.waiting.has_rising() || rivals().any(|each| moves(each.task));
            // Priorities do not count between tasks that ranks order.
            let parent = resource.waiting.ordered_below();
            let by_rank = parent.is_some_and(|parent| !has_equal_ranks(agent, resource, parent));
            if !any || by_rank || result.granted.contains(task) {
                continue;
            }
            let rivals = rivals().map(|each| (each.task, !matches!(each.kind, UseKind::Awaited(_))));
            contests.entry(*task).or_default().extend(rivals);
        }
        watches(self.cycle, contests)
    }

    /// Returns true if a task could end before one in front of it can begin. This requires free capacity that another task
    /// awaits, and a task with a known duration.
    fn may_leave_a_gap(&self, dirty: &BTreeSet<ResourceId>, result: &Arbitration) -> bool {
        let agent = &*self.cycle.agent;
        let granted: BTreeSet<TaskId> = result.granted.iter().copied().collect();
        let lost: Vec<Claimant> = result
            .displaced
            .iter()
            .filter(|loss| !granted.contains(&loss.loser))
            .map(|loss| as_claimant(self.cycle, loss.loser))
            .collect();
        let mut open: Vec<ResourceId> = dirty.iter().copied().collect();
        let mut seen = dirty.clone();
        let (mut latest, mut shortest) = (None, None);
        while let Some(resource) = open.pop().and_then(|id| Some((id, agent.resources.get(id)?))) {
            let (id, resource) = resource;
            // An ancestor that holds the resource leaves it free for its descendants: its queue alone does not show a gap.
            if usable(self.cycle, id).is_none() && resource.waiting.shortest(resource.total + TOLERANCE).is_some() {
                return true;
            }
            let mut used = 0.0;
            for each in self.field.users(id, resource) {
                used += each.amount;
                latest = latest.max(self.field.expected_end(&each));
            }
            let waiting = &resource.waiting;
            let served = granted.iter().filter(|task| waiting.contains(**task)).count();
            let losers: Vec<&Claimant> = lost.iter().filter(|each| amount_of(each, id) > 0.0).collect();
            // A gap needs one task that leaves it and one that fills it.
            let waits = waiting.len() + losers.len() > served + 1;
            if waits && used < resource.total - TOLERANCE {
                let expected = |each: &&Claimant| agent.task(each.id)?.selection.as_ref()?.expected;
                let known = losers.iter().filter_map(expected);
                let fitting = waiting.shortest(resource.total - used + TOLERANCE);
                shortest = [shortest, fitting].into_iter().flatten().chain(known).min();
            }
            let matters = |id: &ResourceId| {
                agent.resources.get(*id).is_some_and(|other| other.waiting.len() > 1 || !other.holders.is_empty())
            };
            open.extend(waiting.others().filter(matters).filter(|other| seen.insert(*other)));
        }
        latest.zip(shortest).is_some_and(|(latest, shortest): (Time, _)| self.cycle.now + shortest <= latest)
    }
}

fn amount_of(claimant: &Claimant, id: ResourceId) -> f64 {
    claimant.needs.iter().find(|need| need.resource == id).map_or(0.0, |need| need.amount)
}

/// Checks neighbours of equal rank; `None` if a claimant that has begun has the rank of its neighbour: their order then depends on further
/// tasks.
fn same_rank_is_unbegun(last: &mut Option<QueueKey>, key: QueueKey) -> Option<()> {
    let before = last.replace(key);
    let tied = before.is_some_and(|before| key.rank.is_some() && before.rank == key.rank);
    let begun = key.begun || before.is_some_and(|before| before.begun);
    (!(tied && begun)).then_some(())
}

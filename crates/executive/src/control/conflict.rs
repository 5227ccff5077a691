//! Resource conflict resolution (TC)
//! What: decides which claimants get their resources, who loses them, and by which rule.
//! Runs: contend phase, over the whole batch.  Reads: ResourceTable, priorities, ranks, ancestors.  Writes: nothing.
//! Bound: O(c log c) for c claimants of the resources concerned; O(c^2) where ranks are stated, O(c^3) where they clash.
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::competition::{
    Claimant, as_claimant, claimants, first_unbeaten, has_begun, insert_in_order, order_of, rank_all, rank_order,
    rank_path, related,
};
use crate::control::priority;
use crate::cycle::Cycle;
use apex_model::agent::Agent;
use apex_model::because::{ConflictRule, Strength};
use apex_model::resource::{Need, ResourceId};
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

/// What arbitration decides.
#[derive(Default)]
pub(crate) struct Arbitration {
    /// Claimants that get all they need.
    pub(crate) granted: Vec<TaskId>,
    /// Holders that lose what they hold.
    pub(crate) displaced: Vec<Loss>,
    /// Claimants that get nothing.
    pub(crate) refused: Vec<Loss>,
    /// Claimants whose needs can never be met: resource, need, what there is.
    pub(crate) impossible: Vec<(TaskId, ResourceId, f64, f64)>,
}

/// A conflict lost.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Loss {
    /// The loser.
    pub(crate) loser: TaskId,
    /// Over what.
    pub(crate) resource: ResourceId,
    /// The winner.
    pub(crate) winner: TaskId,
    /// The rule that decided.
    pub(crate) rule: ConflictRule,
    /// The winner's priority or rank, with interrupt cost where it defends.
    pub(crate) winner_strength: Strength,
    /// The loser's.
    pub(crate) loser_strength: Strength,
    /// The winner has the resource, or gets it now; else it claims it too.
    pub(crate) winner_holds: bool,
}

/// A share of a resource that counts against later claimants.
struct Use {
    task: TaskId,
    amount: f64,
    kind: UseKind,
}

#[derive(PartialEq)]
enum UseKind {
    /// Held by an ongoing task, which can lose it.
    Held,
    /// Granted in this arbitration.
    Granted,
    /// Claimed by an earlier claimant that is itself refused, which cannot go on before this instant if it is known.
    Awaited(Option<Time>),
}

/// Arbitrates all resources in `dirty`, with everything their claimants need besides.
pub(crate) fn arbitrate(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>) -> Arbitration {
    let mut remaining = claimants(cycle, dirty);
    let ranked = remaining.len() > 1 && rank_all(cycle, &mut remaining);
    let mut field = Field { cycle, uses: BTreeMap::new(), displaced: BTreeSet::new() };
    let mut result = Arbitration::default();
    while !remaining.is_empty() {
        let index = if ranked { first_unbeaten(&remaining) } else { 0 };
        let claimant = remaining.remove(index);
        match field.place(&claimant) {
            Placement::Granted(losses) => {
                for loss in losses {
                    let mut loser = as_claimant(cycle, loss.loser);
                    if ranked {
                        loser.path = rank_path(cycle, loser.id);
                    }
                    insert_in_order(&mut remaining, loser);
                    result.displaced.push(loss);
                }
                result.granted.push(claimant.id);
            }
            Placement::Refused(loss) => result.refused.push(loss),
            Placement::Impossible(need, total) => {
                result.impossible.push((claimant.id, need.resource, need.amount, total));
            }
        }
    }
    // A holder that was displaced claims again at once; being refused then is the loss itself, not another one.
    let displaced = field.displaced;
    result.refused.retain(|loss| !displaced.contains(&loss.loser));
    result
}

/// What becomes of one claimant.
enum Placement {
    Granted(Vec<Loss>),
    Refused(Loss),
    Impossible(Need, f64),
}

/// Uses of resources while an arbitration goes on.
struct Field<'a, 'c> {
    cycle: &'a Cycle<'c>,
    uses: BTreeMap<ResourceId, Vec<Use>>,
    displaced: BTreeSet<TaskId>,
}

impl Field<'_, '_> {
    fn load(&mut self, id: ResourceId) {
        let Some(resource) = self.cycle.agent.resources.get(id) else { return };
        self.uses.entry(id).or_insert_with(|| {
            let held = |task, amount| Use { task, amount, kind: UseKind::Held };
            resource.holders.iter().map(|holding| held(holding.task, holding.amount)).collect()
        });
    }

    /// Gives the claimant all it needs, or notes what it waits for.
    fn place(&mut self, claimant: &Claimant) -> Placement {
        let mut losses: Vec<Loss> = Vec::new();
        let mut refusal = None;
        for need in &claimant.needs {
            self.load(need.resource);
            let total = self.cycle.agent.resources.get(need.resource).map_or(0.0, |resource| resource.total);
            if need.amount > total {
                return Placement::Impossible(*need, total);
            }
            match self.make_room(claimant, *need, &losses) {
                Ok(more) => losses.extend(more),
                Err(loss) => {
                    refusal = Some(loss);
                    break;
                }
            }
        }
        let kind = |refused: bool, earliest| if refused { UseKind::Awaited(earliest) } else { UseKind::Granted };
        let earliest = refusal.as_ref().and_then(|loss: &Loss| self.expected_end(loss));
        for need in &claimant.needs {
            self.load(need.resource);
            let kind = kind(refusal.is_some(), earliest);
            self.uses.entry(need.resource).or_default().push(Use { task: claimant.id, amount: need.amount, kind });
        }
        if let Some(loss) = refusal {
            return Placement::Refused(loss);
        }
        for loss in &losses {
            self.displaced.insert(loss.loser);
            for uses in self.uses.values_mut() {
                uses.retain(|each| each.task != loss.loser || each.kind != UseKind::Held);
            }
        }
        Placement::Granted(losses)
    }

    /// When the winner of a conflict is expected to be done with the resource, if somebody said.
    fn expected_end(&self, loss: &Loss) -> Option<Time> {
        let task = self.cycle.task(loss.winner).filter(|_| loss.winner_holds)?;
        let expected = task.selection.as_ref()?.expected?;
        Some(task.started_at.unwrap_or(self.cycle.now) + expected)
    }

    /// Who must lose so that the claimant's need is met.
    fn make_room(&self, claimant: &Claimant, need: Need, lost: &[Loss]) -> Result<Vec<Loss>, Loss> {
        let mut losses: Vec<Loss> = Vec::new();
        while let Some(rivals) = self.obstacles(claimant, need, lost, &losses) {
            match self.weakest(claimant, need, &rivals)? {
                Some(loss) => losses.push(loss),
                None => break,
            }
        }
        // The weakest may have lost in vain when a stronger one had to lose too.
        for index in (0..losses.len()).rev() {
            let spared = losses.remove(index);
            if self.obstacles(claimant, need, lost, &losses).is_some() {
                losses.insert(index, spared);
            }
        }
        Ok(losses)
    }

    /// The rivals of the claimant when those in `lost` and `losses` are gone; none when there is room.
    fn obstacles(&self, claimant: &Claimant, need: Need, lost: &[Loss], losses: &[Loss]) -> Option<Vec<&Use>> {
        let gone =
            |task: TaskId| self.displaced.contains(&task) || lost.iter().chain(losses).any(|loss| loss.loser == task);
        let (pool, rivals) = self.rivals(claimant, need, &gone);
        let used: f64 = rivals.iter().map(|each| each.amount).sum();
        (pool - used + 1e-9 < need.amount).then_some(rivals)
    }

    /// The pool that the claimant draws from, and the uses in it that conflict with it. Inside an ancestor's share the
    /// pool is that share; a use inside another use counts once.
    fn rivals(&self, claimant: &Claimant, need: Need, gone: &dyn Fn(TaskId) -> bool) -> (f64, Vec<&Use>) {
        let agent: &Agent = self.cycle.agent;
        let uses = self.uses.get(&need.resource).map(Vec::as_slice).unwrap_or_default();
        let present: Vec<&Use> = uses.iter().filter(|each| each.kind != UseKind::Held || !gone(each.task)).collect();
        let depth = |id: TaskId| agent.task(id).map_or(0, |task| task.depth);
        let above = present
            .iter()
            .filter(|each| !matches!(each.kind, UseKind::Awaited(_)))
            .filter(|each| depth(each.task) < depth(claimant.id) && related(agent, each.task, claimant.id))
            .max_by_key(|each| depth(each.task));
        let share = above.filter(|each| each.amount + 1e-9 >= need.amount);
        let total = agent.resources.get(need.resource).map_or(0.0, |resource| resource.total);
        let inside = |each: &Use| {
            share.is_none_or(|share| depth(each.task) > depth(share.task) && related(agent, share.task, each.task))
        };
        let strangers: Vec<&Use> = present
            .iter()
            .copied()
            .filter(|each| {
                !related(agent, each.task, claimant.id) && inside(each) && !self.leaves_a_gap(claimant, each)
            })
            .collect();
        let topmost = |each: &&Use| {
            !strangers.iter().any(|other| {
                other.task != each.task && depth(other.task) < depth(each.task) && related(agent, other.task, each.task)
            })
        };
        (share.map_or(total, |share| share.amount), strangers.iter().copied().filter(topmost).collect())
    }

    /// A refused claimant that provably cannot begin before the present one is expected to be done leaves a gap.
    fn leaves_a_gap(&self, claimant: &Claimant, other: &Use) -> bool {
        let expected = self.cycle.task(claimant.id).and_then(|task| task.selection.as_ref()?.expected);
        match (&other.kind, expected) {
            (UseKind::Awaited(Some(earliest)), Some(expected)) => self.cycle.now + expected <= *earliest,
            _ => false,
        }
    }

    /// The holder that is easiest to displace, among those that lose against the claimant.
    ///
    /// # Errors
    /// The conflict that the claimant loses instead.
    fn weakest(&self, claimant: &Claimant, need: Need, rivals: &[&Use]) -> Result<Option<Loss>, Loss> {
        let mut beaten: Option<Loss> = None;
        let mut unbeaten: Option<Loss> = None;
        for rival in rivals {
            match self.confront(claimant, need.resource, rival) {
                Ok(loss) => {
                    if beaten.as_ref().is_none_or(|before| loss.loser_strength.total() <= before.loser_strength.total())
                    {
                        beaten = Some(loss);
                    }
                }
                Err(loss) => {
                    if unbeaten
                        .as_ref()
                        .is_none_or(|before| loss.winner_strength.total() > before.winner_strength.total())
                    {
                        unbeaten = Some(loss);
                    }
                }
            }
        }
        match (beaten, unbeaten) {
            (Some(loss), _) => Ok(Some(loss)),
            (None, Some(loss)) => Err(loss),
            (None, None) => Ok(None),
        }
    }

    /// The outcome between the claimant and one use: the user's loss, or the claimant's.
    fn confront(&self, claimant: &Claimant, resource: ResourceId, rival: &Use) -> Result<Loss, Loss> {
        let (agent, now) = (&*self.cycle.agent, self.cycle.now);
        let holds = rival.kind == UseKind::Held;
        let loss = |rule, winner_strength, loser_strength| Loss {
            loser: claimant.id,
            resource,
            winner: rival.task,
            rule,
            winner_strength,
            loser_strength,
            winner_holds: !matches!(rival.kind, UseKind::Awaited(_)),
        };
        let win = |rule, winner_strength, loser_strength| Loss {
            loser: rival.task,
            resource,
            winner: claimant.id,
            rule,
            winner_strength,
            loser_strength,
            winner_holds: false,
        };
        if let Some((order, own, other)) = rank_order(agent, claimant.id, rival.task, now) {
            let (own, other) = (Strength::claiming(own), Strength::claiming(other));
            return match order {
                Ordering::Less if holds => Ok(win(ConflictRule::Rank, own, other)),
                _ => Err(loss(ConflictRule::Rank, other, own)),
            };
        }
        let own = Strength::claiming(claimant.priority);
        if holds {
            let defence = priority::defence(agent, rival.task, now);
            if own.total() > defence.total() {
                return Ok(win(ConflictRule::Priority, own, defence));
            }
            let rule = if defence.priority > own.priority { ConflictRule::Priority } else { ConflictRule::Incumbent };
            return Err(loss(rule, defence, own));
        }
        let other = Strength::claiming(priority::priority(agent, rival.task, now));
        let siblings = order_of(agent, claimant.id).0 == order_of(agent, rival.task).0;
        let rule = match other.priority.total_cmp(&own.priority) {
            Ordering::Greater => ConflictRule::Priority,
            Ordering::Equal if has_begun(agent, rival.task) && !has_begun(agent, claimant.id) => ConflictRule::Begun,
            Ordering::Equal if siblings => ConflictRule::WrittenOrder,
            Ordering::Equal => ConflictRule::CreationOrder,
            Ordering::Less => ConflictRule::Capacity,
        };
        Err(loss(rule, other, own))
    }
}

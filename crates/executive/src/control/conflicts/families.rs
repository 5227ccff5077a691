//! Ranked families (TC)
//! What: arbitrates steps of several ranked procedures that compete with one another, by inspecting only the first of them.
//! Runs: contend phase, where queues cannot decide because ranks below several tasks count.
//! Reads: ResourceTable, priorities, ranks.  Writes: nothing.
//! Bound: O((f + h) * m) for f claimants that could fit, h holders and m claimants of one family, plus O(m) for a new claim.
//! PDL: `rank`, section 9, conflict; decision 0202.  Paper: section III, detecting and resolving conflicts.
//!
//! A family is the claimants and holders with ranks below one task. In order of priority, each member takes its turn behind the members of
//! its family with lower ranks, whose priorities then count as at least its own. As all claimants need one common resource, all are refused
//! once the claims exceed this resource. Begun work precedes its equals, unless a claimant that has not begun precedes it by rank.

use crate::control::conflicts::arbitration::{Arbitration, Refusal};
use crate::control::conflicts::claim_queue::{fixed_ranks, worth_of};
use crate::control::conflicts::competition::is_eligible;
use crate::control::conflicts::conflict::{Field, Placement, left_behind};
use crate::control::conflicts::family_turns::{OwnTurns, is_greater, is_held_back, is_lower, places};
use crate::control::conflicts::family_watch::{self, Reached};
use crate::control::conflicts::precedence::OrderKey;
use crate::control::conflicts::queues::{is_alone, risen_to};
use crate::control::conflicts::resources::needs_in;
use crate::control::conflicts::sharing::TOLERANCE;
use crate::control::cycle::Cycle;
use crate::state::queue_place::{QueueKey, RankAmong};
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use crate::state::waiting::Waiting;
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Arbitrates the resources in `dirty` and all that are needed with them; `fresh` are the claims of this round. `None` if the claimants
/// must be compared with one another.
pub(crate) fn decide(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, fresh: &BTreeSet<TaskId>) -> Option<Arbitration> {
    let concerned = Concerned::of(cycle, dirty)?;
    let mut pass = FamilyPass::new(cycle, &concerned)?;
    let mut turns = OwnTurns::of(cycle, pass.waiting);
    let mut result = pass.place_all(fresh, &mut turns)?;
    let stays = left_behind(cycle, &result).all(|id| concerned.resources.contains_key(&id));
    if !stays || pass.may_leave_a_gap(&result) {
        return None;
    }
    let holders = pass.holders.iter().map(|holder| holder.worth.task()).collect();
    let reached = Reached { cycle, waiting: pass.waiting, holders, roots: pass.roots };
    result.watched = family_watch::watched(&reached, &mut turns, &result);
    Some(result)
}

/// All resources that claimants and holders need together.
struct Concerned<'a> {
    resources: BTreeMap<ResourceId, &'a Resource>,
    /// The resource that all claimants and holders need.
    common: (ResourceId, &'a Resource),
}

impl<'a> Concerned<'a> {
    /// Returns `None` unless all claimants are of ranked families and need one common resource.
    fn of(cycle: &'a Cycle<'_>, dirty: &BTreeSet<ResourceId>) -> Option<Concerned<'a>> {
        let agent = &*cycle.agent;
        let mut open: Vec<ResourceId> = dirty.iter().copied().collect();
        let mut resources: BTreeMap<ResourceId, &'a Resource> = BTreeMap::new();
        while let Some(id) = open.pop() {
            if resources.contains_key(&id) {
                continue;
            }
            let resource = agent.resources.get(id)?;
            let waiting = &resource.waiting;
            if resource.depletable || !(waiting.is_empty() || waiting.are_families()) || waiting.has_many_groups() {
                return None;
            }
            resources.insert(id, resource);
            open.extend(waiting.others());
            for holding in &resource.holders {
                open.extend(needs_in(agent, holding.task).into_iter().map(|need| need.resource));
            }
        }
        let (id, common) = resources.iter().max_by_key(|(_, each)| each.waiting.len())?;
        let needs_common = |other: &ResourceId, resource: &Resource| {
            let mut together = resource.waiting.together();
            let mut holders = resource.holders.iter();
            other == id
                || together.all(|others| others.iter().any(|(other, _)| other == id))
                    && holders.all(|holding| common.holders.iter().any(|each| each.task == holding.task))
        };
        let all = resources.iter().all(|(other, resource)| needs_common(other, resource));
        let common = (*id, *common);
        all.then_some(Concerned { resources, common })
    }
}

/// A place in the order of turns: that of the member of the family for which it takes its turn, and its place in the family.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct FamilyTurn {
    lead: QueueKey,
    own: QueueKey,
}

/// A task that holds the common resource.
struct Holder {
    /// Its place by its own priority.
    worth: QueueKey,
    /// Its place in its family, if it has one.
    rank: Option<QueueKey>,
}

/// Claimants while they take their turns.
struct FamilyPass<'a, 'c> {
    cycle: &'a Cycle<'c>,
    field: Field<'a, 'c>,
    concerned: &'a Concerned<'a>,
    waiting: &'a Waiting,
    holders: Vec<Holder>,
    /// Claimants for whose priority others took their turns, and claimants that had been reached before.
    roots: Vec<TaskId>,
    /// Claimants that had their turn, or have it next.
    reached: BTreeSet<TaskId>,
    next: VecDeque<FamilyTurn>,
    turns: usize,
}

impl<'a, 'c> FamilyPass<'a, 'c> {
    fn new(cycle: &'a Cycle<'c>, concerned: &'a Concerned<'a>) -> Option<FamilyPass<'a, 'c>> {
        let waiting = &concerned.common.1.waiting;
        let (field, reached, next) = (Field::ranked(cycle), BTreeSet::new(), VecDeque::new());
        let mut pass = FamilyPass {
            cycle,
            field,
            concerned,
            waiting,
            holders: Vec::new(),
            roots: Vec::new(),
            reached,
            next,
            turns: 0,
        };
        for (id, resource) in &concerned.resources {
            if !resource.holders.iter().all(|holding| is_alone(cycle.agent, resource, holding.task)) {
                return None;
            }
            if *id == concerned.common.0 {
                for holding in &resource.holders {
                    let holder = pass.holder(holding.task)?;
                    pass.holders.push(holder);
                }
            }
        }
        pass.holders.sort_by_key(|holder| holder.worth);
        for index in 0..pass.holders.len() {
            let Some(holder) = pass.holders.get(index) else { continue };
            let (worth, rank) = (holder.worth, holder.rank);
            let lead = rank.and_then(|rank| pass.lead(worth, rank)).unwrap_or(worth);
            pass.rank(lead, worth);
        }
        Some(pass)
    }

    /// Returns a holder; `None` if its priority or rank may change otherwise than by urgency.
    fn holder(&self, task: TaskId) -> Option<Holder> {
        let place = worth_of(self.cycle, task)?;
        let worth = place.now(risen_to(self.cycle))?;
        let mut ranks = fixed_ranks(self.cycle.agent, task);
        let rank = ranks.next();
        if ranks.next().is_some() {
            return None;
        }
        let changes = |rank: &RankAmong| !place.rising.is_empty() || self.waiting.changes_below(rank.parent);
        if rank.is_some_and(|rank| self.waiting.has_rank(rank) && changes(&rank)) {
            return None;
        }
        let behind = rank.is_some_and(|rank| is_held_back(self.cycle, self.waiting, rank));
        let worth = QueueKey { begun: !behind, ..worth };
        let rank = rank.map(|rank| QueueKey { priority: 0.0, rank: Some(rank), within: worth.priority, ..worth });
        Some(Holder { worth, rank })
    }

    /// Returns the best place by own priority among the task and those of its family with greater ranks.
    fn lead(&self, worth: QueueKey, rank: QueueKey) -> Option<QueueKey> {
        let among = rank.rank?;
        let waiting = self.waiting.below(among.parent).filter(|key| is_greater(key, among.rank));
        let waiting = waiting.filter(|key| is_eligible(self.cycle.agent, key.task()));
        let waiting = waiting.filter_map(|key| Some(places(self.cycle, self.waiting, key.task())?.0));
        let same = |key: &QueueKey| key.rank.is_some_and(|rank| rank.parent == among.parent);
        let holders = self
            .holders
            .iter()
            .filter(|each| each.rank.as_ref().is_some_and(|key| same(key) && is_greater(key, among.rank)));
        waiting.chain(holders.map(|each| each.worth)).chain([worth]).min()
    }

    /// Sets the turn of a task and the priority that counts for it.
    fn rank(&mut self, lead: QueueKey, worth: QueueKey) {
        self.turns += 1;
        let place = OrderKey { turn: self.turns, whom: lead.task(), priority: lead.priority, own: worth.priority };
        self.field.rank(worth.task(), place);
    }

    /// Gives turns until no further claimant can get anything, then to the other claims of this round, which are refused.
    fn place_all(&mut self, fresh: &BTreeSet<TaskId>, claimants: &mut OwnTurns<'_, '_>) -> Option<Arbitration> {
        let (waiting, total) = (self.waiting, self.field.total(self.concerned.common.0));
        let mut roots: Vec<QueueKey> = self.holders.iter().map(|holder| holder.worth).rev().collect();
        let mut losers: BTreeSet<FamilyTurn> = BTreeSet::new();
        let (mut result, mut claimed) = (Arbitration::default(), 0.0);
        loop {
            while self.next.is_empty() && claimed <= total + TOLERANCE {
                let holder = roots.last().copied();
                let root = match (holder, claimants.head()) {
                    (Some(holder), other) if other.is_none_or(|other| holder < other) => roots.pop(),
                    _ => claimants.take(),
                };
                let Some(root) = root else { break };
                self.reach(root)?;
            }
            let open = claimed <= total + TOLERANCE;
            let head = self.next.front().copied().filter(|_| open);
            let turn = match (head, losers.first().copied()) {
                (Some(head), loser) if loser.is_none_or(|loser| head < loser) => {
                    self.next.pop_front();
                    claimed += waiting.amount_of(head.own.task());
                    let worth = places(self.cycle, waiting, head.own.task())?.0;
                    self.rank(head.lead, worth);
                    head
                }
                (_, Some(loser)) => {
                    losers.remove(&loser);
                    loser
                }
                _ => break,
            };
            self.place(turn.own.task(), &mut losers, &mut result)?;
        }
        self.refuse_others(fresh, &mut result)?;
        Some(result)
    }

    /// Adds the claimants that take their turns for `root`: those of its family with lower ranks, and itself if it claims. `None` if the
    /// order of equal ranks is not known.
    fn reach(&mut self, root: QueueKey) -> Option<()> {
        let (agent, waiting) = (&*self.cycle.agent, self.waiting);
        let holds = self.holders.iter().find(|holder| holder.worth.task() == root.task());
        let own = match holds {
            Some(holder) => holder.rank,
            None => places(self.cycle, waiting, root.task()).map(|places| places.1),
        };
        if holds.is_none() && !is_eligible(agent, root.task()) {
            return Some(());
        }
        if holds.is_none() {
            self.roots.push(root.task());
        }
        if holds.is_none() && self.reached.contains(&root.task()) {
            return Some(());
        }
        let Some((own, rank)) = own.and_then(|own| Some((own, own.rank?))) else { return Some(()) };
        if waiting.has_open_ties(rank.parent) {
            return None;
        }
        for key in waiting.below(rank.parent).take_while(|key| is_lower(key, rank.rank)) {
            if is_eligible(agent, key.task()) && self.reached.insert(key.task()) {
                self.next.push_back(FamilyTurn { lead: root, own: key });
            }
        }
        if holds.is_none() && self.reached.insert(root.task()) {
            self.next.push_back(FamilyTurn { lead: root, own });
        }
        Some(())
    }

    fn place(&mut self, task: TaskId, losers: &mut BTreeSet<FamilyTurn>, result: &mut Arbitration) -> Option<()> {
        let claimant = self.field.as_claimant(task);
        match self.field.place(&claimant) {
            Placement::Granted(losses) => {
                for loss in losses {
                    losers.insert(self.turn_of_holder(loss.loser)?);
                    result.displaced.push(loss);
                }
                result.granted.push(task);
            }
            Placement::Refused(refusal) => result.refused.push(Refusal { rivals: Vec::new(), ..refusal }),
            Placement::Impossible(need, total) => result.impossible.push((task, need.resource, need.amount, total)),
        }
        Some(())
    }

    fn turn_of_holder(&self, task: TaskId) -> Option<FamilyTurn> {
        let holder = self.holders.iter().find(|holder| holder.worth.task() == task)?;
        let lead = holder.rank.and_then(|rank| self.lead(holder.worth, rank)).unwrap_or(holder.worth);
        Some(FamilyTurn { lead, own: holder.rank.unwrap_or(holder.worth) })
    }

    /// Reports the claims of this round that had no turn; `None` if one of them would be granted.
    fn refuse_others(&mut self, fresh: &BTreeSet<TaskId>, result: &mut Arbitration) -> Option<()> {
        let placed: BTreeSet<TaskId> =
            self.reached.iter().copied().filter(|task| self.next.iter().all(|turn| turn.own.task() != *task)).collect();
        let mut turns = BTreeMap::new();
        let behind: BTreeSet<TaskId> = result.granted.iter().flat_map(|task| self.begun_behind(*task)).collect();
        for task in fresh.union(&behind).filter(|task| !placed.contains(task) && is_eligible(self.cycle.agent, **task))
        {
            let Some((worth, own)) = places(self.cycle, self.waiting, *task) else { continue };
            turns.insert(FamilyTurn { lead: self.lead(worth, own)?, own }, worth);
        }
        for (turn, worth) in turns {
            self.rank(turn.lead, worth);
            let claimant = self.field.as_claimant(worth.task());
            match self.field.place(&claimant) {
                Placement::Refused(refusal) => result.refused.push(Refusal { rivals: Vec::new(), ..refusal }),
                Placement::Impossible(need, total) => {
                    result.impossible.push((claimant.id, need.resource, need.amount, total));
                }
                Placement::Granted(_) => return None,
            }
        }
        Some(())
    }

    /// Returns the claimants that have begun and that a granted task precedes by rank: they may precede their equals once it has begun.
    fn begun_behind(&self, granted: TaskId) -> impl Iterator<Item = TaskId> + '_ {
        let rank = places(self.cycle, self.waiting, granted).and_then(|places| places.1.rank);
        let family = rank.into_iter().flat_map(|rank| {
            self.waiting.below(rank.parent).filter(move |key| key.begun && is_greater(key, rank.rank))
        });
        family.map(|key| key.task())
    }

    /// Returns true if a task with a stated duration might fit into free capacity that others await.
    fn may_leave_a_gap(&self, result: &Arbitration) -> bool {
        self.concerned.resources.iter().any(|(id, resource)| {
            let used: f64 = self.field.users(*id, resource).iter().map(|each| each.amount).sum();
            let room = resource.total - used;
            let served = result.granted.iter().filter(|task| resource.waiting.contains(**task)).count();
            // A gap needs one task that leaves it and one that fills it.
            let waits = resource.waiting.len() > served + 1;
            let fits = || resource.waiting.shortest(room + TOLERANCE).is_some();
            room > TOLERANCE && (!result.displaced.is_empty() || waits && fits())
        })
    }
}

//! Resource conflict resolution (TC)
//! What: decides which claimants get their resources, which holders lose them, and by which rule.
//! Runs: contend phase, over the whole batch.  Reads: ResourceTable, priorities, ranks, ancestors.  Writes: nothing.
//! Bound: O(c log c) for c claimants of the resources concerned, O(c^2) where ranks are stated; plus O(h^2) for a
//! claimant that has to displace some of h holders.
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::{Arbitration, Defeat, Refusal, Rival};
use crate::control::conflicts::competition::{
    Claimant, as_claimant, at_work_since, has_begun, in_order, insert_in_order, order_of, rank_order, related,
};
use crate::control::conflicts::precedence::{OrderKey, Precedence};
use crate::control::conflicts::priority;
use crate::control::conflicts::resources::needs_of;
use crate::control::conflicts::sharing::{Notes, TOLERANCE, Use, UseKind, any_related, has_room, matters};
use crate::control::cycle::Cycle;
use crate::expression::EvalContext;
use crate::planted::{self, Bug};
use crate::state::clause::Level;
use crate::state::resource::{Need, Resource};
use crate::state::resource_id::ResourceId;
use apex_model::because::{ConflictRule, Strength};
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Returns the tasks that would begin although their parents stop, in the order of arbitration.
pub(crate) fn orphans<'a>(cycle: &'a Cycle<'_>, result: &'a Arbitration) -> impl Iterator<Item = TaskId> + 'a {
    let granted = result.granted.iter().copied().filter(|_| !result.displaced.is_empty());
    granted.filter(move |id| !has_begun(cycle.agent, *id) && parent_stops(cycle, result, *id))
}

/// Returns true if the parent of the task stops working.
fn parent_stops(cycle: &Cycle<'_>, result: &Arbitration, id: TaskId) -> bool {
    let stops =
        |task: TaskId| result.displaced.iter().any(|loss| loss.loser == task) && !result.granted.contains(&task);
    cycle.task(id).and_then(|task| task.parent).is_some_and(stops)
}

/// Arbitrates all resources in `dirty`, the other resources that their claimants need, and those that displaced tasks leave. A step whose
/// parent stops does not compete.
pub(crate) fn arbitrate_all(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>) -> Arbitration {
    let mut orphaned = BTreeSet::new();
    let mut dirty = dirty.clone();
    loop {
        let mut result = arbitrate_without(cycle, &dirty, &orphaned);
        let known = dirty.len();
        dirty.extend(left_behind(cycle, &result));
        if dirty.len() > known {
            continue;
        }
        let found: Vec<TaskId> = orphans(cycle, &result).filter(|id| !orphaned.contains(id)).collect();
        let Some(last) = found.last().copied() else {
            result.barred = orphaned.into_iter().filter(|id| !parent_stops(cycle, &result, *id)).collect();
            return result;
        };
        // If the parent stops only because of another orphan, the next pass decides whether it still stops without that orphan.
        let only_for_orphan = |id: &TaskId| {
            let parent = cycle.task(*id).and_then(|task| task.parent);
            let loss = result.displaced.iter().find(|loss| Some(loss.loser) == parent);
            loss.is_some_and(|loss| found.contains(&loss.winner))
        };
        let certain: Vec<TaskId> = found.iter().filter(|id| !only_for_orphan(id)).copied().collect();
        // If each parent stops only because of another orphan, only the weakest is excluded: excluding all would let all wait forever.
        orphaned.extend(if certain.is_empty() { vec![last] } else { certain });
    }
}

/// Returns contested resources to arbitrate in addition: all that displaced tasks hold, and all that ancestors of winners that have not
/// begun hold. A task that waits for one of these may stop the winner in turn.
pub(crate) fn left_behind<'a>(cycle: &'a Cycle<'_>, result: &'a Arbitration) -> impl Iterator<Item = ResourceId> + 'a {
    let awaited = |id: &ResourceId| cycle.agent.resources.get(*id).is_some_and(|each| !each.waiting.is_empty());
    let needs = |id: TaskId| needs_of(cycle, id).into_iter().map(|need| need.resource);
    let winners = result.displaced.iter().map(|loss| loss.winner).filter(|id| !has_begun(cycle.agent, *id));
    let parent = |id: TaskId| cycle.task(id).and_then(|task| task.parent);
    let above = winners.flat_map(move |id| std::iter::successors(parent(id), move |id| parent(*id)));
    result.displaced.iter().map(|loss| loss.loser).chain(above).flat_map(needs).filter(awaited)
}

fn arbitrate_without(cycle: &Cycle<'_>, dirty: &BTreeSet<ResourceId>, orphans: &BTreeSet<TaskId>) -> Arbitration {
    let (mut remaining, precedence) = in_order(cycle.agent, cycle.now, dirty, orphans);
    let mut field = Field { precedence, ..Field::empty(cycle) };
    let mut result = Arbitration::default();
    while let Some(claimant) = remaining.pop_front() {
        match field.place(&claimant) {
            Placement::Granted(losses) => {
                for loss in losses {
                    let loser = field.as_claimant(loss.loser);
                    insert_in_order(&mut remaining, loser);
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
    result
}

/// Result of placing one claimant.
pub(crate) enum Placement {
    Granted(Vec<Defeat>),
    Refused(Refusal),
    Impossible(Need, f64),
}

/// Uses of resources while an arbitration is computed.
pub(crate) struct Field<'a, 'c> {
    cycle: &'a Cycle<'c>,
    uses: BTreeMap<ResourceId, Vec<Use>>,
    /// Tasks that have lost all their resources, including resources that are not arbitrated yet.
    displaced: BTreeSet<TaskId>,
    /// Order by rank; `None` if no task has a rank.
    precedence: Option<Precedence>,
    notes: Notes,
}

impl<'a, 'c> Field<'a, 'c> {
    /// Returns a field on which nothing has been arbitrated.
    pub(crate) fn empty(cycle: &'a Cycle<'c>) -> Field<'a, 'c> {
        let (uses, displaced) = (BTreeMap::new(), BTreeSet::new());
        Field { cycle, uses, displaced, precedence: None, notes: Notes::Each }
    }

    /// Returns an empty field that notes only enough claims to refuse all others ([`Notes::Enough`]).
    pub(crate) fn brief(cycle: &'a Cycle<'c>) -> Field<'a, 'c> {
        Field { notes: Notes::Enough, ..Field::empty(cycle) }
    }

    /// Returns a brief field in which tasks have the places that are added by [`Field::rank`].
    pub(crate) fn ranked(cycle: &'a Cycle<'c>) -> Field<'a, 'c> {
        Field { precedence: Some(Precedence::empty()), ..Field::brief(cycle) }
    }

    /// Sets the place of a task in the order of ranks and priorities.
    pub(crate) fn rank(&mut self, id: TaskId, place: OrderKey) {
        if let Some(precedence) = &mut self.precedence {
            precedence.insert(id, place);
        }
    }

    /// Returns an empty field that notes claims by instant ([`Notes::ByInstant`]), for claimants in queues, which are not related to each
    /// other.
    pub(crate) fn grouped(cycle: &'a Cycle<'c>) -> Field<'a, 'c> {
        Field { notes: Notes::ByInstant, ..Field::empty(cycle) }
    }

    /// Returns the claim of the task with its turn and the priority that counts for it.
    pub(crate) fn as_claimant(&self, id: TaskId) -> Claimant {
        let mut claimant = as_claimant(self.cycle, id);
        if let Some(precedence) = &self.precedence {
            precedence.apply(&mut claimant);
        }
        claimant
    }

    fn lifted(&self, id: TaskId, own: Strength) -> Strength {
        let lifted = |precedence: &Precedence| precedence.lifted(id, own.priority);
        Strength { priority: self.precedence.as_ref().map_or(own.priority, lifted), ..own }
    }

    /// Returns the strength with which a holder defends its resources.
    pub(crate) fn defence(&self, id: TaskId) -> Strength {
        self.lifted(id, priority::defence(self.cycle.agent, id, self.cycle.now))
    }

    fn stands_for(&self, id: TaskId) -> Rc<[TaskId]> {
        self.precedence.as_ref().map_or_else(|| Rc::from([id]), |precedence| precedence.stands_for(id))
    }

    /// Returns the rule by which the greater priority of `winner` decides.
    fn by_priority(&self, winner: TaskId) -> ConflictRule {
        let whom = self.precedence.as_ref().and_then(|precedence| precedence.instead_of_own(winner));
        whom.map_or(ConflictRule::Priority, |whom| ConflictRule::GoesBefore { whom })
    }

    /// Notes the holders of the resource, unless they are noted already.
    pub(crate) fn load(&mut self, id: ResourceId) {
        let Some(resource) = self.cycle.agent.resources.get(id) else { return };
        let displaced = &self.displaced;
        self.uses.entry(id).or_insert_with(|| {
            let holders = resource.holders.iter().filter(|holding| !displaced.contains(&holding.task));
            let held = |task, amount| Use { task, amount, kind: UseKind::Held };
            holders.map(|holding| held(holding.task, holding.amount)).collect()
        });
    }

    /// Grants the claimant all its needs, or notes what it waits for. Displaces as few tasks as possible: no task that beats the
    /// claimant, and no task if displacing weaker ones suffices.
    pub(crate) fn place(&mut self, claimant: &Claimant) -> Placement {
        for need in &claimant.needs {
            self.load(need.resource);
            let total = self.total(need.resource);
            if need.amount > total {
                return Placement::Impossible(*need, total);
            }
        }
        let mut losses: Vec<Defeat> = Vec::new();
        let mut weakest_first = None;
        while let Some(need) = self.lacking(claimant, &losses) {
            let beaten = weakest_first.get_or_insert_with(|| self.beaten(claimant).into_iter());
            match beaten.next() {
                Some(loss) => losses.push(loss),
                None => return Placement::Refused(self.refuse(claimant, need, &losses)),
            }
        }
        for index in (0..losses.len()).rev() {
            let spared = losses.remove(index);
            if let Some(need) = self.lacking(claimant, &losses) {
                // The reported resource is the one that would be missing without this loss.
                losses.insert(index, Defeat { resource: need.resource, ..spared });
            }
        }
        self.displaced.extend(losses.iter().map(|loss| loss.loser));
        for uses in self.uses.values_mut() {
            uses.retain(|each| each.kind != UseKind::Held || losses.iter().all(|loss| loss.loser != each.task));
        }
        self.note(claimant, UseKind::Granted);
        Placement::Granted(losses)
    }

    fn note(&mut self, claimant: &Claimant, kind: UseKind) {
        for need in &claimant.needs {
            self.add(need.resource, Use { task: claimant.id, amount: need.amount, kind });
        }
    }

    /// Notes the use of a resource.
    pub(crate) fn add(&mut self, id: ResourceId, used: Use) {
        self.load(id);
        let total = self.total(id);
        let uses = self.uses.entry(id).or_default();
        let awaits = |each: &Use| matches!(each.kind, UseKind::Awaited(_));
        let claimed = || uses.iter().filter(|each| awaits(each)).map(|each| each.amount).sum::<f64>();
        if !awaits(&used) || self.notes == Notes::Each {
            return uses.push(used);
        }
        if self.notes == Notes::Enough {
            if claimed() <= total + TOLERANCE {
                uses.push(used);
            }
            return;
        }
        match uses.iter_mut().find(|each| each.kind == used.kind) {
            Some(claims) => claims.amount += used.amount,
            None => uses.push(used),
        }
    }

    /// Returns all uses of a resource that was inspected.
    pub(crate) fn uses_of(&self, id: ResourceId) -> &[Use] {
        self.uses.get(&id).map(Vec::as_slice).unwrap_or_default()
    }

    /// Returns all uses of the resource by tasks that hold it or get it in this arbitration.
    pub(crate) fn users(&self, id: ResourceId, resource: &Resource) -> Vec<Use> {
        match self.uses.get(&id) {
            Some(uses) => uses.iter().filter(|each| !matches!(each.kind, UseKind::Awaited(_))).cloned().collect(),
            None => {
                let holders = resource.holders.iter().filter(|holding| !self.displaced.contains(&holding.task));
                let held = |task, amount| Use { task, amount, kind: UseKind::Held };
                holders.map(|holding| held(holding.task, holding.amount)).collect()
            }
        }
    }

    /// Returns the capacity of a resource.
    pub(crate) fn total(&self, id: ResourceId) -> f64 {
        self.cycle.agent.resources.get(id).map_or(0.0, |resource| resource.total)
    }

    /// Returns the uses that count against the claimant after the losses in `losses`.
    fn present(&self, claimant: &Claimant, id: ResourceId, losses: &[Defeat]) -> Vec<&Use> {
        let agent = &*self.cycle.agent;
        let uses = self.uses.get(&id).map(Vec::as_slice).unwrap_or_default();
        let counts = |each: &&Use| match each.kind {
            UseKind::Held => losses.iter().all(|loss| loss.loser != each.task),
            UseKind::Granted => true,
            // A gap is only filled with free capacity: no task is displaced for it.
            UseKind::Awaited(_) => {
                !(related(agent, each.task, claimant.id) || losses.is_empty() && self.leaves_a_gap(claimant, each))
            }
        };
        uses.iter().filter(counts).collect()
    }

    /// Returns the first need of the claimant for which the capacity does not suffice.
    fn lacking(&self, claimant: &Claimant, losses: &[Defeat]) -> Option<Need> {
        let room = |need: &Need| {
            let present = self.present(claimant, need.resource, losses);
            has_room(self.cycle.agent, self.total(need.resource), &present, claimant.id, need.amount)
        };
        claimant.needs.iter().find(|need| !room(need)).copied()
    }

    /// Returns all holders that the claimant beats, the weakest first: ordered by rank, then by the strength of their defence, then by
    /// the time for which they have been ongoing, the shortest first.
    fn beaten(&self, claimant: &Claimant) -> Vec<Defeat> {
        let agent = &*self.cycle.agent;
        let mut found: Vec<Defeat> = Vec::new();
        for need in &claimant.needs {
            for rival in self.uses.get(&need.resource).map(Vec::as_slice).unwrap_or_default().iter().rev() {
                let known = found.iter().any(|loss| loss.loser == rival.task);
                if rival.kind == UseKind::Held && !known && !related(agent, rival.task, claimant.id) {
                    found.extend(self.confront(claimant, need.resource, rival).ok());
                }
            }
        }
        if found.len() < 2 {
            return found;
        }
        let now = self.cycle.now;
        let mut keyed: Vec<(f64, Defeat)> =
            found.into_iter().map(|loss| (self.defence(loss.loser).total(), loss)).collect();
        keyed.sort_by(|a, b| {
            a.0.total_cmp(&b.0).then(at_work_since(agent, b.1.loser).cmp(&at_work_since(agent, a.1.loser)))
        });
        let mut ordered = Vec::with_capacity(keyed.len());
        while !keyed.is_empty() {
            let beats_none = |loss: &Defeat| {
                let mut others = keyed.iter().filter(|(_, other)| other.loser != loss.loser);
                !others.any(|(_, other)| {
                    matches!(rank_order(agent, loss.loser, other.loser, now), Some((Ordering::Less, ..)))
                })
            };
            let index = keyed.iter().position(|(_, loss)| beats_none(loss)).unwrap_or(0);
            ordered.push(keyed.remove(index).1);
        }
        ordered
    }

    /// Returns the conflict that the claimant loses over `need`, and all tasks that block it. The claim continues.
    fn refuse(&mut self, claimant: &Claimant, need: Need, losses: &[Defeat]) -> Refusal {
        let agent = &*self.cycle.agent;
        let present = self.present(claimant, need.resource, losses);
        let strangers = || present.iter().filter(|each| !related(agent, each.task, claimant.id));
        let families = any_related(agent, &present);
        let mut rivals: Vec<&&Use> = strangers().filter(|each| !families || matters(agent, &present, each)).collect();
        if rivals.is_empty() {
            rivals = strangers().collect();
        }
        let rival = |each: &&&Use| {
            let holds = !matches!(each.kind, UseKind::Awaited(_));
            Rival { task: each.task, holds, stands_for: self.stands_for(each.task) }
        };
        let all = rivals.iter().map(rival).collect();
        let conflicts = rivals.iter().filter_map(|each| self.confront(claimant, need.resource, each).err());
        // The cause names the task that would have to yield first: the weakest holder, or the best claimant if no holder blocks.
        let told = conflicts.reduce(|a, b| match (a.winner_holds, b.winner_holds) {
            (true, true) if b.winner_strength.total() < a.winner_strength.total() => b,
            (false, true) => b,
            _ => a,
        });
        let nobody = || Defeat {
            loser: claimant.id,
            resource: need.resource,
            winner: claimant.id,
            rule: ConflictRule::Capacity,
            winner_strength: Strength::claiming(claimant.priority),
            loser_strength: Strength::claiming(claimant.priority),
            winner_holds: false,
        };
        // The claimant begins when one of its rivals ends, if the ends of all of them are known.
        let ends: Option<Vec<Time>> = rivals.iter().map(|each| self.expected_end(each)).collect();
        let earliest = ends.and_then(|ends| ends.into_iter().min());
        let claim = UseKind::Awaited(earliest.filter(|_| self.notes != Notes::Enough));
        self.note(claimant, claim);
        Refusal { loss: told.unwrap_or_else(nobody), claim, stands_for: self.stands_for(claimant.id), rivals: all }
    }

    /// Returns the expected end of a rival's use of the resource, if stated. `None` for a rival that only claims it: it cannot end before
    /// it begins.
    pub(crate) fn expected_end(&self, rival: &Use) -> Option<Time> {
        if let UseKind::Awaited(earliest) = rival.kind {
            return earliest;
        }
        let task = self.cycle.task(rival.task)?;
        let expected = task.selection.as_ref()?.expected?;
        // The time worked counts, not the time since the beginning: the rival may have been interrupted.
        let view = self.cycle.view(rival.task, Level::Step);
        let worked = view.task_time_ongoing(rival.task).unwrap_or_default();
        Some(self.cycle.now + (expected - worked))
    }

    /// Returns true if a refused claimant leaves a gap: it provably cannot begin before the expected end of the present one.
    fn leaves_a_gap(&self, claimant: &Claimant, other: &Use) -> bool {
        let expected = self.cycle.task(claimant.id).and_then(|task| task.selection.as_ref()?.expected);
        match (&other.kind, expected) {
            (UseKind::Awaited(Some(earliest)), Some(expected)) => self.cycle.now + expected <= *earliest,
            _ => false,
        }
    }

    /// Returns the outcome between the claimant and one use: the loss of the user, or that of the claimant.
    pub(crate) fn confront(&self, claimant: &Claimant, resource: ResourceId, rival: &Use) -> Result<Defeat, Defeat> {
        let (agent, now) = (&*self.cycle.agent, self.cycle.now);
        let holds = rival.kind == UseKind::Held;
        let loss = |rule, winner_strength, loser_strength| Defeat {
            loser: claimant.id,
            resource,
            winner: rival.task,
            rule,
            winner_strength,
            loser_strength,
            winner_holds: !matches!(rival.kind, UseKind::Awaited(_)),
        };
        let win = |rule, winner_strength, loser_strength| Defeat {
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
            let defence = self.defence(rival.task);
            let equal = planted::is(Bug::EqualNewcomerWins) && own.total() >= defence.priority;
            if own.total() > defence.total() || equal {
                return Ok(win(self.by_priority(claimant.id), own, defence));
            }
            let outranks = defence.priority > own.priority;
            let rule = if outranks { self.by_priority(rival.task) } else { ConflictRule::Incumbent };
            return Err(loss(rule, defence, own));
        }
        let other = self.lifted(rival.task, Strength::claiming(priority::priority(agent, rival.task, now)));
        let siblings = order_of(agent, claimant.id).0 == order_of(agent, rival.task).0;
        let rule = match other.priority.total_cmp(&own.priority) {
            Ordering::Greater => self.by_priority(rival.task),
            Ordering::Equal if has_begun(agent, rival.task) && !has_begun(agent, claimant.id) => ConflictRule::Begun,
            Ordering::Equal if siblings => ConflictRule::WrittenOrder,
            Ordering::Equal => ConflictRule::CreationOrder,
            Ordering::Less => ConflictRule::Capacity,
        };
        Err(loss(rule, other, own))
    }
}

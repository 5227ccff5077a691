//! GapLines of claimants before gaps (TC)
//! What: gives turns to claimants group by group, and leaves out those of a group whose claims no longer change anything.
//! Runs: contend phase, for `gaps`.  Reads: ResourceTable, priorities.  Writes: nothing.
//! Bound: O(g) for a turn, for g groups; O(u) for the u uses of a resource.
//! PDL: `expected-duration`, section 9, conflict.  Paper: section III, detecting and resolving conflicts.
//!
//! A task behind a refused one of the same group is refused, too: it needs the same, takes as long or longer, and does not beat more. Its
//! claims count against those behind it, until such claims alone exceed the whole of each resource.

use crate::control::conflicts::arbitration::{Arbitration, PriorityWatch, Rival};
use crate::control::conflicts::claim_queue;
use crate::control::conflicts::competition::is_eligible;
use crate::control::conflicts::conflict::Field;
use crate::control::conflicts::priority;
use crate::control::conflicts::queues::{group_in_turn, rank_below};
use crate::control::conflicts::sharing::{TOLERANCE, UseKind};
use crate::control::cycle::Cycle;
use crate::state::orders::Group;
use crate::state::queue_place::{QueueKey, QueuePlace, TurnOrder};
use crate::state::resource::Resource;
use crate::state::resource_id::ResourceId;
use crate::state::turns::TurnSource;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// One group of claimants, as far as it was gone through.
struct Line<'a> {
    needs: Vec<(ResourceId, f64)>,
    /// The shortest time that one of them says that it takes.
    shortest: Option<Duration>,
    turns: Box<dyn TurnSource + 'a>,
    head: Option<QueueKey>,
    /// Those that were refused.
    refused: Vec<TaskId>,
    /// Since when claims of those that take no less time than this change nothing.
    quiet: Option<(UseCounts, Option<Duration>)>,
}

/// State of the resources of a line: the number of uses of each, and of tasks that were displaced.
#[derive(PartialEq)]
struct UseCounts(Vec<usize>, usize);

/// All groups of claimants.
pub(super) struct GapLines<'a, 'c> {
    cycle: &'a Cycle<'c>,
    /// Grants and refusals.
    pub(super) field: Field<'a, 'c>,
    /// All claimants take a turn.
    pub(super) visits_all: bool,
    lines: Vec<Line<'a>>,
    resources: BTreeMap<ResourceId, &'a Resource>,
    order: TurnOrder,
    /// Those that lost what they had, and claim it again.
    losers: BTreeSet<QueueKey>,
    losses: usize,
    /// The last one that had its turn.
    position: Option<QueueKey>,
}

impl<'a, 'c> GapLines<'a, 'c> {
    pub(super) fn of(
        cycle: &'a Cycle<'c>,
        resources: &BTreeMap<ResourceId, &'a Resource>,
        order: TurnOrder,
    ) -> GapLines<'a, 'c> {
        let mut lines = Vec::new();
        for (id, resource) in resources {
            // A group that needs several resources is in the queue of each: the first one counts.
            let first = |others: &[(ResourceId, u64)]| others.iter().all(|(other, _)| id < other);
            for (others, amount, group) in resource.waiting.groups().filter(|each| first(each.0)) {
                let others = others.iter().map(|(other, amount)| (*other, f64::from_bits(*amount)));
                let needs = std::iter::once((*id, amount)).chain(others).collect();
                lines.push(Line::of(cycle, needs, group, order));
            }
        }
        let mut field = Field::grouped(cycle);
        resources.keys().for_each(|id| field.load(*id));
        let (losers, resources) = (BTreeSet::new(), resources.clone());
        GapLines { cycle, field, visits_all: false, lines, resources, order, losers, losses: 0, position: None }
    }

    /// Adds one that lost what it had.
    pub(super) fn add_loser(&mut self, key: QueueKey) {
        self.losers.insert(key);
        self.losses += 1;
    }

    /// The next claimant, with its line; none where no other one can get anything.
    pub(super) fn next(&mut self) -> Option<(QueueKey, Option<usize>)> {
        loop {
            self.wake();
            if !self.visits_all && self.losers.is_empty() && !self.can_one_get() {
                return None;
            }
            let heads = self.lines.iter().enumerate();
            let heads = heads.filter(|(_, line)| self.visits_all || !line.is_asleep());
            let heads = heads.filter_map(|(index, line)| Some((line.head?, Some(index))));
            let (key, line) = heads.chain(self.losers.first().map(|key| (*key, None))).min_by(|a, b| a.0.cmp(&b.0))?;
            self.position = Some(key);
            let Some(index) = line else {
                self.losers.remove(&key);
                return Some((key, None));
            };
            let (agent, visits_all) = (&*self.cycle.agent, self.visits_all);
            let line = self.lines.get_mut(index)?;
            line.advance(self.cycle);
            let quiet = line.quiet.as_ref().filter(|_| !visits_all);
            let expected = |task: TaskId| agent.task(task).and_then(|task| task.selection.as_ref()?.expected);
            if !quiet.is_some_and(|(_, least)| takes_as_long(expected(key.task()), *least)) {
                return Some((key, Some(index)));
            }
        }
    }

    /// GapLines whose claims change something again continue behind the last one that had its turn.
    fn wake(&mut self) {
        let (field, losses, position, cycle) = (&self.field, self.losses, self.position, self.cycle);
        for line in &mut self.lines {
            let changed = |mark: &UseCounts| *mark != mark_of(field, &line.needs, losses);
            if line.quiet.as_ref().is_some_and(|(mark, _)| changed(mark)) {
                line.quiet = None;
                if let Some(position) = position {
                    line.skip_to(cycle, position);
                }
            }
        }
    }

    /// Notes that one of a line was refused.
    pub(super) fn was_refused(&mut self, line: Option<usize>, task: TaskId, claim: UseKind) {
        let Some(line) = line.and_then(|index| self.lines.get_mut(index)) else { return };
        line.refused.push(task);
        let field = &self.field;
        let claims_all = |(id, _): &(ResourceId, f64)| {
            let claimed = field.uses_of(*id).iter().filter(|each| each.kind == claim).map(|each| each.amount);
            claimed.sum::<f64>() > field.total(*id) + TOLERANCE
        };
        if line.needs.iter().all(claims_all) {
            let expected = self.cycle.task(task).and_then(|task| task.selection.as_ref()?.expected);
            line.quiet = Some((mark_of(field, &line.needs, self.losses), expected));
        }
    }

    /// True if a line can get its needs: into a gap, into free capacity, or from a holder that it beats.
    fn can_one_get(&self) -> bool {
        let rooms: BTreeMap<ResourceId, Room> = self.resources.keys().map(|id| (*id, Room::of(self, *id))).collect();
        let mut awake = self.lines.iter().filter(|line| !line.is_asleep());
        awake.any(|line| {
            let Some(head) = line.head else { return false };
            let until = line.shortest.map(|shortest| self.cycle.now + shortest);
            let finds_room =
                |(id, amount): &(ResourceId, f64)| rooms.get(id).is_some_and(|room| room.admits(*amount, until));
            let takes = |(id, amount): &(ResourceId, f64)| rooms.get(id).is_some_and(|room| room.yields(*amount, head));
            line.needs.iter().all(|need| finds_room(need) || takes(need))
        })
    }

    /// The first of each line, whose priorities may rise above those of tasks in their way.
    pub(super) fn watched(&self, result: &Arbitration) -> Vec<PriorityWatch> {
        let agent = &*self.cycle.agent;
        let moves = |task: TaskId| priority::moves(agent, task) || priority::reads_inputs(agent, task);
        let holders: Vec<TaskId> =
            self.resources.keys().flat_map(|id| self.field.uses_of(*id)).map(|each| each.task).collect();
        let any = self.resources.values().any(|resource| resource.waiting.has_rising());
        if matches!(self.order, TurnOrder::Below(_)) || !any && !holders.iter().any(|task| moves(*task)) {
            return Vec::new();
        }
        let fronts: Vec<Vec<TaskId>> = self.lines.iter().map(Line::front).collect();
        let mut tasks: Vec<TaskId> = fronts.iter().flatten().copied().chain(holders).collect();
        tasks.sort_unstable();
        tasks.dedup();
        let worth: Vec<Option<Cow<'_, QueuePlace>>> = tasks.iter().map(|task| self.worth(*task)).collect();
        let number = |task: &TaskId| tasks.binary_search(task).ok();
        let mut rivals: BTreeMap<Vec<ResourceId>, Vec<(usize, bool)>> = BTreeMap::new();
        let mut watched = Vec::new();
        for (line, front) in self.lines.iter().zip(&fronts) {
            let needs: Vec<ResourceId> = line.needs.iter().map(|need| need.0).collect();
            let rivals = rivals.entry(needs).or_insert_with_key(|needs| self.rivals(needs, &fronts, number));
            for task in front.iter().filter(|task| !result.granted.contains(task)) {
                let own = number(task).and_then(|number| worth.get(number)?.as_deref());
                let may_overtake = |(other, _): &&(usize, bool)| {
                    let other = worth.get(*other).and_then(|worth| worth.as_deref());
                    own.zip(other).is_none_or(|(own, other)| own.may_overtake(other))
                };
                let others = rivals.iter().filter(may_overtake).filter_map(|(other, holds)| {
                    let other = *tasks.get(*other).filter(|other| *other != task)?;
                    Some(Rival { task: other, holds: *holds, stands_for: Rc::new([other]) })
                });
                let rivals: Vec<Rival> = others.collect();
                let looks = agent.task(*task).and_then(|task| task.extras.as_ref()?.crossing).is_some();
                if looks || !rivals.is_empty() {
                    watched.push(PriorityWatch { task: *task, stands_for: Rc::new([*task]), rivals });
                }
            }
        }
        watched
    }

    /// The place of a task by its priorities; none where they move in another way than by urgency.
    fn worth(&self, task: TaskId) -> Option<Cow<'a, QueuePlace>> {
        let waits = self.resources.values().find_map(|resource| resource.waiting.place_of(task, self.order));
        waits.map(Cow::Borrowed).or_else(|| claim_queue::worth_of(self.cycle, task).map(Cow::Owned))
    }

    /// The first of all lines that share one of these resources, and all that use one of them: by number, with true for one
    /// that has it.
    fn rivals(
        &self,
        needs: &[ResourceId],
        fronts: &[Vec<TaskId>],
        number: impl Fn(&TaskId) -> Option<usize>,
    ) -> Vec<(usize, bool)> {
        let mut rivals: BTreeMap<usize, bool> = BTreeMap::new();
        let shares = |line: &Line<'_>| line.needs.iter().any(|need| needs.contains(&need.0));
        let waiting = self.lines.iter().zip(fronts).filter(|(line, _)| shares(line)).flat_map(|(_, front)| front);
        rivals.extend(waiting.filter_map(&number).map(|number| (number, false)));
        for each in needs.iter().flat_map(|id| self.field.uses_of(*id)) {
            let holds = !matches!(each.kind, UseKind::Awaited(_));
            if let Some(number) = number(&each.task) {
                *rivals.entry(number).or_default() |= holds;
            }
        }
        rivals.into_iter().collect()
    }
}

impl<'a> Line<'a> {
    fn of(cycle: &'a Cycle<'_>, needs: Vec<(ResourceId, f64)>, group: &'a Group, order: TurnOrder) -> Line<'a> {
        let turns: Box<dyn TurnSource + 'a> = Box::new(group_in_turn(cycle, group, order));
        let (shortest, refused) = (group.shortest(), Vec::new());
        let mut line = Line { needs, shortest, turns, head: None, refused, quiet: None };
        line.advance(cycle);
        line
    }

    fn advance(&mut self, cycle: &Cycle<'_>) {
        self.head = loop {
            match self.turns.next() {
                Some(key) if !is_eligible(cycle.agent, key.task()) => {}
                next => break next,
            }
        };
    }

    /// Leaves out those before `position`.
    fn skip_to(&mut self, cycle: &Cycle<'_>, position: QueueKey) {
        if self.head.is_some_and(|head| head < position) {
            self.turns.skip_to(position);
            self.advance(cycle);
        }
    }

    /// True if claims of all of them change nothing.
    fn is_asleep(&self) -> bool {
        self.quiet.as_ref().is_some_and(|(_, least)| takes_as_long(self.shortest, *least))
    }

    /// Those that were refused, and the next ones.
    fn front(&self) -> Vec<TaskId> {
        let next = self.head.into_iter().chain(self.turns.heads()).map(|key| key.task());
        self.refused.iter().copied().chain(next).collect()
    }
}

/// The remaining capacity of a resource.
struct Room {
    free: f64,
    /// Claims of those that cannot begin before an instant; none where that is unknown.
    claims: Vec<(Option<Time>, f64)>,
    /// The amount of each holder, and the rank or the priority with which it defends that.
    held: Vec<(f64, f64)>,
    by_rank: bool,
}

impl Room {
    fn of(lines: &GapLines<'_, '_>, id: ResourceId) -> Room {
        let (mut used, mut claims, mut held) = (0.0, Vec::new(), Vec::new());
        for each in lines.field.uses_of(id) {
            match each.kind {
                UseKind::Awaited(earliest) => claims.push((earliest, each.amount)),
                UseKind::Granted => used += each.amount,
                UseKind::Held => {
                    used += each.amount;
                    let strength = match lines.order {
                        TurnOrder::Below(parent) => {
                            let rank = rank_below(lines.cycle.agent, each.task, parent).1;
                            rank.map_or(f64::INFINITY, |rank| rank.rank)
                        }
                        TurnOrder::Plain | TurnOrder::Level(_) => lines.field.defence(each.task).total(),
                    };
                    held.push((each.amount, strength));
                }
            }
        }
        let by_rank = matches!(lines.order, TurnOrder::Below(_));
        Room { free: lines.field.total(id) - used, claims, held, by_rank }
    }

    /// True if there is this amount for a task that is done at this instant.
    fn admits(&self, amount: f64, until: Option<Time>) -> bool {
        let counts = |earliest: &Option<Time>| earliest.zip(until).is_none_or(|(earliest, until)| until > earliest);
        let claimed: f64 = self.claims.iter().filter(|claim| counts(&claim.0)).map(|claim| claim.1).sum();
        amount <= TOLERANCE || amount + claimed <= self.free + TOLERANCE
    }

    /// True if holders that this claimant may beat could have this amount. No task loses anything for the sake of a gap.
    fn yields(&self, amount: f64, key: QueueKey) -> bool {
        let beaten = |strength: f64| match (self.by_rank, key.rank) {
            (true, Some(own)) => own.rank <= strength,
            (true, None) => true,
            (false, _) => key.priority > strength,
        };
        let lost: f64 = self.held.iter().filter(|each| beaten(each.1)).map(|each| each.0).sum();
        let claimed: f64 = self.claims.iter().map(|claim| claim.1).sum();
        amount + claimed <= self.free + lost + TOLERANCE
    }
}

fn mark_of(field: &Field<'_, '_>, needs: &[(ResourceId, f64)], losses: usize) -> UseCounts {
    UseCounts(needs.iter().map(|(id, _)| field.uses_of(*id).len()).collect(), losses)
}

/// True if a task takes no less time than `least`; unknown times are the longest.
fn takes_as_long(expected: Option<Duration>, least: Option<Duration>) -> bool {
    expected.is_none_or(|expected| least.is_some_and(|least| expected >= least))
}

//! Lines of claimants before gaps (TC)
//! What: gives turns to claimants group by group, and skips the claimants of a group whose claims no longer change the result.
//! Runs: contend phase, for `gaps`.  Reads: ResourceTable, priorities.  Writes: nothing.
//! Bound: O(g) for a turn, for g groups; O(u) for the u uses of a resource.
//! PDL: `expected-duration`, section 9, conflict.  Paper: section III, detecting and resolving conflicts.
//!
//! A task behind a refused one of the same group is refused, too: it needs the same resources for at least as long, and beats no further
//! task. Its claims count against later claimants, until the claims that cannot begin later exceed the whole of each resource. Once they do
//! so at the first instant at which anything becomes free, all tasks that end after this instant are refused, whatever they need.

use crate::control::conflicts::arbitration::{Arbitration, PriorityWatch, Rival};
use crate::control::conflicts::claim_queue;
use crate::control::conflicts::competition::is_eligible;
use crate::control::conflicts::conflict::Field;
use crate::control::conflicts::gap_watch::{in_front, rise_alike};
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

/// One group of claimants, with the state of the pass through it.
struct Line<'a> {
    needs: Vec<(ResourceId, f64)>,
    /// The shortest expected duration in the group; `None` if none is stated.
    shortest: Option<Duration>,
    turns: Box<dyn TurnSource + 'a>,
    head: Option<QueueKey>,
    /// Claimants of the group that were refused.
    refused: Vec<TaskId>,
    /// If further claims of the group change nothing: the uses at that moment, and the expected duration from which on this holds.
    quiet: Option<(UseCounts, Option<Duration>)>,
    /// True while all claimants of the group are refused, and their claims change nothing.
    idles: bool,
}

/// State of the resources of a line: the number of uses of each, and the number of displaced tasks.
#[derive(PartialEq)]
struct UseCounts(Vec<usize>, usize);

/// All groups of claimants.
pub(super) struct GapLines<'a, 'c> {
    cycle: &'a Cycle<'c>,
    /// Grants and refusals.
    pub(super) field: Field<'a, 'c>,
    /// True if every claimant takes a turn, even if its claim changes nothing.
    pub(super) visits_all: bool,
    lines: Vec<Line<'a>>,
    resources: BTreeMap<ResourceId, &'a Resource>,
    order: TurnOrder,
    /// Displaced tasks, which claim their resources again.
    losers: BTreeSet<QueueKey>,
    losses: usize,
    /// The claimant that had its turn last.
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
            // A group that needs several resources is in the queue of each: only the first resource lists it here.
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

    /// Adds a displaced task.
    pub(super) fn add_loser(&mut self, key: QueueKey) {
        self.losers.insert(key);
        self.losses += 1;
    }

    /// Returns the next claimant with its line; `None` if no further claimant can get a resource.
    pub(super) fn next(&mut self) -> Option<(QueueKey, Option<usize>)> {
        loop {
            self.wake();
            self.idle();
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

    /// Continues the lines whose claims matter again, behind the claimant that had its turn last.
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

    /// Skips the claimants of lines while these are refused in any case, and continues the other lines.
    fn idle(&mut self) {
        if self.visits_all {
            return;
        }
        let exhausted: BTreeMap<ResourceId, Exhaustion> =
            self.resources.keys().map(|id| (*id, Exhaustion::of(&self.field, *id))).collect();
        let (now, position, cycle) = (self.cycle.now, self.position, self.cycle);
        for line in &mut self.lines {
            let needs = line.needs.iter().map(|(id, _)| exhausted.get(id));
            let until = line.shortest.map(|shortest| now + shortest);
            let idles = Exhaustion::refuses(needs, until);
            if line.idles
                && !idles
                && let Some(position) = position
            {
                line.skip_to(cycle, position);
            }
            line.idles = idles;
        }
    }

    /// Notes that a claimant of the line was refused.
    pub(super) fn was_refused(&mut self, line: Option<usize>, task: TaskId, claim: UseKind) {
        let Some(line) = line.and_then(|index| self.lines.get_mut(index)) else { return };
        line.refused.push(task);
        let field = &self.field;
        let UseKind::Awaited(earliest) = claim else { return };
        let expected = self.cycle.task(task).and_then(|task| task.selection.as_ref()?.expected);
        let until = expected.map(|expected| self.cycle.now + expected);
        // Claims that count wherever this one does.
        let counts = |kind: UseKind| match kind {
            UseKind::Awaited(at) => at <= earliest,
            UseKind::Held | UseKind::Granted => false,
        };
        // A longer task also waits for claims that leave this one a gap.
        let leaves_gap = |kind: UseKind| match (kind, earliest, until) {
            (UseKind::Awaited(Some(at)), Some(earliest), Some(until)) => until <= at && at < earliest,
            _ => false,
        };
        let claims_all = |(id, _): &(ResourceId, f64)| {
            let uses = field.uses_of(*id);
            let claimed = uses.iter().filter(|each| counts(each.kind)).map(|each| each.amount);
            claimed.sum::<f64>() > field.total(*id) + TOLERANCE && !uses.iter().any(|each| leaves_gap(each.kind))
        };
        if line.needs.iter().all(claims_all) {
            line.quiet = Some((mark_of(field, &line.needs, self.losses), expected));
        }
    }

    /// Returns true if a line can get its needs: into a gap, into free capacity, or from a holder that it beats.
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

    /// Returns the first claimants of each line, whose priorities may rise above those of tasks in their way.
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
        let rise_alike = rise_alike(&worth);
        let number = |task: &TaskId| tasks.binary_search(task).ok();
        let uses = self.resources.keys().flat_map(|id| self.field.uses_of(*id));
        let held: BTreeSet<TaskId> =
            uses.filter(|each| !matches!(each.kind, UseKind::Awaited(_))).map(|each| each.task).collect();
        let holds: Vec<bool> = tasks.iter().map(|task| held.contains(task)).collect();
        let front_of = in_front(self.cycle, &worth, &holds);
        let mut rivals: BTreeMap<Vec<ResourceId>, Vec<(usize, bool)>> = BTreeMap::new();
        let mut watched = Vec::new();
        for (line, front) in self.lines.iter().zip(&fronts) {
            let needs: Vec<ResourceId> = line.needs.iter().map(|need| need.0).collect();
            let rivals = rivals.entry(needs).or_insert_with_key(|needs| match rise_alike {
                true => Vec::new(),
                // Where the order is known, each is compared with holders and with the claimant in front of it.
                false if front_of.is_some() => {
                    self.rivals(needs, &[], number).into_iter().filter(|(_, holds)| *holds).collect()
                }
                false => self.rivals(needs, &fronts, number),
            });
            for task in front.iter().filter(|task| !result.granted.contains(task)) {
                let index = number(task);
                let own = index.and_then(|number| worth.get(number)?.as_deref());
                let front = front_of.as_ref().zip(index).and_then(|(front_of, index)| *front_of.get(index)?);
                let front = front.filter(|_| !rise_alike).map(|front| (front, false));
                let may_overtake = |(other, _): &&(usize, bool)| {
                    let other = worth.get(*other).and_then(|worth| worth.as_deref());
                    own.zip(other).is_none_or(|(own, other)| own.may_overtake(other))
                };
                let others = rivals.iter().chain(&front).filter(may_overtake).filter_map(|(other, holds)| {
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

    /// Returns the place of a task by its priorities; `None` if they change in another way than by urgency.
    fn worth(&self, task: TaskId) -> Option<Cow<'a, QueuePlace>> {
        let waits = self.resources.values().find_map(|resource| resource.waiting.place_of(task, self.order));
        waits.map(Cow::Borrowed).or_else(|| claim_queue::worth_of(self.cycle, task).map(Cow::Owned))
    }

    /// Returns, by task, the first claimants of all lines that share one of these resources, and all users of these resources; true for a
    /// holder.
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
        let mut line = Line { needs, shortest, turns, head: None, refused, quiet: None, idles: false };
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

    /// Skips the claimants before `position`.
    fn skip_to(&mut self, cycle: &Cycle<'_>, position: QueueKey) {
        if self.head.is_some_and(|head| head < position) {
            self.turns.skip_to(position);
            self.advance(cycle);
        }
    }

    /// Returns true if no claim of the line changes the result.
    fn is_asleep(&self) -> bool {
        self.idles || self.quiet.as_ref().is_some_and(|(_, least)| takes_as_long(self.shortest, *least))
    }

    /// Returns the refused claimants and the next ones.
    fn front(&self) -> Vec<TaskId> {
        let next = self.head.into_iter().chain(self.turns.heads()).map(|key| key.task());
        self.refused.iter().copied().chain(next).collect()
    }
}

/// The instant from which on claims exceed a resource. Unknown instants count as the earliest.
struct Exhaustion {
    /// The instant by which the claims that cannot begin after it exceed the whole resource; the inner `None` is an unknown instant, the
    /// outer one means that all claims together do not exceed the resource.
    from: Option<Option<Time>>,
    /// The first instant at which a use may end or a claimant may begin.
    first: Option<Option<Time>>,
}

impl Exhaustion {
    fn of(field: &Field<'_, '_>, id: ResourceId) -> Exhaustion {
        let (mut claims, mut first) = (Vec::new(), None);
        for each in field.uses_of(id) {
            let end = field.expected_end(each);
            first = Some(first.map_or(end, |known: Option<Time>| known.min(end)));
            if let UseKind::Awaited(at) = each.kind {
                claims.push((at, each.amount));
            }
        }
        claims.sort_by_key(|claim| claim.0);
        let (total, mut sum) = (field.total(id), 0.0);
        let from = claims.iter().find_map(|(at, amount)| {
            sum += amount;
            (sum > total + TOLERANCE).then_some(*at)
        });
        Exhaustion { from, first }
    }

    /// Returns true if a task that ends at `until` is refused, and its claims change nothing: at the first instant at which anything it
    /// needs becomes free, claims exceed all that it needs.
    fn refuses<'e>(mut needs: impl Iterator<Item = Option<&'e Exhaustion>>, until: Option<Time>) -> bool {
        let mut common = None;
        needs.all(|need| {
            let Some(Exhaustion { from: Some(from), first: Some(first) }) = need else { return false };
            let ends_later = from.zip(until).is_none_or(|(from, until)| until > from);
            from == first && *common.get_or_insert(*from) == *from && ends_later
        })
    }
}

/// The remaining capacity of a resource.
struct Room {
    free: f64,
    /// Claims that cannot begin before the given instant; `None` if that instant is unknown.
    claims: Vec<(Option<Time>, f64)>,
    /// The amount of each holder, and the rank or priority with which it defends that amount.
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

    /// Returns true if `amount` is free for a task that ends at `until`.
    fn admits(&self, amount: f64, until: Option<Time>) -> bool {
        let counts = |earliest: &Option<Time>| earliest.zip(until).is_none_or(|(earliest, until)| until > earliest);
        let claimed: f64 = self.claims.iter().filter(|claim| counts(&claim.0)).map(|claim| claim.1).sum();
        amount <= TOLERANCE || amount + claimed <= self.free + TOLERANCE
    }

    /// Returns true if holders that this claimant may beat could yield this amount. No task is displaced to fill a gap.
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

/// Returns true if a task takes at least `least`; an unknown duration counts as the longest.
fn takes_as_long(expected: Option<Duration>, least: Option<Duration>) -> bool {
    expected.is_none_or(|expected| least.is_some_and(|least| expected >= least))
}

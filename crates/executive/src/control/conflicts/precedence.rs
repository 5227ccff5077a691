//! Precedence (TC)
//! What: puts competitors into one order that respects ranks and priorities. A task that precedes another one by rank is at least as
//! important as that one, so ranks and priorities never contradict each other in a ring.
//! Runs: contend phase, where ranks are stated.  Reads: ranks, priorities, needs.  Writes: nothing.
//! Bound: O(c^2 * depth) for c competitors; as much again for each task whose represented tasks are computed, where priorities change
//! with time.
//! PDL: `rank`, `priority`, section 9, conflict; decision 0023.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::competition::{Claimant, by_priority};
use crate::control::conflicts::priority;
use crate::state::agent::Agent;
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// The order of all competitors for some resources.
pub(crate) struct Precedence {
    competitors: Vec<Competitor>,
    places: BTreeMap<TaskId, OrderKey>,
    /// True if priorities can change without a new or withdrawn claim.
    varies: bool,
    /// Represented tasks, by task: cached, because one task blocks many claimants.
    stand_for: RefCell<BTreeMap<TaskId, Rc<[TaskId]>>>,
}

/// A claimant or holder, with the ranks on the path from the root to it.
struct Competitor {
    claimant: Claimant,
    path: Vec<(TaskId, Option<f64>)>,
}

#[derive(Clone, Copy)]
pub(crate) struct OrderKey {
    pub(crate) turn: usize,
    /// The most important competitor that it precedes; itself if it precedes none.
    pub(crate) whom: TaskId,
    /// The priority of that competitor.
    pub(crate) priority: f64,
    /// The priority of the task itself.
    pub(crate) own: f64,
}

impl Precedence {
    /// Returns the order of `claimants`, holders among them.
    pub(crate) fn of(agent: &Agent, now: Time, claimants: Vec<Claimant>) -> Precedence {
        let with_path = |claimant: Claimant| {
            let path = rank_path(agent, claimant.id, now);
            Competitor { claimant, path }
        };
        let mut competitors: Vec<Competitor> = claimants.into_iter().map(with_path).collect();
        let alone = begun_first(&competitors);
        competitors.iter_mut().zip(alone).for_each(|(each, counts)| each.claimant.begun = counts);
        competitors.sort_by(|a, b| by_priority(&a.claimant, &b.claimant));
        let varies = competitors.iter().any(|each| {
            let id = each.claimant.id;
            priority::moves(agent, id) || priority::reads_inputs(agent, id)
        });
        let (places, stand_for) = (BTreeMap::new(), RefCell::default());
        let mut precedence = Precedence { competitors, places, varies, stand_for };
        precedence.place_all();
        precedence
    }

    /// Returns an order without competitors, for places that are known otherwise; priorities do not change with time.
    pub(crate) fn empty() -> Precedence {
        let (competitors, places) = (Vec::new(), BTreeMap::new());
        Precedence { competitors, places, varies: false, stand_for: RefCell::default() }
    }

    /// Sets the place of a task.
    pub(crate) fn insert(&mut self, id: TaskId, place: OrderKey) {
        self.places.insert(id, place);
    }

    /// Places all competitors by priority, but each one after those that precede it by rank, recursively.
    fn place_all(&mut self) {
        let count = self.competitors.len();
        // For each competitor, the index up to which tasks that precede it have been searched.
        let mut looked = vec![0_usize; count];
        for (root, whom) in self.competitors.iter().enumerate() {
            let mut open = vec![root];
            while let Some((&index, competitor)) =
                open.last().and_then(|index| Some((index, self.competitors.get(*index)?)))
            {
                let from = looked.get(index).copied().unwrap_or(count);
                let next = self.next_before(competitor, from);
                if let Some(looked) = looked.get_mut(index) {
                    *looked = next.map_or(count, |next| next + 1);
                }
                match next {
                    Some(next) => open.push(next),
                    None => {
                        open.pop();
                        let (turn, whom) = (self.places.len(), &whom.claimant);
                        let own = competitor.claimant.priority;
                        let place = OrderKey { turn, whom: whom.id, priority: whom.priority, own };
                        self.places.entry(competitor.claimant.id).or_insert(place);
                    }
                }
            }
        }
    }

    /// Returns the first competitor, from index `from` on, that precedes `competitor` and has no place yet.
    fn next_before(&self, competitor: &Competitor, from: usize) -> Option<usize> {
        let open = |other: &Competitor| !self.places.contains_key(&other.claimant.id) && other.goes_before(competitor);
        self.competitors.iter().skip(from).position(open).map(|index| index + from)
    }

    /// Sets the turn and the priority of the claimant.
    pub(crate) fn apply(&self, claimant: &mut Claimant) {
        if let Some(place) = self.places.get(&claimant.id) {
            claimant.turn = place.turn;
            claimant.priority = claimant.priority.max(place.priority);
        }
    }

    /// Returns the priority that counts for a task with the priority `own`.
    pub(crate) fn lifted(&self, id: TaskId, own: f64) -> f64 {
        self.places.get(&id).map_or(own, |place| own.max(place.priority))
    }

    /// Returns the task whose priority counts for `id`, if it is another task.
    pub(crate) fn instead_of_own(&self, id: TaskId) -> Option<TaskId> {
        self.places.get(&id).filter(|place| place.priority > place.own).map(|place| place.whom)
    }

    /// Returns all tasks whose priorities may count for `id`: itself, the tasks that it precedes, and those that these precede in turn.
    pub(crate) fn stands_for(&self, id: TaskId) -> Rc<[TaskId]> {
        if !self.varies {
            return Rc::new([id]);
        }
        let known = self.stand_for.borrow().get(&id).cloned();
        known.unwrap_or_else(|| {
            let found: Rc<[TaskId]> = self.all_behind(id).into();
            self.stand_for.borrow_mut().insert(id, Rc::clone(&found));
            found
        })
    }

    fn all_behind(&self, id: TaskId) -> Vec<TaskId> {
        let mut found = vec![id];
        let (mut open, mut rest): (Vec<_>, Vec<_>) = self.competitors.iter().partition(|each| each.claimant.id == id);
        while let Some(competitor) = open.pop() {
            let (behind, others): (Vec<_>, Vec<_>) = rest.into_iter().partition(|other| competitor.goes_before(other));
            found.extend(behind.iter().map(|each| each.claimant.id));
            open.extend(behind);
            rest = others;
        }
        found
    }
}

impl Competitor {
    /// Returns true if this competitor precedes by rank a task that needs the same resource. A task does not compete with its ancestors.
    fn goes_before(&self, other: &Competitor) -> bool {
        let pair = self.path.iter().zip(&other.path).find(|(own, others)| own.0 != others.0);
        let Some(((_, Some(own)), (_, Some(others)))) = pair else { return false };
        let mut needs = self.claimant.needs.iter();
        own < others && needs.any(|need| other.claimant.needs.iter().any(|each| each.resource == need.resource))
    }
}

/// Returns for each competitor true if it precedes equals because it has begun. False for a competitor that has begun if a task that has
/// not begun precedes it by rank. That task would otherwise precede its own equals too, and a task that fills a gap would displace the one
/// that had to leave the gap.
fn begun_first(competitors: &[Competitor]) -> Vec<bool> {
    let mut counts: Vec<bool> = competitors.iter().map(|each| each.claimant.begun).collect();
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for (index, each) in competitors.iter().enumerate() {
            let held_back = || competitors.iter().zip(&counts).any(|(other, begun)| !begun && other.goes_before(each));
            if counts.get(index).is_some_and(|begun| *begun) && held_back() {
                changed = true;
                counts.iter_mut().skip(index).take(1).for_each(|begun| *begun = false);
            }
        }
    }
    counts
}

/// Returns the task and its ancestors from the root down, with their ranks.
fn rank_path(agent: &Agent, id: TaskId, now: Time) -> Vec<(TaskId, Option<f64>)> {
    let family = std::iter::successors(agent.task(id), |task| agent.task(task.parent?));
    let mut path: Vec<_> = family.map(|task| (task.id, priority::rank(agent, task.id, now))).collect();
    path.reverse();
    path
}

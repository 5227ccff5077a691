//! Claims (TC)
//! What: computes a claimant's place in the queues of the resources that it needs, if that place depends on the claimant alone.
//! Runs: contend phase, when a task claims and when an input of its priority changed.
//! Reads: ResourceTable, priorities, ranks, ancestors.  Writes: nothing.
//! Bound: O(depth * needs).
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::{PriorityWatch, Rival};
use crate::control::conflicts::competition::{has_begun, order_of};
use crate::control::conflicts::priority::{self, PriorityChange, reads_variable};
use crate::control::cycle::Cycle;
use crate::state::agent::Agent;
use crate::state::claim::{Claim, QueuedClaim};
use crate::state::queue_place::{QueueKey, QueuePlace, RankAmong, RisingKey};
use crate::state::resource::Need;
use crate::state::resource_id::ResourceId;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, Task};
use apex_model::expression::ExprKind;
use apex_model::procedure::{PriorityClause, ProcedureKind, Step};
use apex_model::task::{TaskId, TaskState};
use std::collections::{BTreeMap, BTreeSet};
use std::iter::successors;
use std::rc::Rc;

/// Returns the claim of `id`, which needs `needs`.
pub(crate) fn claim_of(cycle: &Cycle<'_>, id: TaskId, needs: &[Need]) -> Claim {
    let agent = &*cycle.agent;
    let used_up = |need: &Need| agent.resources.get(need.resource).is_none_or(|resource| resource.depletable);
    if needs.iter().any(used_up) || shares_with_ancestors(agent, id, needs) {
        return Claim::Apart;
    }
    let places = ClaimPlaces::of(cycle, id, needs);
    let by_rank = places_by_rank(agent, id, places.level.as_ref());
    if by_rank.is_empty() && places.place.is_none() {
        return Claim::Apart;
    }
    let expected = agent.task(id).and_then(|task| task.selection.as_ref()?.expected);
    // A claimant of several resources is listed in the queue of each, with all its needs; with one need the list stays empty.
    let several = needs.len() > 1;
    let others = needs.iter().filter(|_| several).map(|need| (need.resource, need.amount.to_bits())).collect();
    let amount = needs.first().map_or(0.0, |need| need.amount);
    let ClaimPlaces { place, level, varies } = places;
    Claim::Queued(Box::new(QueuedClaim { place, level, varies, expected, amount, others, by_rank }))
}

/// Returns the task's place among the tasks below each of its ranked ancestors, for orders in which ranks count before priorities.
fn places_by_rank(agent: &Agent, id: TaskId, level: Option<&QueuePlace>) -> Vec<QueueKey> {
    let (begun, order) = (has_begun(agent, id), order_of(agent, id));
    let within = level.and_then(|level| level.steady).map_or(0.0, |key| key.priority);
    let ranks = fixed_ranks(agent, id).enumerate();
    ranks
        .map(|(index, rank)| {
            let within = if index == 0 { within } else { 0.0 };
            QueueKey { priority: 0.0, rank: Some(rank), within, begun, order }
        })
        .collect()
}

/// Returns the ranks of the task and its ancestors that never change, the lowest first.
pub(crate) fn fixed_ranks(agent: &Agent, id: TaskId) -> impl Iterator<Item = RankAmong> + '_ {
    let family = successors(agent.task(id), |task| agent.task(task.parent?));
    family.filter(|task| task.clauses.has(StepClauses::RANK)).filter_map(|task| {
        let (step, _) = template(agent, task)?;
        let fixed = step.rank.as_ref().is_none_or(|expr| matches!(expr.kind, ExprKind::Constant(_)));
        let rank = priority::rank(agent, task.id, agent.now).filter(|_| fixed)?;
        Some(RankAmong { parent: task.parent?, rank })
    })
}

/// Queue places of a claimant that depend on the claimant alone.
struct ClaimPlaces {
    /// Its place in the queue of all claimants.
    place: Option<QueuePlace>,
    /// Its place among claimants of the same rank.
    level: Option<QueuePlace>,
    /// True if variables may change these places.
    varies: bool,
}

impl ClaimPlaces {
    fn of(cycle: &Cycle<'_>, id: TaskId, needs: &[Need]) -> ClaimPlaces {
        let nowhere = ClaimPlaces { place: None, level: None, varies: true };
        let Some(brings) = Brings::of(cycle.agent, id) else { return nowhere };
        let Some(worth) = brings.place(cycle, id) else { return nowhere };
        let varies = brings.varies;
        let Some(rank) = brings.rank else {
            return ClaimPlaces { place: Some(worth), level: None, varies };
        };
        // A rank can contradict the priorities below it, and two ranks can contradict each other. With a rank and several needs, the
        // order can depend on claimants of other resources.
        let is_alone = !brings.contradicts && worth.rising.is_empty() && needs.len() == 1;
        let ranked = |key: QueueKey| QueueKey { rank: Some(rank), ..key };
        let place = is_alone.then(|| QueuePlace { steady: worth.steady.map(ranked), rising: Vec::new() });
        ClaimPlaces { place, level: Some(worth), varies }
    }
}

/// Returns the priority watches of the claimants in `contests`, by task. The flag of a rival is true if it holds the contested resource.
/// A rival that the passing of time can never bring behind the claimant is left out.
pub(crate) fn watches(cycle: &Cycle<'_>, contests: BTreeMap<TaskId, BTreeMap<TaskId, bool>>) -> Vec<PriorityWatch> {
    let concerned = contests.iter().flat_map(|(task, rivals)| rivals.keys().chain([task]));
    let concerned: BTreeSet<TaskId> = concerned.copied().collect();
    let worth = |id: TaskId| (id, worth_of(cycle, id));
    let places: BTreeMap<TaskId, Option<QueuePlace>> = concerned.into_iter().map(worth).collect();
    let may_overtake = |task: &TaskId, other: &TaskId| match (places.get(task), places.get(other)) {
        (Some(Some(own)), Some(Some(other))) => own.may_overtake(other),
        _ => true,
    };
    let watch = |(task, rivals): (TaskId, BTreeMap<TaskId, bool>)| {
        let all = rivals.into_iter().filter(|(other, _)| may_overtake(&task, other));
        let rival = |(task, holds)| Rival { task, holds, stands_for: Rc::new([task]) };
        PriorityWatch { task, stands_for: Rc::new([task]), rivals: all.map(rival).collect() }
    };
    contests.into_iter().map(watch).collect()
}

/// Returns the place of a task by its priorities alone; `None` if one of them, or its interrupt cost, changes in another way than by its
/// urgency.
pub(crate) fn worth_of(cycle: &Cycle<'_>, id: TaskId) -> Option<QueuePlace> {
    let cost = priority::cost_clause(cycle.agent, id);
    let costs_the_same = cost.is_none_or(|(expr, _)| matches!(expr.kind, ExprKind::Constant(_)));
    Brings::of(cycle.agent, id).filter(|_| costs_the_same)?.place(cycle, id)
}

/// Returns true if an ancestor needs one of the same resources. A task shares what its ancestors hold, so no queue applies.
fn shares_with_ancestors(agent: &Agent, id: TaskId, needs: &[Need]) -> bool {
    let wants = |id: ResourceId| needs.iter().any(|need| need.resource == id);
    successors(agent.task(id), |task| agent.task(task.parent?)).skip(1).any(|above| {
        let profile = above.selection.iter().flat_map(|selection| &selection.needs);
        let held = above.extras.iter().flat_map(|extras| &extras.held);
        profile.chain(held).any(|need| wants(need.resource))
    })
}

/// Ranks and priorities that a task and its ancestors bring into a conflict.
#[derive(Default)]
struct Brings<'a> {
    /// Clauses whose priority rises by urgency.
    rising: Vec<(&'a Task, &'a PriorityClause)>,
    /// Number of the other priority clauses.
    steady: usize,
    /// True if variables may change a priority.
    varies: bool,
    /// The lowest rank.
    rank: Option<RankAmong>,
    /// True if there is another rank above `rank`, or a priority below it.
    contradicts: bool,
}

impl<'a> Brings<'a> {
    /// Returns what the task contributes to a conflict; `None` if its priority changes in an unknown way, if several ranks count, or if
    /// steps of one ranked procedure can have different priorities.
    fn of(agent: &'a Agent, id: TaskId) -> Option<Brings<'a>> {
        let mut brings = Brings::default();
        for task in successors(agent.task(id), |task| agent.task(task.parent?)) {
            if !task.clauses.has(StepClauses::CONTENTION) && !task.clauses.has(StepClauses::RANK) {
                continue;
            }
            let Some((step, kind)) = template(agent, task) else { continue };
            if task.id == id || task.state != TaskState::Interrupted {
                brings.add_priorities(task, step)?;
            } else if brings.rank.is_none() && !step.priority.is_empty() {
                brings.contradicts = true;
            }
            brings.add_rank(agent, task, (step, kind))?;
        }
        Some(brings)
    }

    fn add_priorities(&mut self, task: &'a Task, step: &'a Step) -> Option<()> {
        let recovers = step.repeating.as_ref().is_some_and(|repetition| repetition.recovery.is_some());
        if recovers && !step.priority.is_empty() {
            return None;
        }
        for clause in &step.priority {
            match clause {
                PriorityClause::Number(expr) => {
                    self.varies |= reads_variable(expr)?;
                    self.steady += 1;
                }
                PriorityClause::UrgencyImportance(urgency, importance) => {
                    self.varies |= reads_variable(urgency)? | reads_variable(importance)?;
                    self.rising.push((task, clause));
                }
            }
        }
        Some(())
    }

    fn add_rank(&mut self, agent: &Agent, task: &Task, (step, kind): (&Step, ProcedureKind)) -> Option<()> {
        let by_kind = matches!(kind, ProcedureKind::Ranked | ProcedureKind::SoftSequential);
        if step.rank.is_none() && !by_kind {
            return Some(());
        }
        if !step.rank.as_ref().is_none_or(|expr| matches!(expr.kind, ExprKind::Constant(_))) {
            return None;
        }
        let rank = priority::rank(agent, task.id, agent.now)?;
        self.contradicts |= self.rank.is_some() || self.steady > 0 || !self.rising.is_empty();
        if self.rank.is_none() {
            self.rank = Some(RankAmong { parent: task.parent?, rank });
        }
        Some(())
    }

    /// Returns the place by priorities alone; `None` if one of them changes in another way than by its urgency.
    fn place(&self, cycle: &Cycle<'_>, id: TaskId) -> Option<QueuePlace> {
        let agent = &*cycle.agent;
        let (begun, order) = (has_begun(agent, id), order_of(agent, id));
        let steady = |priority| QueueKey { priority, rank: None, within: 0.0, begun, order };
        if self.rising.is_empty() {
            let priority = priority::priority(agent, id, cycle.now);
            return Some(QueuePlace { steady: Some(steady(priority)), rising: Vec::new() });
        }
        let (mut rising, mut greatest) = (Vec::new(), None);
        for (task, clause) in priority::clauses_that_count(agent, id) {
            match priority::kind(agent, task, clause, cycle.now) {
                PriorityChange::Absent => {}
                PriorityChange::Steady(value) => {
                    greatest = Some(greatest.map_or(value, |before: f64| before.max(value)))
                }
                PriorityChange::Rising(term) => {
                    let key = RisingKey { importance: term.importance, due: term.due, begun, order };
                    if !rising.contains(&key) {
                        rising.push(key);
                    }
                }
                PriorityChange::Other => return None,
            }
        }
        let least = rising.is_empty().then_some(0.0);
        Some(QueuePlace { steady: greatest.or(least).map(steady), rising })
    }
}

/// Returns the step that the task was made from, and the kind of its procedure.
fn template<'a>(agent: &'a Agent, task: &Task) -> Option<(&'a Step, ProcedureKind)> {
    let Origin::Step(step) = task.origin else { return None };
    let procedure = agent.procedure(step.procedure)?;
    Some((procedure.steps.get(step.step as usize)?, procedure.kind))
}

/// Returns true if no change of a variable or measurement can change the strength with which `id` defends the resource.
pub(crate) fn is_steady(agent: &Agent, id: TaskId) -> bool {
    let cost = priority::cost_clause(agent, id);
    let brings = Brings::of(agent, id);
    cost.is_none_or(|(expr, _)| matches!(expr.kind, ExprKind::Constant(_)))
        && brings.is_some_and(|brings| !brings.varies && brings.rising.is_empty() && !brings.contradicts)
}

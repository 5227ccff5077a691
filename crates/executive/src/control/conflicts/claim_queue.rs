//! Claims (TC)
//! What: finds the place of a claimant in the queue of what it needs, if its place follows from itself alone.
//! Runs: contend phase, when a task claims and when an input of its priority changed.
//! Reads: ResourceTable, priorities, ranks, ancestors.  Writes: nothing.
//! Bound: O(depth * needs).
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::competition::{has_begun, order_of};
use crate::control::conflicts::priority::{self, PriorityChange, reads_variable};
use crate::control::cycle::Cycle;
use crate::state::agent::Agent;
use crate::state::queue_place::{QueueKey, QueuePlace, RankAmong, RisingKey};
use crate::state::resource::Need;
use crate::state::resource_id::ResourceId;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, Task};
use crate::state::waiting::Claim;
use apex_model::expression::ExprKind;
use apex_model::procedure::{PriorityClause, ProcedureKind, Step};
use apex_model::task::{TaskId, TaskState};
use std::iter::successors;

/// Returns the claim of `id`, which needs `needs`.
pub(crate) fn claim_of(cycle: &Cycle<'_>, id: TaskId, needs: &[Need]) -> Claim {
    let agent = &*cycle.agent;
    let used_up = |need: &Need| agent.resources.get(need.resource).is_none_or(|resource| resource.depletable);
    if needs.iter().any(used_up) || shares_with_ancestors(agent, id, needs) {
        return Claim::Apart;
    }
    let by_rank = places_by_rank(agent, id);
    let (place, varies) = match place_of(cycle, id, needs) {
        Some((place, varies)) => (Some(place), varies),
        None if by_rank.is_empty() => return Claim::Apart,
        None => (None, true),
    };
    let expected = agent.task(id).and_then(|task| task.selection.as_ref()?.expected);
    // Each resource of a claimant with several needs keeps all of them; a claimant with one need keeps none.
    let others = if needs.len() > 1 { needs.iter().map(|need| need.resource).collect() } else { Vec::new() };
    let amount = needs.first().map_or(0.0, |need| need.amount);
    Claim::Queued { place, varies, expected, amount, others, by_rank }
}

/// Returns the places of the task among those below each ranked task above it, where ranks alone count.
fn places_by_rank(agent: &Agent, id: TaskId) -> Vec<QueueKey> {
    let (begun, order) = (has_begun(agent, id), order_of(agent, id));
    let ranks = fixed_ranks(agent, id);
    ranks.map(|rank| QueueKey { priority: 0.0, rank: Some(rank), begun, order }).collect()
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

/// Returns the place of the claimant in the queue, and whether variables may change it; `None` if the claimant must be compared with all
/// others.
fn place_of(cycle: &Cycle<'_>, id: TaskId, needs: &[Need]) -> Option<(QueuePlace, bool)> {
    let agent = &*cycle.agent;
    let brings = Brings::of(agent, id)?;
    let (begun, order) = (has_begun(agent, id), order_of(agent, id));
    if let Some((task, clause)) = brings.rising {
        let alone = brings.steady == 0 && brings.rank.is_none();
        let PriorityChange::Rising(term) = priority::kind(agent, task, clause, cycle.now) else { return None };
        let key = RisingKey { importance: term.importance, due: term.due, begun, order };
        return alone.then_some((QueuePlace::Rising(key), brings.varies));
    }
    // The order of a claimant with a rank and several needs can depend on claimants of other resources.
    if needs.len() > 1 && brings.rank.is_some() {
        return None;
    }
    let priority = priority::priority(agent, id, cycle.now);
    Some((QueuePlace::Steady(QueueKey { priority, rank: brings.rank, begun, order }), brings.varies))
}

/// Does an ancestor need one of the same resources? Families share, which is not a matter of turns.
fn shares_with_ancestors(agent: &Agent, id: TaskId, needs: &[Need]) -> bool {
    let wants = |id: ResourceId| needs.iter().any(|need| need.resource == id);
    successors(agent.task(id), |task| agent.task(task.parent?)).skip(1).any(|above| {
        let profile = above.selection.iter().flat_map(|selection| &selection.needs);
        let held = above.extras.iter().flat_map(|extras| &extras.held);
        profile.chain(held).any(|need| wants(need.resource))
    })
}

/// Properties of a task and its ancestors in a conflict.
#[derive(Default)]
struct Brings<'a> {
    /// The only clause whose priority rises by urgency.
    rising: Option<(&'a Task, &'a PriorityClause)>,
    /// The number of other clauses.
    steady: usize,
    /// Variables may change a priority.
    varies: bool,
    /// The only rank.
    rank: Option<RankAmong>,
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
                brings.steady += 1;
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
                    if self.rising.replace((task, clause)).is_some() {
                        return None;
                    }
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
        // A rank can contradict the priorities below it, and two ranks can contradict one another.
        let fixed = step.rank.as_ref().is_none_or(|expr| matches!(expr.kind, ExprKind::Constant(_)));
        if self.rank.is_some() || self.steady > 0 || self.rising.is_some() || !fixed {
            return None;
        }
        let rank = priority::rank(agent, task.id, agent.now)?;
        self.rank = Some(RankAmong { parent: task.parent?, rank });
        Some(())
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
        && brings.is_some_and(|brings| !brings.varies && brings.rising.is_none())
}

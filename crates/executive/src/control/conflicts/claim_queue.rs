//! Claim queue (TC)
//! What: arbitrates only the first claimant of a resource if all claimants differ in priority alone.
//! Runs: contend phase, before conflict resolution, which handles all other claims.
//! Reads: ResourceTable, priorities, ancestors.  Writes: nothing.
//! Bound: O(log c + depth) for c queued claimants, plus O(new claimants).
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::arbitration::{Arbitration, Refusal, Rival};
use crate::control::conflicts::competition::{as_claimant, has_begun, is_eligible, order_of};
use crate::control::conflicts::conflict::{Field, left_behind};
use crate::control::conflicts::priority;
use crate::control::conflicts::sharing::{Use, UseKind};
use crate::control::cycle::Cycle;
use crate::state::agent::Agent;
use crate::state::resource::{Need, ResourceId};
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, Task};
use crate::state::waiting::{Claim, QueueKey, Waiting};
use apex_model::expression::ExprKind;
use apex_model::procedure::{PriorityClause, ProcedureKind};
use apex_model::task::TaskId;
use std::rc::Rc;

/// Descendants looked at to see whether one of them waits too; a task with more is left to conflict resolution.
const FAMILY_MAX: usize = 64;

/// How `id`, which needs `needs`, waits for one of them.
pub(crate) fn claim_of(cycle: &Cycle<'_>, id: TaskId, needs: &[Need]) -> Claim {
    let agent = &*cycle.agent;
    let whole = match needs {
        [one] => agent.resources.get(one.resource).is_some_and(|resource| one.amount >= resource.total),
        _ => false,
    };
    let estimated = agent.task(id).and_then(|task| task.selection.as_ref()?.expected).is_some();
    if !whole || estimated {
        return Claim::Apart;
    }
    let mut varies = false;
    let mut next = agent.task(id);
    while let Some(task) = next {
        match steadiness(agent, task) {
            Some(own) => varies |= own,
            None => return Claim::Apart,
        }
        next = task.parent.and_then(|parent| agent.task(parent));
    }
    let turn = QueueKey {
        priority: priority::priority(agent, id, cycle.now),
        begun: has_begun(agent, id),
        order: order_of(agent, id),
    };
    Claim::Queued { turn, varies }
}

/// What the task brings to a conflict: nothing that moves by itself and no rank. True when variables may change it.
fn steadiness(agent: &Agent, task: &Task) -> Option<bool> {
    if !task.clauses.has(StepClauses::CONTENTION) && !task.clauses.has(StepClauses::RANK) {
        return Some(false);
    }
    let Some(step) = task.step().filter(|_| matches!(task.origin, Origin::Step(_))) else { return Some(false) };
    let procedure = agent.procedure(step.procedure)?;
    let template = procedure.steps.get(step.step as usize)?;
    let ranked = matches!(procedure.kind, ProcedureKind::Ranked | ProcedureKind::SoftSequential);
    let recovers = template.repeating.as_ref().is_some_and(|repetition| repetition.recovery.is_some());
    if ranked || template.rank.is_some() || (recovers && !template.priority.is_empty()) {
        return None;
    }
    let mut varies = false;
    for clause in &template.priority {
        match clause {
            PriorityClause::Number(expr) => match expr.kind {
                ExprKind::Constant(_) => {}
                ExprKind::Variable { .. } => varies = true,
                _ => return None,
            },
            PriorityClause::UrgencyImportance(..) => return None,
        }
    }
    Some(varies)
}

/// Can no change of a variable, and nothing that is measured, change what `id` defends the resource with?
pub(crate) fn is_steady(agent: &Agent, id: TaskId) -> bool {
    let mut family = std::iter::successors(agent.task(id), |task| agent.task(task.parent?));
    let cost = priority::cost_clause(agent, id);
    cost.is_none_or(|(expr, _)| matches!(expr.kind, ExprKind::Constant(_)))
        && family.all(|task| steadiness(agent, task) == Some(false))
}

/// Arbitrates the resource, if its first claimant decides for all. `fresh` claim it since this round.
pub(crate) fn first_decides(cycle: &Cycle<'_>, id: ResourceId, fresh: &[TaskId]) -> Option<Arbitration> {
    let agent = &*cycle.agent;
    let resource = agent.resources.get(id)?;
    let waiting = &resource.waiting;
    if resource.depletable || !waiting.all_in_line() {
        return None;
    }
    let holder = match resource.holders.as_slice() {
        [] => None,
        [one] if one.amount >= resource.total && holds_only_this(cycle, one.task) => Some(one.task),
        _ => return None,
    };
    let mut result = Arbitration::default();
    let Some(first) = waiting.queue().map(QueueKey::task).find(|task| is_eligible(agent, *task)) else {
        return Some(result);
    };
    if holder.into_iter().chain([first]).any(|task| family_waits(agent, waiting, task)) {
        return None;
    }
    let field = Field::empty(cycle);
    let used_by = |task, kind| Use { task, amount: resource.total, kind };
    let mut winner = used_by(first, UseKind::Granted);
    match holder.map(|holder| used_by(holder, UseKind::Held)) {
        None => result.granted.push(first),
        Some(holder) => match field.confront(&as_claimant(cycle, first), id, &holder) {
            Ok(loss) => {
                result.displaced.push(loss);
                result.granted.push(first);
                if left_behind(cycle, &result).any(|left| left != id) {
                    return None;
                }
            }
            Err(loss) => {
                let in_the_way = Rival { task: holder.task, holds: true, stands_for: Rc::new([holder.task]) };
                result.refused.push(Refusal { loss, stands_for: Rc::new([first]), rivals: vec![in_the_way] });
                winner = holder;
            }
        },
    }
    for task in fresh.iter().filter(|task| **task != first) {
        let loss = field.confront(&as_claimant(cycle, *task), id, &winner).err()?;
        // Nobody behind the first can overtake the holder before the first does.
        result.refused.push(Refusal { loss, stands_for: Rc::new([*task]), rivals: Vec::new() });
    }
    Some(result)
}

fn holds_only_this(cycle: &Cycle<'_>, id: TaskId) -> bool {
    crate::control::conflicts::resources::needs_of(cycle, id).len() == 1
}

/// Does an ancestor or a descendant of the task wait for the same? Families share, which is no matter of turns.
fn family_waits(agent: &Agent, waiting: &Waiting, id: TaskId) -> bool {
    let mut above = std::iter::successors(agent.task(id), |task| agent.task(task.parent?)).skip(1);
    if above.any(|task| waiting.contains(task.id)) {
        return true;
    }
    let children = |id: TaskId| {
        let controller = agent.task(id).and_then(|task| task.controller.as_deref());
        controller.filter(|controller| controller.has_children()).map(|controller| controller.children())
    };
    let mut open = children(id).unwrap_or_default();
    let mut seen = 0;
    while let Some(next) = open.pop() {
        seen += 1;
        if seen > FAMILY_MAX || waiting.contains(next) {
            return true;
        }
        open.extend(children(next).unwrap_or_default());
    }
    false
}

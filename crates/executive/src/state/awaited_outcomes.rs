//! Outcomes of steps that the clauses of a procedure name, for example `(failed ?s)`, and the steps that wait for them.

use apex_forms::variables::of_pattern;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::ExprKind;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Procedure, Step, Transitions};
use apex_model::symbol::Symbol;
use apex_model::task::{FAILURE_STATES, OUTCOME_STATES, TaskId};
use apex_model::value::Value;

/// Returns tag and outcome of a condition such as `(failed ?tag)`, stored as `(state ?tag = failed)`; `None` for other conditions.
fn outcome_named(condition: &Condition) -> Option<(&Symbol, &Symbol)> {
    let ConditionKind::TaskState { task, state: Pattern::Literal(Value::Symbol(word)) } = &condition.kind else {
        return None;
    };
    match &task.kind {
        ExprKind::Variable { name, .. } if OUTCOME_STATES.contains(&word.folded()) => Some((name, word)),
        _ => None,
    }
}

/// Returns true if `condition`, or a part of it, names an outcome of step `tag` for which `is_meant` is true.
fn names(condition: &Condition, tag: &Symbol, is_meant: &dyn Fn(&Symbol) -> bool) -> bool {
    if let Some((name, word)) = outcome_named(condition) {
        return name == tag && is_meant(word);
    }
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().any(|part| names(part, tag, is_meant))
        }
        ConditionKind::Allen { parts, .. } => parts.iter().any(|part| names(part, tag, is_meant)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => names(part, tag, is_meant),
        ConditionKind::Probing { condition, .. } => names(condition, tag, is_meant),
        _ => false,
    }
}

fn conditions(clauses: &Transitions) -> impl Iterator<Item = &Condition> {
    let Transitions {
        end_when,
        restart_when,
        resume_when,
        suspend_when,
        suspend_until,
        skip_when,
        exit_when,
        precondition,
        invariant,
    } = clauses;
    let ends = [end_when, restart_when, resume_when, suspend_when, suspend_until];
    let others = [skip_when, exit_when, precondition, invariant];
    ends.into_iter().chain(others).filter_map(|condition| condition.as_deref())
}

/// Returns true if a clause of the procedure or of another step names the failure of step `number`.
pub(crate) fn is_failure_awaited(procedure: &Procedure, number: usize) -> bool {
    let Some(tag) = procedure.steps.get(number).map(|step| &step.tag) else { return false };
    let is_meant = |word: &Symbol| FAILURE_STATES.contains(&word.folded());
    let of_step = |step: &Step| {
        step.tag != *tag
            && step.waitfor.iter().chain(conditions(&step.transitions)).any(|each| names(each, tag, &is_meant))
    };
    conditions(&procedure.transitions).any(|each| names(each, tag, &is_meant)) || procedure.steps.iter().any(of_step)
}

/// Returns the steps whose `waitfor` names an outcome of step `number`.
pub(crate) fn waiters(procedure: &Procedure, number: usize) -> Vec<u32> {
    let Some(tag) = procedure.steps.get(number).map(|step| &step.tag) else { return Vec::new() };
    let waits = |step: &Step| step.tag != *tag && step.waitfor.iter().any(|each| names(each, tag, &|_| true));
    (0_u32..).zip(&procedure.steps).filter(|(_, step)| waits(step)).map(|(number, _)| number).collect()
}

/// Returns the variables that the step's `=>` binds.
pub(crate) fn produced(step: &Step) -> Vec<Symbol> {
    let mut names = Vec::new();
    step.binds.iter().for_each(|pattern| of_pattern(pattern, &mut |name| names.push(name.clone())));
    names
}

/// A task that has ended for good, with the words of its outcome.
pub(crate) type EndedStep = (TaskId, &'static [&'static str]);

/// Returns the reason for which `condition` can never hold: a task that has ended, and the required outcome that it did not have.
/// `outcome_of` returns task and outcome of the step with a tag, once that step has ended finally.
pub(crate) fn missed(
    condition: &Condition,
    outcome_of: &dyn Fn(&Symbol) -> Option<EndedStep>,
) -> Option<(TaskId, Symbol)> {
    if let Some((tag, word)) = outcome_named(condition) {
        let (task, states) = outcome_of(tag)?;
        return (!states.contains(&word.folded())).then(|| (task, word.clone()));
    }
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().find_map(|part| missed(part, outcome_of))
        }
        ConditionKind::Or(parts, _) => {
            let mut why = parts.iter().map(|part| missed(part, outcome_of));
            let first = why.next()??;
            why.all(|each| each.is_some()).then_some(first)
        }
        _ => None,
    }
}

//! Outcomes of steps that the clauses of a procedure name, for example `(failed ?s)`, and the steps that wait for them.

use apex_forms::variables::of_pattern;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::ExprKind;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Procedure, Step, Transitions};
use apex_model::symbol::Symbol;
use apex_model::task::{FAILURE_STATES, OUTCOME_STATES, TaskId};
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

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

/// Visits tag and word of each outcome of a step that `condition`, or a part of it, names.
fn names<'p>(condition: &'p Condition, visit: &mut dyn FnMut(&'p Symbol, &'p Symbol)) {
    if let Some((tag, word)) = outcome_named(condition) {
        return visit(tag, word);
    }
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| names(part, visit));
        }
        ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| names(part, visit)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => names(part, visit),
        ConditionKind::Probing { condition, .. } => names(condition, visit),
        _ => {}
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

/// Outcomes that the clauses of one procedure name, by the tag of the step. Bound: O(conditions), once for all steps.
#[derive(Default)]
pub(crate) struct AwaitedOutcomes<'p> {
    /// Steps of which a clause of the procedure or of another step names the failure.
    failures: BTreeSet<&'p Symbol>,
    /// Steps whose `waitfor` names an outcome.
    waiters: BTreeMap<&'p Symbol, Vec<u32>>,
}

impl<'p> AwaitedOutcomes<'p> {
    /// Returns the outcomes that `procedure` names.
    pub(crate) fn new(procedure: &'p Procedure) -> AwaitedOutcomes<'p> {
        let mut awaited = AwaitedOutcomes::default();
        conditions(&procedure.transitions).for_each(|condition| awaited.note_failures(condition, None));
        for (number, step) in (0_u32..).zip(&procedure.steps) {
            let all = step.waitfor.iter().chain(conditions(&step.transitions));
            all.for_each(|condition| awaited.note_failures(condition, Some(&step.tag)));
            for condition in &step.waitfor {
                names(condition, &mut |tag, _| {
                    let waiters = awaited.waiters.entry(tag).or_default();
                    if *tag != step.tag && waiters.last() != Some(&number) {
                        waiters.push(number);
                    }
                });
            }
        }
        awaited
    }

    /// Notes the steps whose failure `condition` names, except the step `own` that it belongs to.
    fn note_failures(&mut self, condition: &'p Condition, own: Option<&Symbol>) {
        names(condition, &mut |tag, word| {
            if own != Some(tag) && FAILURE_STATES.contains(&word.folded()) {
                self.failures.insert(tag);
            }
        });
    }

    /// Returns true if a clause of the procedure or of another step names the failure of step `tag`.
    pub(crate) fn is_failure_of(&self, tag: &Symbol) -> bool {
        self.failures.contains(tag)
    }

    /// Returns the steps whose `waitfor` names an outcome of step `tag`, in written order.
    pub(crate) fn waiters_for(&self, tag: &Symbol) -> Vec<u32> {
        self.waiters.get(tag).cloned().unwrap_or_default()
    }
}

/// Returns the variables that the step's `=>` binds.
pub(crate) fn produced(step: &Step) -> Vec<Symbol> {
    let mut names = Vec::new();
    step.binds.iter().for_each(|pattern| of_pattern(pattern, &mut |name| names.push(name.clone())));
    names
}

/// A task that has ended finally, with the words of its outcome.
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

//! Falsified causes, which the checker must notice.

use super::because_of;
use super::step::Step;
use apex_model::because::{Because, Cause, Evidence};
use apex_model::effect::Effect;
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};

/// A way of falsifying a cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Spoiling {
    /// Another kind of cause that occurs elsewhere in the same record.
    Swap,
    /// The same kind with another task, number or instant.
    Shift,
}

/// Returns the steps with one cause falsified; `None` if that is impossible in this way.
pub fn spoiled(steps: &[Step], at: (usize, usize), how: Spoiling) -> Option<Vec<Step>> {
    let because = because_of(steps.get(at.0)?.effects.get(at.1)?)?;
    let wrong = match how {
        Spoiling::Swap => swapped(steps, because)?,
        Spoiling::Shift => shifted(because)?,
    };
    let mut steps = steps.to_vec();
    match steps.get_mut(at.0)?.effects.get_mut(at.1)? {
        Effect::Decided(decision) => decision.because = wrong,
        Effect::Command { because, .. } => *because = wrong,
        _ => return None,
    }
    Some(steps)
}

/// Returns the next cause in the record that is of another kind.
fn swapped(steps: &[Step], because: &Because) -> Option<Because> {
    let own = because.cause.kind();
    let all = steps.iter().flat_map(|step| &step.effects).filter_map(because_of);
    let other = all.map(|other| &other.cause).find(|other| other.kind() != own)?;
    Some(Because { cause: other.clone(), ..because.clone() })
}

fn far(task: TaskId) -> TaskId {
    TaskId(task.0 + 10_000)
}

fn later(at: Time) -> Time {
    at + Duration(1)
}

fn shifted(because: &Because) -> Option<Because> {
    let mut wrong = because.clone();
    if !because.evidence.is_empty() {
        wrong.evidence = because.evidence.iter().map(shifted_evidence).collect();
        return Some(wrong);
    }
    match &mut wrong.cause {
        Cause::ParentStarted { parent: task }
        | Cause::PlanPursued { parent: task }
        | Cause::PlanBegunAgain { parent: task }
        | Cause::ItemOf { parent: task }
        | Cause::Meanwhile { parent: task }
        | Cause::Probes { waiting: task, .. }
        | Cause::ProbingStopped { waiting: task, .. }
        | Cause::HandlesFailure { of: task }
        | Cause::Responding { answered: task }
        | Cause::PredecessorEnded { predecessor: task }
        | Cause::Outranked { by: task, .. }
        | Cause::AncestorSuspended { ancestor: task }
        | Cause::AncestorResumed { ancestor: task }
        | Cause::Activity { by: task, .. }
        | Cause::StepsEnded { last: Some(task) }
        | Cause::ItemsEnded { last: Some(task), .. }
        | Cause::ParentEnded { parent: task }
        | Cause::ParentRestarted { parent: task }
        | Cause::ParentFailed { parent: task }
        | Cause::ChildFailed { child: task }
        | Cause::FailureHandled { by: task }
        | Cause::HandlerEnded { handler: task }
        | Cause::ApplicationEnded { by: task } => *task = far(*task),
        Cause::DurationElapsed { duration }
        | Cause::CommandTimedOut { patience: duration, .. }
        | Cause::SolverTimedOut { patience: duration, .. } => *duration = *duration + Duration(1),
        Cause::CommandAcknowledged { command } | Cause::CommandFailed { command, .. } => command.0 += 10_000,
        Cause::PlanArrived { request, .. } | Cause::SolverFailed { request, .. } => request.0 += 10_000,
        Cause::OperatorAnswered { question, .. }
        | Cause::OperatorSilent { question, .. }
        | Cause::OperatorMute { question } => question.0 += 10_000,
        Cause::MostSpecific { candidates: number }
        | Cause::FirstOfEquals { equals: number, .. }
        | Cause::ForAll { items: number }
        | Cause::LimitReached { value: number, .. } => *number += 7,
        Cause::ResourceExhausted { needed, left, .. } => std::mem::swap(needed, left),
        Cause::BuiltInDone { activity } | Cause::BuiltIn { activity } => activity.to_mut().push('x'),
        Cause::ConditionSatisfied { clause } | Cause::Binding { clause } => clause.to_mut().push('x'),
        Cause::ResultArrived { variable } => *variable = apex_model::symbol::Symbol::new("no-form-binds-this"),
        _ => return None,
    }
    Some(wrong)
}

fn shifted_evidence(evidence: &Evidence) -> Evidence {
    let mut wrong = evidence.clone();
    match &mut wrong {
        Evidence::Sample { at, .. }
        | Evidence::Event { at, .. }
        | Evidence::TaskState { at, .. }
        | Evidence::TaskEnd { at, .. }
        | Evidence::Run { end: at, .. }
        | Evidence::Instant { at, .. }
        | Evidence::Function { at, .. }
        | Evidence::Absence { at, .. } => *at = later(*at),
        Evidence::Estimate(estimate) => estimate.extent.0 = later(estimate.extent.0),
        Evidence::Aggregate(aggregate) => aggregate.interval.1 = later(aggregate.interval.1),
    }
    wrong
}

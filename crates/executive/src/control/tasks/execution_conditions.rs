//! Execution conditions (TC)
//! What: judges `precondition` when a task is to begin, and `invariant` while it is ongoing; the task fails if one does not hold.
//! Runs: choose and act phases (precondition); enable phase after a change of samples or task states that an invariant reads.
//! Reads: Transitions, histories, Task.  Writes: Task, Decision.
//! Bound: one judgement for each task with an invariant that a sample concerns.
//! PDL: `precondition`, `invariant`.  Paper: section III, off-nominal conditions.

use crate::control::cycle::Cycle;
use crate::control::tasks::termination;
use crate::monitoring::basic::present::{self, Present};
use crate::monitoring::stimulus::Stimulus;
use crate::state::clause::Level;
use crate::state::controller::MethodBinding;
use crate::state::guards::Reads;
use crate::state::step_clauses::StepClauses;
use crate::state::task::Origin;
use apex_model::because::{Because, Cause};
use apex_model::condition::Condition;
use apex_model::procedure::Transitions;
use apex_model::task::{Outcome, TaskId, TaskState};

/// The kind of the judged clause.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ExecutionClause {
    Precondition,
    Invariant,
}

impl ExecutionClause {
    fn of(self, clauses: &Transitions) -> Option<&Condition> {
        match self {
            ExecutionClause::Precondition => clauses.precondition.as_deref(),
            ExecutionClause::Invariant => clauses.invariant.as_deref(),
        }
    }

    fn outcome(self) -> Outcome {
        match self {
            ExecutionClause::Precondition => Outcome::PreconditionFailed,
            ExecutionClause::Invariant => Outcome::InvariantViolated,
        }
    }

    fn word(self) -> &'static str {
        match self {
            ExecutionClause::Precondition => "precondition",
            ExecutionClause::Invariant => "invariant",
        }
    }
}

/// Returns true if the preconditions of the step and of the chosen procedure hold; otherwise the task fails.
pub(crate) fn allow(cycle: &mut Cycle<'_>, id: TaskId) -> bool {
    hold(cycle, id, ExecutionClause::Precondition)
}

/// Checks preconditions and invariants as the task begins, and watches the invariants from now on. Returns false if one does not hold;
/// the task then fails.
pub(crate) fn begin(cycle: &mut Cycle<'_>, id: TaskId) -> bool {
    if !hold(cycle, id, ExecutionClause::Precondition) {
        return false;
    }
    let invariants = conditions(cycle, id, ExecutionClause::Invariant);
    if !invariants.is_empty() {
        let mut reads = Reads::default();
        invariants.iter().for_each(|(condition, _)| present::add_reads(condition, &mut reads));
        cycle.agent.guards.insert(id, reads);
    }
    hold(cycle, id, ExecutionClause::Invariant)
}

/// Checks the invariants as the task continues after an interruption. Returns false if one does not hold; the task then fails.
pub(crate) fn go_on(cycle: &mut Cycle<'_>, id: TaskId) -> bool {
    !cycle.agent.guards.contains(id) || hold(cycle, id, ExecutionClause::Invariant)
}

/// Notes the tasks whose invariants may be affected by the events of this round.
pub(crate) fn notice(cycle: &mut Cycle<'_>) {
    cycle.work.states_changed = false;
    if cycle.agent.guards.is_empty() {
        return;
    }
    let concerned: Vec<TaskId> = concerned(cycle).collect();
    cycle.work.doubtful.extend(concerned);
}

/// Returns true if the stimuli concern an invariant: then the instant is not quiet.
pub(crate) fn concern(cycle: &Cycle<'_>) -> bool {
    concerned(cycle).next().is_some()
}

fn concerned<'a>(cycle: &'a Cycle<'_>) -> impl Iterator<Item = TaskId> + 'a {
    let by_sample = |stimulus: &'a Stimulus| match stimulus {
        Stimulus::Sample { variable, .. } => Some(cycle.agent.guards.concerned_by(&variable.attribute)),
        _ => None,
    };
    cycle.agent.guards.restless().chain(cycle.work.stimuli.iter().filter_map(by_sample).flatten())
}

/// Judges the invariants that may no longer hold, ancestors first.
pub(crate) fn judge_invariants(cycle: &mut Cycle<'_>) {
    for id in std::mem::take(&mut cycle.work.doubtful) {
        // A task that may start over is judged when it continues.
        let works = cycle.state(id) == TaskState::Ongoing && !cycle.work.resuming.contains(&id);
        if works && cycle.agent.guards.contains(id) {
            hold(cycle, id, ExecutionClause::Invariant);
            termination::settle(cycle);
        }
    }
}

/// Judges the clauses of this kind; returns true if all hold, otherwise the task fails. An unknown precondition does not hold; an unknown
/// invariant is not violated.
fn hold(cycle: &mut Cycle<'_>, id: TaskId, wanted: ExecutionClause) -> bool {
    for (condition, level) in conditions(cycle, id, wanted) {
        let because = match present::judge(&condition, &cycle.view(id, level)) {
            Ok(Present { truth: Some(true), .. }) => continue,
            Ok(Present { truth: None, .. }) if wanted == ExecutionClause::Invariant => continue,
            Ok(Present { evidence, .. }) => {
                let cause = Cause::ConditionViolated { clause: wanted.word().into() };
                Because { cause, place: Some(condition.place), evidence }
            }
            Err(error) => Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place)),
        };
        let outcome = match because.cause {
            Cause::ExpressionFailed { .. } => Outcome::Failure,
            _ => wanted.outcome(),
        };
        termination::fail_as(cycle, id, outcome, because);
        return false;
    }
    true
}

/// Returns the task's clauses of this kind: those of its step, then those of the chosen procedure.
fn conditions(cycle: &Cycle<'_>, id: TaskId, wanted: ExecutionClause) -> Vec<(Condition, Level)> {
    let mut all = Vec::new();
    let Some(task) = cycle.task(id) else { return all };
    if task.clauses.has(StepClauses::EXECUTION)
        && matches!(task.origin, Origin::Step(_))
        && let Some(handle) = cycle.step_of(id)
    {
        let own = handle.get().and_then(|step| wanted.of(&step.transitions));
        all.extend(own.map(|condition| (condition.clone(), Level::Step)));
    }
    if let Some(MethodBinding::Procedure(reference, _)) = task.selection.as_ref().map(|selection| &selection.way) {
        let inner = cycle.agent.procedure(*reference).and_then(|procedure| wanted.of(&procedure.transitions));
        all.extend(inner.map(|condition| (condition.clone(), Level::Procedure)));
    }
    all
}

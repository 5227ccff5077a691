//! Subtask instantiation (TC)
//! What: makes tasks from steps, items, failure handlers and the initial goal, and arms their preconditions.
//! Runs: act phase, and when a step repeats or responds.  Reads: Procedure, context.  Writes: Task, Decision, monitors.
//! Bound: O(1) per task, plus the search of histories.  PDL: sections 3 and 4.  Paper: section III.

use crate::control::cycle::Cycle;
use crate::control::memory_budget;
use crate::control::tasks::goal::goal_as_known;
use crate::control::tasks::{interruption, monitoring_clauses, repetition, termination};
use crate::expression::EvalContext;
use crate::state::bindings::Bindings;
use crate::state::clause::{Clause, Level};
use crate::state::index::StepIndex;
use crate::state::monitors::monitor::Window;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{HeldBack, Origin, Task};
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause};
use apex_model::effect::DecisionKind;
use apex_model::procedure::Transitions;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use smallvec::SmallVec;

/// Input for a new task.
pub(crate) struct Seed {
    /// The parent task; `None` for the root.
    pub(crate) parent: Option<TaskId>,
    /// Its template.
    pub(crate) origin: Origin,
    /// Its own variables.
    pub(crate) bindings: Bindings,
    /// True if a preceding step of the sequence has not ended.
    pub(crate) by_predecessor: bool,
    /// Arrivals up to this number do not count as evidence for the task.
    pub(crate) after_sequence: Option<u64>,
    /// Cause.
    pub(crate) cause: Cause,
}

/// Creates a pending task. [`arm`] arms its preconditions when its siblings exist too.
///
/// # Errors
/// The cause, when a limit on tasks is reached.
pub(crate) fn create(cycle: &mut Cycle<'_>, seed: Seed) -> Result<TaskId, Cause> {
    let depth = seed.parent.and_then(|parent| cycle.task(parent)).map_or(0, |parent| parent.depth + 1);
    room(cycle, seed.origin, depth)?;
    let id = TaskId(cycle.agent.next.task);
    cycle.agent.next.task += 1;
    let task = Task {
        id,
        parent: seed.parent,
        origin: seed.origin,
        state: TaskState::Pending,
        depth,
        held_back: HeldBack { by_predecessor: seed.by_predecessor, ..HeldBack::default() },
        suspended: false,
        created_at: cycle.now,
        since: cycle.now,
        started_at: None,
        after_sequence: seed.after_sequence,
        bindings: seed.bindings,
        monitors: SmallVec::new(),
        selection: None,
        controller: None,
        outcome: None,
        clauses: cycle.agent.clauses_of(seed.origin),
        extras: None,
    };
    let tag = cycle.agent.tag(&task);
    cycle.agent.tasks.insert(id.0, task);
    let (goal, place) = (goal_as_known(cycle, id), cycle.place_of(id));
    let kind = DecisionKind::Created { parent: seed.parent, tag, goal, place };
    cycle.decide(Some(id), kind, Because::new(seed.cause, place));
    Ok(id)
}

/// Checks that the limits admit one more task at this depth. A failure handler is always admitted: it replaces the failed work, and each
/// task has at most one.
fn room(cycle: &mut Cycle<'_>, origin: Origin, depth: u32) -> Result<(), Cause> {
    let limits = &cycle.agent.limits;
    if matches!(origin, Origin::OnFailure(_)) {
        return Ok(());
    }
    if u64::from(depth) > limits.of(Limit::TaskDepth) {
        return Err(limits.reached(Limit::TaskDepth));
    }
    if cycle.agent.tasks.len() >= limits.count(Limit::Tasks) {
        return Err(limits.reached(Limit::Tasks));
    }
    memory_budget::room_for_task(cycle)
}

/// Returns the window of evidence that counts for the task's present instance.
pub(crate) fn window(task: &Task) -> Window {
    Window { start: task.created_at, after_sequence: task.after_sequence }
}

/// Arms the preconditions of a pending task. It becomes ready at once if nothing holds it back.
pub(crate) fn arm(cycle: &mut Cycle<'_>, id: TaskId) {
    if let Some(Origin::Step(_)) = cycle.task(id).map(|task| task.origin) {
        let by_result = awaited(cycle, id, |index| &index.awaits).is_some();
        let by_unknown = by_result && awaited(cycle, id, |index| &index.condition_awaits).is_some();
        if let Some(task) = cycle.agent.task_mut(id) {
            task.held_back.by_result = by_result;
            task.held_back.by_unknown = by_unknown;
        }
        // A task that needs the result only for its work watches from the beginning: earlier events count too.
        let armed = watch_end(cycle, id);
        let armed = armed.and_then(|()| if by_unknown { Ok(()) } else { watch_preconditions(cycle, id) });
        let armed = armed
            .map_err(|(message, place)| Because::new(Cause::ExpressionFailed { message }, Some(place)))
            .and_then(|()| interruption::watch_step_suspension(cycle, id));
        if let Err(because) = armed {
            termination::fail(cycle, id, because);
            return;
        }
    }
    offer(cycle, id);
}

/// Puts a pending task that nothing holds back on the list of ready tasks.
pub(crate) fn offer(cycle: &mut Cycle<'_>, id: TaskId) {
    if cycle.task(id).is_some_and(|task| task.state == TaskState::Pending && task.held_back.is_free()) {
        cycle.work.ready.push(id);
    }
}

/// Returns the first result of another step that the task needs and that does not exist yet.
fn awaited(cycle: &Cycle<'_>, id: TaskId, which: impl Fn(&StepIndex) -> &Vec<Symbol>) -> Option<Symbol> {
    if !cycle.has(id, StepClauses::AWAITS) {
        return None;
    }
    let step = cycle.task(id)?.step()?;
    let index = cycle.agent.procedure_index(step.procedure)?;
    let awaits = which(index.steps.get(step.step as usize)?);
    if awaits.is_empty() {
        return None;
    }
    let view = cycle.view(id, Level::Step);
    awaits.iter().find(|name| view.variable(name).is_none()).cloned()
}

/// Makes the monitor of the task's `waitfor`.
fn watch_preconditions(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), (String, Place)> {
    let Some(task) = cycle.task(id).filter(|task| task.clauses.has(StepClauses::WAITFOR)) else { return Ok(()) };
    let window = window(task);
    let condition = task.step().and_then(|step| {
        let index = cycle.agent.procedure_index(step.procedure)?;
        index.steps.get(step.step as usize)?.waitfor.clone()
    });
    let Some(condition) = condition else { return Ok(()) };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.held_back.by_condition = true;
    }
    monitoring_clauses::watch(cycle, id, Clause::Waitfor, Level::Step, &condition, window, true)
        .map(|monitor| repetition::give_waiting_messages(cycle, id, monitor))
        .map_err(|error| (error.message, error.place))
}

/// Makes the monitors of the step's own `end-when` and `exit-when`, which can end the task in any state, and of its
/// `skip-when`.
fn watch_end(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), (String, Place)> {
    let Some(task) = cycle.task(id).filter(|task| task.clauses.has(StepClauses::TRANSITIONS)) else { return Ok(()) };
    let window = window(task);
    let Some(handle) = cycle.step_of(id) else { return Ok(()) };
    let Some(Transitions { end_when, exit_when, skip_when, .. }) = handle.get().map(|step| &step.transitions) else {
        return Ok(());
    };
    let clauses = [(Clause::EndWhen, end_when), (Clause::ExitWhen, exit_when), (Clause::SkipWhen, skip_when)];
    for (clause, condition) in clauses {
        if let Some(condition) = condition {
            monitoring_clauses::watch(cycle, id, clause, Level::Step, condition, window, true)
                .map_err(|error| (error.message, error.place))?;
        }
    }
    Ok(())
}

/// Handles a result in the context of `parent`: steps that waited for it get their monitors.
pub(crate) fn result_arrived(cycle: &mut Cycle<'_>, waiting: Vec<TaskId>, variable: &Symbol) {
    for id in waiting {
        let Some(task) = cycle.agent.task(id).filter(|task| task.state == TaskState::Pending) else { continue };
        let (by_result, by_unknown) = (task.held_back.by_result, task.held_back.by_unknown);
        let still_by_result = by_result && awaited(cycle, id, |index| &index.awaits).is_some();
        let still_by_unknown = by_unknown && awaited(cycle, id, |index| &index.condition_awaits).is_some();
        if let Some(task) = cycle.agent.task_mut(id) {
            task.held_back.by_result = still_by_result;
            task.held_back.by_unknown = still_by_unknown;
        }
        let watched = if by_unknown && !still_by_unknown { watch_preconditions(cycle, id) } else { Ok(()) };
        match watched {
            Ok(()) => {
                if by_result && cycle.task(id).is_some_and(|task| task.held_back.is_free()) {
                    cycle.work.freed.insert(id, Cause::ResultArrived { variable: variable.clone() });
                    offer(cycle, id);
                }
            }
            Err((message, place)) => {
                termination::fail(cycle, id, Because::new(Cause::ExpressionFailed { message }, Some(place)));
            }
        }
    }
}

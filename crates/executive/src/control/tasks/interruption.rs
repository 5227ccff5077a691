//! Task interruption and resumption (TC)
//! What: stops a task that lost a resource, suspends and resumes whole subtrees, and watches the clauses that request this.
//! Runs: enable, commit and act phases.  Reads: Transitions, Task.  Writes: Task state, ResourceTable, monitors.
//! Bound: O(1) for a lost resource; O(size of the subtree) for a suspension.
//! PDL: `suspend-when`, `resume-when`, `restart-when`, `end-when`, section 9.  Paper: section III, interruptions.

use crate::control::conflicts::resources;
use crate::control::cycle::Cycle;
use crate::control::tasks::{hooks, monitoring_clauses, primitive, question, termination};
use crate::control::transition::{Trigger, transition};
use crate::expression::EvalContext;
use crate::state::clause::{Clause, Level, MonitorId};
use crate::state::controller::{Controller, MethodBinding};
use crate::state::monitors::monitor::Window;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, ProcedureRef, Task};
use apex_forms::variables::of_condition;
use apex_model::because::{Because, Cause};
use apex_model::condition::Condition;
use apex_model::evidence_list::EvidenceList;
use apex_model::procedure::{Hooks, Transitions};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;

/// Interrupts a task that lost a resource. Its subtasks are not interrupted by this, and the task claims the resource again.
pub(crate) fn outrank(cycle: &mut Cycle<'_>, id: TaskId, because: Because) {
    stop(cycle, id, Trigger::Outranked, because);
    cycle.work.claims.push(id);
}

fn stop(cycle: &mut Cycle<'_>, id: TaskId, trigger: Trigger, because: Because) {
    if cycle.state(id) != TaskState::Ongoing {
        return;
    }
    resources::release(cycle, id, resources::Release::Unused);
    primitive::pause(cycle, id);
    question::pause(cycle, id);
    transition(cycle, id, trigger, None, because);
    run_hooks(cycle, id, "on-suspend", |hooks| &hooks.on_suspend);
    inheritance_changed(cycle, id);
}

/// Recomputes the priorities of the descendants of a task that stopped or continues.
pub(crate) fn inheritance_changed(cycle: &mut Cycle<'_>, id: TaskId) {
    cycle.work.inheritance_changed |= cycle.task(id).is_some_and(Task::has_children);
}

/// Runs a hook of the task's procedure or primitive, then of its step.
pub(crate) fn run_hooks(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    clause: &'static str,
    which: impl Fn(&Hooks) -> &Vec<apex_model::expression::Expr>,
) {
    run_inner_hook(cycle, id, clause, &which);
    run_step_hook(cycle, id, clause, which);
}

/// Runs a hook of the task's procedure or primitive, unless its failure handler is at work.
pub(crate) fn run_inner_hook(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    clause: &'static str,
    which: impl Fn(&Hooks) -> &Vec<apex_model::expression::Expr>,
) {
    let library = cycle.library;
    let reference = match cycle.task(id).and_then(|task| task.controller.as_deref()) {
        Some(Controller::Procedure(state)) => state.procedure,
        Some(Controller::Primitive(state)) => {
            if let Some(primitive) = library.primitives.get(state.primitive as usize) {
                hooks::run_hook(cycle, id, Level::Procedure, clause, which(&primitive.hooks));
            }
            return;
        }
        _ => return,
    };
    if let ProcedureRef::Stored(index) = reference {
        if let Some(procedure) = library.procedures.get(index as usize) {
            hooks::run_hook(cycle, id, Level::Procedure, clause, which(&procedure.hooks));
        }
    } else if let Some(procedure) = cycle.agent.procedure(reference).cloned() {
        hooks::run_hook(cycle, id, Level::Procedure, clause, which(&procedure.hooks));
    }
}

/// Runs a hook of the task's step.
pub(crate) fn run_step_hook(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    clause: &'static str,
    which: impl Fn(&Hooks) -> &Vec<apex_model::expression::Expr>,
) {
    if !cycle.has(id, StepClauses::HOOKS) {
        return;
    }
    let is_step = matches!(cycle.task(id).map(|task| task.origin), Some(Origin::Step(_)));
    if let Some(handle) = cycle.step_of(id).filter(|_| is_step)
        && let Some(step) = handle.get()
    {
        hooks::run_hook(cycle, id, Level::Step, clause, which(&step.hooks));
    }
}

/// Runs the `on-start` of the task's step.
///
/// # Errors
/// The cause when a form cannot be evaluated.
pub(crate) fn run_step_start(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), Because> {
    if !cycle.has(id, StepClauses::HOOKS) {
        return Ok(());
    }
    let is_step = matches!(cycle.task(id).map(|task| task.origin), Some(Origin::Step(_)));
    match cycle.step_of(id).filter(|_| is_step).as_ref().and_then(|handle| handle.get()) {
        Some(step) => hooks::run_needed(cycle, id, Level::Step, "on-start", &step.hooks.on_start),
        None => Ok(()),
    }
}

/// Returns the task and all tasks below it, ancestors first.
pub(crate) fn subtree(cycle: &Cycle<'_>, id: TaskId) -> Vec<TaskId> {
    let mut list = Vec::new();
    let mut open = vec![id];
    while let Some(next) = open.pop() {
        list.push(next);
        if let Some(controller) = cycle.task(next).and_then(|task| task.controller.as_deref()) {
            open.extend(controller.children().into_iter().rev());
        }
    }
    list
}

/// Suspends the task with its whole subtree: nothing below it works or begins until it is resumed.
pub(crate) fn suspend(cycle: &mut Cycle<'_>, id: TaskId, because: Because) {
    if cycle.task(id).is_none_or(Task::is_terminated) || !cycle.agent.set_suspended(id, true) {
        return;
    }
    for each in subtree(cycle, id) {
        if each == id {
            stop(cycle, id, Trigger::Suspended, because.clone());
        } else {
            let cause = Cause::AncestorSuspended { ancestor: id };
            stop(cycle, each, Trigger::Suspended, Because::new(cause, because.place));
        }
        withdraw_claims(cycle, each);
    }
}

fn withdraw_claims(cycle: &mut Cycle<'_>, id: TaskId) {
    for need in resources::needs_of(cycle, id) {
        if let Some(resource) = cycle.agent.resources.get_mut(need.resource)
            && resource.waiting.remove(id)
        {
            cycle.work.dirty.insert(need.resource);
        }
    }
}

/// Lifts the suspension: the subtree claims what it needs again.
pub(crate) fn resume(cycle: &mut Cycle<'_>, id: TaskId, because: &Because) {
    if !cycle.agent.set_suspended(id, false) {
        return;
    }
    for each in reclaim(cycle, id) {
        let cause = if each == id { because.cause.clone() } else { Cause::AncestorResumed { ancestor: id } };
        let evidence = if each == id { because.evidence.clone() } else { EvidenceList::default() };
        cycle.work.resumed.insert(each, Because { cause, place: because.place, evidence });
    }
}

/// Lets every task of the subtree that can work claim its resources again, and returns these tasks.
fn reclaim(cycle: &mut Cycle<'_>, id: TaskId) -> Vec<TaskId> {
    let mut tasks = subtree(cycle, id);
    tasks.retain(|each| matches!(cycle.state(*each), TaskState::Interrupted | TaskState::Enabled));
    cycle.work.claims.extend(tasks.iter().copied());
    tasks
}

/// Lets steps that were enabled while the task was not ongoing claim their resources.
pub(crate) fn offer_children(cycle: &mut Cycle<'_>, id: TaskId) {
    let children = cycle.task(id).and_then(|task| task.controller.as_deref()).map(Controller::children);
    for child in children.unwrap_or_default() {
        if cycle.state(child) == TaskState::Enabled {
            cycle.work.claims.push(child);
        }
    }
}

/// Withdraws the claims of the task's steps until the task continues: they are offered again then.
pub(crate) fn hold_children(cycle: &mut Cycle<'_>, id: TaskId) {
    let children = cycle.task(id).and_then(|task| task.controller.as_deref()).map(Controller::children);
    for child in children.unwrap_or_default() {
        if cycle.state(child) == TaskState::Enabled {
            withdraw_claims(cycle, child);
        }
    }
}

/// Makes the monitors of the clauses of the procedure that the task begins.
///
/// # Errors
/// The cause when an expression of a condition cannot be evaluated.
pub(crate) fn watch_procedure(cycle: &mut Cycle<'_>, id: TaskId, clauses: &Transitions) -> Result<(), Because> {
    let level = Level::Procedure;
    watch(cycle, id, Clause::EndWhen, level, clauses.end_when.as_deref())?;
    watch(cycle, id, Clause::ExitWhen, level, clauses.exit_when.as_deref())?;
    watch(cycle, id, Clause::RestartWhen, level, clauses.restart_when.as_deref())?;
    watch(cycle, id, Clause::SuspendWhen, level, clauses.suspend_when.as_deref())?;
    watch(cycle, id, Clause::ResumeWhen, level, clauses.resume_when.as_deref())?;
    Ok(())
}

/// Makes the monitors of the step's `suspend-when` and `resume-when`, unless they exist. They are made when the task is created if all
/// their variables are known then, otherwise when it is enabled and its `waitfor` and `select` have bound their variables.
///
/// # Errors
/// The cause when an expression of a condition cannot be evaluated.
pub(crate) fn watch_step_suspension(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), Because> {
    let Some(clauses) = step_clauses(cycle, id) else { return Ok(()) };
    if cycle.state(id) == TaskState::Pending && !all_known(cycle, id, &clauses) || has_suspension(cycle, id) {
        return Ok(());
    }
    watch(cycle, id, Clause::ResumeWhen, Level::Step, clauses.resume_when.as_deref())?;
    if let Some(monitor) = watch(cycle, id, Clause::SuspendWhen, Level::Step, clauses.suspend_when.as_deref())? {
        monitoring_clauses::judge(cycle, monitor);
    }
    Ok(())
}

/// Returns true if every variable of the suspension clauses has a value.
fn all_known(cycle: &Cycle<'_>, id: TaskId, clauses: &Transitions) -> bool {
    let view = cycle.view(id, Level::Step);
    let mut known = true;
    for condition in [&clauses.suspend_when, &clauses.suspend_until, &clauses.resume_when].into_iter().flatten() {
        of_condition(condition, &mut |name| known &= view.variable(name).is_some());
    }
    known
}

/// Returns true if the task has monitors for the suspension or resumption of its step.
fn has_suspension(cycle: &Cycle<'_>, id: TaskId) -> bool {
    let monitors = cycle.task(id).map(|task| task.monitors.as_slice()).unwrap_or_default();
    monitors.iter().filter_map(|id| cycle.agent.watches.get(id.0)).any(|watch| {
        watch.level == Level::Step
            && matches!(watch.clause, Clause::SuspendWhen | Clause::SuspendUntil | Clause::ResumeWhen)
    })
}

/// Makes the monitor of the step's `restart-when` as its task begins. Its `end-when` is watched from the creation of the task on.
///
/// # Errors
/// The cause when an expression of the condition cannot be evaluated.
pub(crate) fn watch_step_restart(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), Because> {
    let Some(clauses) = step_clauses(cycle, id) else { return Ok(()) };
    watch(cycle, id, Clause::RestartWhen, Level::Step, clauses.restart_when.as_deref())?;
    Ok(())
}

/// Returns true if the task has a monitor for `restart-when`.
pub(crate) fn may_start_over(cycle: &Cycle<'_>, id: TaskId) -> bool {
    let monitors = cycle.task(id).map(|task| task.monitors.as_slice()).unwrap_or_default();
    let mut watches = monitors.iter().filter_map(|id| cycle.agent.watches.get(id.0));
    watches.any(|watch| watch.clause == Clause::RestartWhen)
}

/// Returns the clauses of the step that the task was made from, if it has any; items and handlers have none.
fn step_clauses(cycle: &Cycle<'_>, id: TaskId) -> Option<Transitions> {
    let task = cycle.task(id).filter(|task| task.clauses.has(StepClauses::TRANSITIONS))?;
    let is_step = matches!(task.origin, Origin::Step(_));
    let handle = cycle.step_of(id).filter(|_| is_step)?;
    let Transitions { end_when, restart_when, resume_when, suspend_when, suspend_until, .. } =
        &handle.get()?.transitions;
    let some = [end_when, restart_when, resume_when, suspend_when, suspend_until].into_iter().any(Option::is_some);
    some.then(|| handle.get().map(|step| step.transitions.clone()))?
}

fn watch(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    clause: Clause,
    level: Level,
    condition: Option<&Condition>,
) -> Result<Option<MonitorId>, Because> {
    let (Some(condition), Some(task)) = (condition, cycle.task(id)) else { return Ok(None) };
    // Clauses that are watched from a later moment than the creation count evidence from that moment: those of a procedure, because it is
    // not chosen before; those with variables that were not bound before; and `restart-when`, because work must begin before it starts
    // over.
    let start = if task.state == TaskState::Pending { task.created_at } else { cycle.now };
    let after_sequence = match clause {
        // Evidence that satisfied the task's `waitfor` may satisfy these clauses too.
        Clause::SuspendWhen | Clause::ResumeWhen => None,
        Clause::EndWhen
        | Clause::ExitWhen
        | Clause::SkipWhen
        | Clause::RestartWhen
        | Clause::SuspendUntil
        | Clause::Waitfor => task.after_sequence,
    };
    let window = Window { start, after_sequence };
    // A condition that holds already when work begins does not restart that work.
    let standing = clause != Clause::RestartWhen;
    monitoring_clauses::watch(cycle, id, clause, level, condition, window, standing)
        .map(Some)
        .map_err(|error| Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place)))
}

/// Returns the clauses of the task at `level`; those of its procedure only once it has begun.
fn clauses(cycle: &Cycle<'_>, id: TaskId, level: Level) -> Option<Transitions> {
    match level {
        Level::Step => step_clauses(cycle, id),
        Level::Procedure => match &cycle.task(id).filter(|task| works_itself(task))?.selection.as_ref()?.way {
            MethodBinding::Procedure(reference, _) => {
                cycle.agent.procedure(*reference).map(|procedure| procedure.transitions.clone())
            }
            MethodBinding::Primitive(..)
            | MethodBinding::Items(_)
            | MethodBinding::BuiltIn(_)
            | MethodBinding::Terminate
            | MethodBinding::Solver(_) => None,
        },
    }
}

/// Returns true if the task executes its chosen method, and not the handler of its failure.
fn works_itself(task: &Task) -> bool {
    task.controller.as_deref().is_some_and(|controller| !matches!(controller, Controller::Handling(_)))
}

/// Returns the window of a clause that is first watched in the middle of a task's life: everything after this moment.
pub(crate) fn window_from_here(cycle: &Cycle<'_>) -> Window {
    window_after(cycle, cycle.now, None)
}

/// Returns the window of a clause that is watched after another one was satisfied at `at`, with `answered` as its newest arrival:
/// everything after that, including evidence already in the histories.
pub(crate) fn window_after(cycle: &Cycle<'_>, at: Time, answered: Option<u64>) -> Window {
    let newest = cycle.agent.next.arrival.checked_sub(1).filter(|_| at >= cycle.now);
    Window { start: at.min(cycle.now), after_sequence: answered.or(newest) }
}

/// Removes the monitors of the task's procedure, and ends a suspension that the procedure caused, because the work is over before the
/// task is. Monitors of the step stay, also those of a suspension that continues.
pub(crate) fn forget_clauses(cycle: &mut Cycle<'_>, id: TaskId) {
    let by_procedure = cycle.task(id).is_some_and(|task| {
        let mut watches = task.monitors.iter().filter_map(|id| cycle.agent.watches.get(id.0));
        watches.any(|watch| watch.clause == Clause::SuspendUntil && watch.level == Level::Procedure)
    });
    if by_procedure {
        cycle.agent.set_suspended(id, false);
    }
    let Some(suspended) = cycle.task(id).map(|task| task.suspended) else { return };
    monitoring_clauses::unwatch(cycle, id, |clause, level| match clause {
        Clause::EndWhen | Clause::ExitWhen => level == Level::Procedure,
        Clause::SuspendWhen | Clause::SuspendUntil | Clause::ResumeWhen => level == Level::Procedure || !suspended,
        Clause::Waitfor | Clause::RestartWhen | Clause::SkipWhen => true,
    });
}

/// Watches `until`, and again `resume-when`, after a suspension by `suspend-when`.
pub(crate) fn watch_resumption(cycle: &mut Cycle<'_>, id: TaskId, level: Level, window: Window) {
    let Some(clauses) = clauses(cycle, id, level) else { return };
    monitoring_clauses::unwatch(cycle, id, |clause, at| clause == Clause::ResumeWhen && at == level);
    let wanted = [(Clause::SuspendUntil, clauses.suspend_until), (Clause::ResumeWhen, clauses.resume_when)];
    // A condition that holds already ends the suspension at once.
    watch_again(cycle, id, level, wanted, window, true);
}

/// Watches clauses in the middle of a task's life. If a clause cannot be watched the task fails: it would otherwise be suspended forever,
/// or never again.
fn watch_again(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    level: Level,
    wanted: [(Clause, Option<Box<Condition>>); 2],
    window: Window,
    standing: bool,
) {
    for (clause, condition) in wanted {
        if let Some(condition) = condition
            && let Err(error) = monitoring_clauses::watch(cycle, id, clause, level, &condition, window, standing)
        {
            let cause = Cause::ExpressionFailed { message: error.message };
            return termination::fail(cycle, id, Because::new(cause, Some(error.place)));
        }
    }
}

/// Watches `suspend-when` again after a resumption, and no longer the clauses that could end the suspension. If the step's clause names
/// variables that are not bound yet, it is watched when the task is enabled.
pub(crate) fn watch_suspension(cycle: &mut Cycle<'_>, id: TaskId, window: Window) {
    monitoring_clauses::unwatch(cycle, id, |clause, _| {
        matches!(clause, Clause::SuspendUntil | Clause::ResumeWhen | Clause::SuspendWhen)
    });
    for level in [Level::Step, Level::Procedure] {
        let Some(clauses) = clauses(cycle, id, level) else { continue };
        if cycle.state(id) == TaskState::Pending && !all_known(cycle, id, &clauses) {
            continue;
        }
        let wanted = [(Clause::SuspendWhen, clauses.suspend_when), (Clause::ResumeWhen, clauses.resume_when)];
        // A condition that still holds has caused its suspension already and does not count again.
        watch_again(cycle, id, level, wanted, window, false);
    }
}

//! New procedure generation (DM)
//! What: turns a solver's plan into a procedure of the agent's library, and lets the task that waits for its goal pursue it.
//! Runs: record phase, when a solver reports.  Reads: PlannedProcedure.  Writes: generated procedures, Decision.
//! Bound: O(steps of the plan).  PDL: section 3, `:sequential`.  Paper: section V, translation of plans.

use crate::control::cycle::Cycle;
use crate::control::tasks::{procedure, termination};
use crate::state::agent::Generated;
use crate::state::bindings::Bindings;
use crate::state::controller::{Controller, MethodBinding};
use crate::state::index::{IndexCandidate, ProcedureIndex};
use crate::state::task::ProcedureRef;
use apex_model::because::{Because, Cause};
use apex_model::effect::{DecisionKind, Effect, Method, SolveRequestId};
use apex_model::event::SolverReport;
use apex_model::expression::Template;
use apex_model::pattern::Pattern;
use apex_model::planned::PlannedProcedure;
use apex_model::procedure::{Activity, Hooks, Procedure, ProcedureKind, Step, Transitions};
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;
use std::sync::Arc;

/// Handles the answer of a solver.
pub(crate) fn reported(cycle: &mut Cycle<'_>, request: SolveRequestId, report: &SolverReport) {
    let Some(id) = cycle.agent.requests.remove(&request) else {
        if request.0 >= cycle.agent.next.request {
            cycle.trouble_of(None, Cause::StrayAnswer { to: format!("solver request {}", request.0) }, None);
        }
        return;
    };
    stop_waiting(cycle, id);
    match report {
        SolverReport::Failed(reason) => {
            let cause = Cause::SolverFailed { request, reason: reason.clone() };
            let place = cycle.place_of(id);
            termination::fail(cycle, id, Because::new(cause, place));
        }
        SolverReport::Plan(plan) => adopt(cycle, id, request, plan),
    }
}

/// Ends the wait for a solver's answer, which has arrived or is no longer expected.
fn stop_waiting(cycle: &mut Cycle<'_>, id: TaskId) {
    if let Some(Controller::Planning(controller)) =
        cycle.agent.task_mut(id).and_then(|task| task.controller.as_deref_mut())
        && let Some(wake) = controller.wake.take()
    {
        cycle.agent.wakes.cancel(wake);
    }
}

/// Handles the timeout of a solver: the request has failed, and its answer will be ignored.
pub(crate) fn timed_out(cycle: &mut Cycle<'_>, request: SolveRequestId) {
    let Some(id) = cycle.agent.requests.remove(&request) else { return };
    let Some(Controller::Planning(controller)) = cycle.task(id).and_then(|task| task.controller.as_deref()) else {
        return;
    };
    let cause = Cause::SolverTimedOut { request, patience: controller.patience };
    cycle.effects.push(Effect::CancelSolve(request));
    let place = cycle.place_of(id);
    termination::fail(cycle, id, Because::new(cause, place));
}

fn adopt(cycle: &mut Cycle<'_>, id: TaskId, request: SolveRequestId, plan: &PlannedProcedure) {
    let Some(Controller::Planning(controller)) = cycle.task(id).and_then(|task| task.controller.as_deref()) else {
        return;
    };
    let (goal, pursue) = (controller.goal.clone(), controller.pursue);
    let reference = add(cycle, &goal, plan);
    let cause = Cause::PlanArrived { request, solver: plan.solver.clone() };
    let because = Because::new(cause, cycle.place_of(id));
    let (summary, pdl) = (plan.summary.clone(), plan.source.text.to_string());
    cycle.decide(Some(id), DecisionKind::ProcedureAdded { request, summary, pdl }, because.clone());
    if !pursue {
        let value = Value::text(&plan.summary);
        return termination::end(cycle, id, Outcome::Success(value), because);
    }
    let place = cycle.agent.procedure(reference).map(|procedure| procedure.place).unwrap_or_default();
    let method = Method::Procedure(place);
    cycle.decide(Some(id), DecisionKind::Selected { method, goal, alternatives: Vec::new() }, because.clone());
    termination::end_children(cycle, id, &because);
    if let Some(task) = cycle.agent.task_mut(id) {
        if let Some(selection) = &mut task.selection {
            selection.way = MethodBinding::Procedure(reference, Bindings::new());
        }
        if let Some(Controller::Planning(controller)) = task.controller.as_deref_mut() {
            controller.arrived = Some(reference);
            controller.meanwhile = None;
        }
    }
    if cycle.state(id) == TaskState::Ongoing {
        pursue_arrived(cycle, id);
    }
}

/// Pursues the plan that arrived, if one did.
pub(crate) fn pursue_arrived(cycle: &mut Cycle<'_>, id: TaskId) {
    if let Some(Controller::Planning(controller)) = cycle.task(id).and_then(|task| task.controller.as_deref())
        && let Some(reference) = controller.arrived
    {
        procedure::start(cycle, id, reference, Bindings::new(), Cause::PlanPursued { parent: id });
    }
}

/// Adds the plan to the library of the agent; it replaces an older plan for the same goal.
fn add(cycle: &mut Cycle<'_>, goal: &Value, plan: &PlannedProcedure) -> ProcedureRef {
    let number = cycle.agent.next.generated;
    cycle.agent.next.generated += 1;
    retire(cycle, goal);
    let file = u32::try_from(cycle.library.sources.len() as u64 + number).unwrap_or(u32::MAX);
    let procedure = Arc::new(translate(goal, plan, file));
    let index = Arc::new(ProcedureIndex::new(&procedure));
    cycle.agent.generated_heads.insert(&procedure.index, IndexCandidate::Generated(number));
    let (source, repeat) = (plan.source.clone(), plan.repeat);
    cycle.agent.generated.insert(number, Generated { procedure, index, source, repeat, current: true, users: 0 });
    ProcedureRef::Generated(number)
}

fn retire(cycle: &mut Cycle<'_>, goal: &Value) {
    let index = Pattern::Literal(goal.clone());
    let older = cycle.agent.generated.iter().find(|(_, each)| each.current && each.procedure.index == index);
    let Some(number) = older.map(|(number, _)| number) else { return };
    cycle.agent.generated_heads.remove(&index, IndexCandidate::Generated(number));
    if let Some(generated) = cycle.agent.generated.get_mut(number) {
        generated.current = false;
        if generated.users == 0 {
            cycle.agent.generated.remove(number);
        }
    }
}

/// Returns the plan as a sequential procedure indexed by its goal.
fn translate(goal: &Value, plan: &PlannedProcedure, file: u32) -> Procedure {
    let steps = plan.steps.iter().map(|step| {
        let activity = Activity::Goal(Template::Constant(step.activity.goal()));
        Step::plain(step.tag.clone(), activity, Place { file, line: step.line, column: 1 })
    });
    let steps = steps.collect();
    Procedure {
        kind: ProcedureKind::Sequential,
        index: Pattern::Literal(goal.clone()),
        profile: Vec::new(),
        log: Vec::new(),
        expected_duration: None,
        interrupt_cost: None,
        transitions: Transitions::default(),
        hooks: Hooks::default(),
        steps,
        bundle: None,
        place: Place { file, line: 1, column: 1 },
    }
}

//! Planner invocation (DM)
//! What: requests a procedure from a solver, and pursues a safe goal until the plan arrives.
//! Runs: act phase.  Reads: SolverDeclaration.  Writes: PlanningController, Effect::Solve.
//! Bound: O(1); the solver itself runs outside.  PDL: `solver`, `(plan GOAL ..)`.  Paper: sections III and V, planner invocation.

use crate::control::cycle::Cycle;
use crate::control::tasks::instantiation::{self, Seed};
use crate::control::tasks::{failure, termination};
use crate::deliberation::solver_selection;
use crate::expression::evaluate;
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::controller::{Controller, PlanningController};
use crate::state::task::Origin;
use crate::state::wake::Wake;
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause};
use apex_model::effect::{Effect, SolveRequest, SolveRequestId};
use apex_model::event::StateVariable;
use apex_model::limits::{SOLVE_GRACE_S, SOLVE_TIMEOUT_DEFAULT_S};
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::{Duration, NANOSECONDS_PER_SECOND};
use apex_model::value::Value;

/// Requests a procedure for the task's goal from a solver; the task then pursues it.
pub(crate) fn start(cycle: &mut Cycle<'_>, id: TaskId, solver: u32) {
    let Some(goal) = cycle.task(id).and_then(|task| task.selection.as_ref()).map(|selection| selection.goal.clone())
    else {
        return;
    };
    if let Err(because) = ask(cycle, id, solver, goal, None, None, true) {
        termination::fail(cycle, id, because);
    }
}

/// Executes `(plan GOAL :with SOLVER :budget SPAN)`: a procedure for the goal is requested and stored, but not pursued by this step.
///
/// # Errors
/// The cause when no solver serves the goal.
pub(crate) fn plan(cycle: &mut Cycle<'_>, id: TaskId, values: &[Value]) -> Result<(), Because> {
    let goal = values.first().cloned().unwrap_or_else(Value::nil);
    let named = values.get(1).and_then(Value::as_symbol).cloned();
    let budget = match values.get(2) {
        Some(Value::Duration(budget)) => Some(*budget),
        _ => None,
    };
    let Some(solver) = solver_selection::select(cycle, id, &goal) else {
        return Err(Because::new(Cause::NoMethod { goal }, cycle.place_of(id)));
    };
    ask(cycle, id, solver, goal, named, budget, false)
}

fn ask(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    solver: u32,
    goal: Value,
    named: Option<Symbol>,
    budget: Option<Duration>,
    pursue: bool,
) -> Result<(), Because> {
    if cycle.agent.requests.len() >= cycle.agent.limits.count(Limit::SolveRequests) {
        let cause = cycle.agent.limits.reached(Limit::SolveRequests);
        return Err(Because::new(cause, cycle.place_of(id)));
    }
    let Some(declaration) = cycle.library.solvers.get(solver as usize).cloned() else { return Ok(()) };
    let budget = match (budget, &declaration.budget) {
        (Some(budget), _) => Some(budget),
        (None, Some(expr)) => declared_budget(cycle, id, expr)?,
        (None, None) => None,
    };
    let request = SolveRequestId(cycle.agent.next.request);
    cycle.agent.next.request += 1;
    cycle.agent.requests.insert(request, id);
    let patience = patience(cycle, budget);
    let wake = Some(cycle.agent.wakes.schedule(cycle.now + patience, Wake::SolveTimeout(request)));
    let fresh =
        PlanningController { request, goal: goal.clone(), meanwhile: None, pursue, patience, wake, arrived: None };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.controller = Some(Box::new(Controller::Planning(fresh)));
    }
    let solver_name = named.unwrap_or(declaration.name);
    let is_failure_handled = failure::is_handled(cycle, id);
    let solve = SolveRequest { request, task: id, goal, solver: solver_name, budget, is_failure_handled };
    cycle.effects.push(Effect::Solve(solve));
    if pursue && declaration.meanwhile.is_some() {
        meanwhile(cycle, id, solver);
    }
    Ok(())
}

/// Returns the mission time for which an answer is awaited. A solver needs wall time: in a run that is faster than the wall clock it is
/// awaited as many times longer (decision 0268).
fn patience(cycle: &Cycle<'_>, budget: Option<Duration>) -> Duration {
    let patience = budget.map_or(Duration(SOLVE_TIMEOUT_DEFAULT_S * NANOSECONDS_PER_SECOND), |budget| {
        budget + Duration(SOLVE_GRACE_S * NANOSECONDS_PER_SECOND)
    });
    let newest = cycle.agent.histories.get(&StateVariable::mission_pace()).and_then(|history| history.newest());
    let pace = newest.and_then(|sample| sample.value.as_number()).map_or(1.0, |(pace, _)| pace);
    if pace > 1.0 { Duration::from_seconds(patience.seconds() * pace) } else { patience }
}

fn declared_budget(
    cycle: &Cycle<'_>,
    id: TaskId,
    expr: &apex_model::expression::Expr,
) -> Result<Option<Duration>, Because> {
    let failed = |message, place| Because::new(Cause::ExpressionFailed { message }, Some(place));
    match evaluate(expr, &cycle.view(id, Level::Step)).map_err(|error| failed(error.message, error.place))? {
        Value::Duration(budget) => Ok(Some(budget)),
        other => Err(failed(format!("{other} is not a budget; write a duration such as 5s"), expr.place)),
    }
}

/// Starts the solver's `:meanwhile` goal, which is pursued until the plan arrives.
fn meanwhile(cycle: &mut Cycle<'_>, id: TaskId, solver: u32) {
    let seed = Seed {
        parent: Some(id),
        origin: Origin::Meanwhile(solver),
        bindings: Bindings::new(),
        by_predecessor: false,
        after_sequence: None,
        cause: Cause::Meanwhile { parent: id },
    };
    let child = match instantiation::create(cycle, seed) {
        Ok(child) => child,
        // The task waits for the plan without it.
        Err(cause) => {
            let place = cycle.place_of(id);
            return cycle.trouble_of(Some(id), cause, place);
        }
    };
    if let Some(Controller::Planning(controller)) =
        cycle.agent.task_mut(id).and_then(|task| task.controller.as_deref_mut())
    {
        controller.meanwhile = Some(child);
    }
    instantiation::arm(cycle, child);
}

//! Procedure selection (TC)
//! What: selects the method for an enabled task's goal: procedure, primitive, built-in, items or solver.
//! Runs: choose phase.  Reads: Library, generated procedures, Step.  Writes: Selection, Decision.
//! Bound: one pattern match per candidate that shares the goal's first word.
//! PDL: `index`, section 2.  Paper: section III, selection services.

use crate::control::conflicts::{priority, resources};
use crate::control::cycle::{Cycle, in_order};
use crate::control::matching::{IndexPattern, index_of, match_index};
use crate::control::tasks::execution_conditions;
use crate::control::tasks::goal;
use crate::control::tasks::goal::activity_of;
use crate::control::tasks::termination;
use crate::deliberation::solver_selection;
use crate::expression::result::EvaluationError;
use crate::expression::{evaluate, instantiate};
use crate::monitoring::specificity::specificity;
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::controller::{MethodBinding, Selection};
use crate::state::index::IndexCandidate;
use crate::state::resource::Need;
use crate::state::step_clauses::StepClauses;
use crate::state::task::{Origin, ProcedureRef};
use apex_model::agent_limits::Limit;
use apex_model::because::{Because, Cause, EqualsRule};
use apex_model::effect::{DecisionKind, Method};
use apex_model::expression::Expr;
use apex_model::procedure::{Activity, BuiltInActivity, Procedure, ResourceNeed};
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Duration;
use apex_model::value::Value;
use smallvec::SmallVec;

/// The chosen method, with the data of the decision about it.
struct MethodChoice {
    goal: Value,
    way: MethodBinding,
    method: Method,
    alternatives: Vec<Method>,
    cause: Cause,
}

/// Executes the choose phase.
pub(crate) fn choose(cycle: &mut Cycle<'_>) {
    for id in in_order(&mut cycle.work.enabled) {
        let open = cycle.task(id).is_some_and(|task| task.state == TaskState::Enabled && task.selection.is_none());
        if !open {
            continue;
        }
        match choose_for(cycle, id) {
            Ok(()) if !execution_conditions::allow(cycle, id) => {}
            Ok(()) => cycle.work.claims.push(id),
            Err(because) => termination::fail(cycle, id, because),
        }
        termination::settle(cycle);
    }
}

fn failed(error: EvaluationError) -> Because {
    Because::new(Cause::ExpressionFailed { message: error.message }, Some(error.place))
}

fn choose_for(cycle: &mut Cycle<'_>, id: TaskId) -> Result<(), Because> {
    let choice = choice(cycle, id)?;
    let selection = Selection {
        goal: choice.goal.clone(),
        way: choice.way,
        needs: Vec::new(),
        interrupt_cost: priority::INTERRUPT_COST_DEFAULT,
        expected: None,
        begun: false,
        refuses: false,
    };
    if let Some(task) = cycle.agent.task_mut(id) {
        task.selection = Some(Box::new(selection));
    }
    let kind = DecisionKind::Selected { method: choice.method, goal: choice.goal, alternatives: choice.alternatives };
    let because = Because::new(choice.cause, cycle.place_of(id));
    cycle.decide(Some(id), kind, because);
    let mut details = details(cycle, id)?;
    resources::add_parts(cycle, &mut details.needs);
    if let Some(selection) = cycle.agent.task_mut(id).and_then(|task| task.selection.as_mut()) {
        selection.needs = details.needs;
        selection.interrupt_cost = details.interrupt_cost.unwrap_or(priority::INTERRUPT_COST_DEFAULT);
        selection.expected = details.expected;
        selection.refuses = details.refuses;
    }
    Ok(())
}

fn choice(cycle: &mut Cycle<'_>, id: TaskId) -> Result<MethodChoice, Because> {
    let origin = cycle.task(id).map(|task| task.origin);
    let handle = cycle.step_of(id);
    let step = handle.as_ref().and_then(|handle| handle.get());
    let goal = match (origin, step) {
        (Some(Origin::Step(_)), Some(step)) => {
            if let Some((_, list)) = step.forall.as_deref() {
                return items(cycle, id, list);
            }
            activity_goal(cycle, id, &step.activity)?
        }
        (Some(Origin::Item(_)), Some(step)) => activity_goal(cycle, id, &step.activity)?,
        (Some(Origin::OnFailure(_)), Some(step)) => match &step.on_failure {
            Some(activity) => activity_goal(cycle, id, activity)?,
            None => Err(Value::nil()),
        },
        (Some(Origin::Meanwhile(solver)), _) => {
            let solver = cycle.library.solvers.get(solver as usize).cloned();
            match solver.and_then(|solver| solver.meanwhile) {
                Some(goal) => Ok(instantiate(&goal, &cycle.view(id, Level::Step)).map_err(failed)?),
                None => Err(Value::nil()),
            }
        }
        (Some(Origin::Probe(probing)), _) => match cycle.agent.probings.get(&probing) {
            Some(probing) => Ok(instantiate(&probing.goal, &cycle.view(id, Level::Step)).map_err(failed)?),
            None => Err(Value::nil()),
        },
        _ => Ok(cycle.agent.initial_task.clone()),
    };
    match goal {
        Ok(goal) => method_for(cycle, id, goal),
        Err(goal) => {
            let (way, word) = match step.map(|step| activity_of(origin, step)) {
                Some(Activity::BuiltIn(which, _)) => (MethodBinding::BuiltIn(*which), which.word()),
                _ => (MethodBinding::Terminate, "terminate"),
            };
            let cause = Cause::BuiltIn { activity: word.into() };
            Ok(MethodChoice { goal, way, method: Method::BuiltIn, alternatives: Vec::new(), cause })
        }
    }
}

/// Returns the goal of an activity, or the form of a built-in activity.
fn activity_goal(cycle: &Cycle<'_>, id: TaskId, activity: &Activity) -> Result<Result<Value, Value>, Because> {
    let view = cycle.view(id, Level::Step);
    match activity {
        Activity::Goal(template) => Ok(Ok(instantiate(template, &view).map_err(failed)?)),
        Activity::Terminate { .. } | Activity::BuiltIn(..) => Ok(Err(goal::activity_as_value(activity, &view))),
    }
}

fn items(cycle: &Cycle<'_>, id: TaskId, list: &Expr) -> Result<MethodChoice, Because> {
    let value = evaluate(list, &cycle.view(id, Level::Step)).map_err(failed)?;
    let Some(items) = value.as_list() else {
        let message = format!("forall expects a list, found {value}");
        return Err(Because::new(Cause::ExpressionFailed { message }, Some(list.place)));
    };
    if items.len() > cycle.agent.limits.count(Limit::ForallItems) {
        let cause = cycle.agent.limits.reached(Limit::ForallItems);
        return Err(Because::new(cause, Some(list.place)));
    }
    Ok(MethodChoice {
        goal: goal::goal_as_known(cycle, id),
        way: MethodBinding::Items(items.to_vec()),
        method: Method::BuiltIn,
        alternatives: Vec::new(),
        cause: Cause::ForAll { items: items.len() as u64 },
    })
}

/// Returns the best method for a goal: the most specific match, otherwise a solver.
fn method_for(cycle: &mut Cycle<'_>, id: TaskId, goal: Value) -> Result<MethodChoice, Because> {
    let mut matches = matches(cycle, id, &goal);
    if matches.is_empty() {
        let Some(solver) = solver_selection::select(cycle, id, &goal) else {
            return Err(Because::new(Cause::NoMethod { goal }, cycle.place_of(id)));
        };
        let name = cycle.library.solvers.get(solver as usize).map(|solver| solver.name.clone());
        let method = Method::Solver(name.unwrap_or_else(|| Symbol::new("auto")));
        let (way, cause) = (MethodBinding::Solver(solver), Cause::NoProcedureMatched);
        return Ok(MethodChoice { goal, way, method, alternatives: Vec::new(), cause });
    }
    let cause = why_first(cycle, &matches);
    let (candidate, bindings) = matches.remove(0);
    let alternatives = matches.iter().filter_map(|(candidate, _)| method_of(cycle, *candidate)).collect();
    let way = match candidate {
        IndexCandidate::Procedure(index) => MethodBinding::Procedure(ProcedureRef::Stored(index), bindings),
        IndexCandidate::Generated(number) => MethodBinding::Procedure(ProcedureRef::Generated(number), bindings),
        IndexCandidate::Primitive(index) | IndexCandidate::Solver(index) => MethodBinding::Primitive(index, bindings),
    };
    let method = method_of(cycle, candidate).unwrap_or(Method::BuiltIn);
    Ok(MethodChoice { goal, way, method, alternatives, cause })
}

fn method_of(cycle: &Cycle<'_>, candidate: IndexCandidate) -> Option<Method> {
    match candidate {
        IndexCandidate::Procedure(index) => {
            cycle.library.procedures.get(index as usize).map(|procedure| Method::Procedure(procedure.place))
        }
        IndexCandidate::Generated(number) => {
            cycle.agent.generated.get(number).map(|generated| Method::Procedure(generated.procedure.place))
        }
        IndexCandidate::Primitive(index) => {
            cycle.library.primitives.get(index as usize).map(|primitive| Method::Primitive(primitive.place))
        }
        IndexCandidate::Solver(index) => {
            cycle.library.solvers.get(index as usize).map(|solver| Method::Solver(solver.name.clone()))
        }
    }
}

/// Methods that serve a goal, with the bindings of their indexes.
type Matches = SmallVec<[(IndexCandidate, Bindings); 1]>;

/// Returns the reason for the first of the matches: the others are less specific, or equally specific and later in the order.
fn why_first(cycle: &Cycle<'_>, matches: &Matches) -> Cause {
    let candidates = matches.len() as u64;
    let specific =
        |candidate: IndexCandidate| index_of(cycle, candidate).map(|(pattern, _)| specificity(pattern.get()));
    let own = matches.first().filter(|_| matches.len() > 1).map(|(first, _)| specific(*first));
    let others = matches.iter().skip(1).map(|(other, _)| *other);
    let equals: SmallVec<[IndexCandidate; 2]> =
        others.take_while(|other| own.as_ref() == Some(&specific(*other))).collect();
    let rule = match (matches.first(), equals.first()) {
        (_, None) => return Cause::MostSpecific { candidates },
        (Some((IndexCandidate::Generated(_), _)), _) => EqualsRule::MadeInFlight,
        (Some((IndexCandidate::Procedure(_), _)), Some(IndexCandidate::Primitive(_))) => EqualsRule::Procedure,
        _ => EqualsRule::FirstInLibrary,
    };
    Cause::FirstOfEquals { candidates, equals: equals.len() as u64 + 1, rule }
}

/// Returns all procedures and primitives that serve the goal, with the bindings of their indexes, best first.
fn matches(cycle: &mut Cycle<'_>, id: TaskId, goal: &Value) -> Matches {
    let mut found: Matches = Matches::new();
    let mut errors = Vec::new();
    let stored = cycle.index.methods.candidates(goal.head());
    for candidate in stored.chain(cycle.agent.generated_heads.candidates(goal.head())) {
        let Some((pattern, place)) = index_of(cycle, candidate) else { continue };
        let mut bindings = Bindings::new();
        match match_index(cycle, id, &pattern, goal, &mut bindings, place) {
            Ok(true) => found.push((candidate, bindings)),
            Ok(false) => {}
            Err(error) => errors.push(error),
        }
    }
    for error in errors {
        cycle.trouble(Some(id), error.message, Some(error.place));
    }
    if found.len() > 1 {
        let pattern =
            |candidate: IndexCandidate| index_of(cycle, candidate).map(|(pattern, _)| specificity(pattern.get()));
        found.sort_by_cached_key(|(candidate, _)| (std::cmp::Reverse(pattern(*candidate)), *candidate));
    }
    found
}

/// Profile, interrupt cost and expected duration of the selected method.
#[derive(Default)]
struct Details {
    needs: Vec<Need>,
    interrupt_cost: Option<f64>,
    expected: Option<Duration>,
    refuses: bool,
}

fn details(cycle: &mut Cycle<'_>, id: TaskId) -> Result<Details, Because> {
    let mut details = Details::default();
    match chosen(cycle, id) {
        Some(IndexPattern::Stored(procedure)) => of_procedure(cycle, id, procedure, &mut details)?,
        Some(IndexPattern::Generated(procedure)) => of_procedure(cycle, id, &procedure, &mut details)?,
        Some(IndexPattern::Primitive(primitive)) => {
            details.refuses |= refuses(&primitive.profile);
            profile(cycle, id, Level::Procedure, &primitive.profile, &mut details.needs)?;
            // The duration may use locals, which do not exist yet: the expected duration is then unknown.
            details.expected = expected(cycle, id, primitive.duration.as_ref()).unwrap_or(None);
        }
        _ => held(cycle, id, &mut details.needs)?,
    }
    if !cycle.has(id, StepClauses::CONTENTION) {
        return Ok(details);
    }
    if let (Some(Origin::Step(_)), Some(handle)) = (cycle.task(id).map(|task| task.origin), cycle.step_of(id))
        && let Some(step) = handle.get()
    {
        details.refuses |= refuses(&step.profile);
        profile(cycle, id, Level::Step, &step.profile, &mut details.needs)?;
        if let Some(own) = cost(cycle, id, Level::Step, step.interrupt_cost.as_deref())? {
            details.interrupt_cost = Some(own);
        }
        for (message, place) in priority::troubles(cycle, id, step) {
            cycle.trouble(Some(id), message, Some(place));
        }
    }
    Ok(details)
}

fn of_procedure(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    procedure: &Procedure,
    details: &mut Details,
) -> Result<(), Because> {
    details.refuses |= refuses(&procedure.profile);
    profile(cycle, id, Level::Procedure, &procedure.profile, &mut details.needs)?;
    details.interrupt_cost = cost(cycle, id, Level::Procedure, procedure.interrupt_cost.as_ref())?;
    details.expected = expected(cycle, id, procedure.expected_duration.as_ref())?;
    Ok(())
}

fn refuses(profile: &[ResourceNeed]) -> bool {
    profile.iter().any(|need| need.refuse_if_busy)
}

/// Returns the selected procedure or primitive; `None` for all other methods.
fn chosen<'a>(cycle: &Cycle<'a>, id: TaskId) -> Option<IndexPattern<'a>> {
    let candidate = match &cycle.task(id)?.selection.as_ref()?.way {
        MethodBinding::Procedure(ProcedureRef::Stored(index), _) => IndexCandidate::Procedure(*index),
        MethodBinding::Procedure(ProcedureRef::Generated(number), _) => IndexCandidate::Generated(*number),
        MethodBinding::Primitive(index, _) => IndexCandidate::Primitive(*index),
        MethodBinding::Items(_) | MethodBinding::BuiltIn(_) | MethodBinding::Terminate | MethodBinding::Solver(_) => {
            return None;
        }
    };
    index_of(cycle, candidate).map(|(holder, _)| holder)
}

fn profile(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    level: Level,
    profile: &[ResourceNeed],
    needs: &mut Vec<Need>,
) -> Result<(), Because> {
    let named = |cycle: &Cycle<'_>, need: &ResourceNeed| resources::evaluate_need(need, &cycle.view(id, level));
    resources::needs(cycle, profile, named, needs)
        .map_err(|(message, place)| Because::new(Cause::ExpressionFailed { message }, Some(place)))
}

fn cost(cycle: &Cycle<'_>, id: TaskId, level: Level, expr: Option<&Expr>) -> Result<Option<f64>, Because> {
    let Some(expr) = expr else { return Ok(None) };
    let cost = priority::interrupt_cost(expr, &cycle.view(id, level));
    cost.map(Some).map_err(|message| Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
}

fn expected(cycle: &Cycle<'_>, id: TaskId, expr: Option<&Expr>) -> Result<Option<Duration>, Because> {
    let Some(expr) = expr else { return Ok(None) };
    match evaluate(expr, &cycle.view(id, Level::Procedure)).map_err(failed)? {
        Value::Duration(span) if span >= Duration::ZERO => Ok(Some(span)),
        Value::Duration(span) => {
            let message = format!("a duration of {span} is negative; write zero or more, for example `(max 0s ..)`");
            Err(Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
        }
        other => {
            let message = format!("{other} is not a span of time; write a duration such as 10s");
            Err(Because::new(Cause::ExpressionFailed { message }, Some(expr.place)))
        }
    }
}

/// Adds the resources named by `(hold-resource r..)` to the needs; adds nothing for other methods.
fn held(cycle: &mut Cycle<'_>, id: TaskId, needs: &mut Vec<Need>) -> Result<(), Because> {
    let way = cycle.task(id).and_then(|task| task.selection.as_ref()).map(|selection| &selection.way);
    if !matches!(way, Some(MethodBinding::BuiltIn(BuiltInActivity::HoldResource))) {
        return Ok(());
    }
    let Some(handle) = cycle.step_of(id) else { return Ok(()) };
    let origin = cycle.task(id).map(|task| task.origin);
    let Some(Activity::BuiltIn(_, arguments)) = handle.get().map(|step| activity_of(origin, step)) else {
        return Ok(());
    };
    for argument in arguments {
        let name = evaluate(argument, &cycle.view(id, Level::Step)).map_err(failed)?;
        let resource = resources::intern(cycle, &name);
        let amount = cycle.agent.resources.get(resource).map_or(1.0, |resource| resource.total);
        resources::add(needs, Need { resource, amount });
    }
    Ok(())
}

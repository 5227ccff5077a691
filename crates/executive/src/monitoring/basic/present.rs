//! Present truth (M&I)
//! What: judges a condition at an instant as true, false or unknown; the newest sample of a state variable counts, however old.
//! Runs: when a task with a `precondition` or `invariant` is judged.
//! Reads: histories, evaluation context.
//! Writes: nothing.
//! Bound: linear in the condition.
//! PDL: `precondition`, `invariant`.
//! Paper: section III, condition monitoring.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::constraints::{RightSide, all};
use crate::monitoring::pattern_matching::match_pattern;
use crate::monitoring::samples::known_variable;
use crate::state::bindings::Bindings;
use crate::state::guards::Reads;
use apex_forms::print::Style::Brief;
use apex_model::because::Evidence;
use apex_model::condition::{Condition, ConditionKind, Constraint, MeasurementCondition};
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Truth of a condition at an instant, with its evidence.
pub(crate) struct Present {
    /// None if no sample decides.
    pub(crate) truth: Option<bool>,
    /// Facts that decided.
    pub(crate) evidence: EvidenceList,
}

/// Judges `condition` as of now.
///
/// # Errors
/// If an expression cannot be evaluated, an object is not known, or the condition is about more than an instant.
pub(crate) fn judge(condition: &Condition, context: &dyn EvalContext) -> Result<Present, EvaluationError> {
    let of = |truth: Option<bool>, evidence: Evidence| Present { truth, evidence: EvidenceList::one(evidence) };
    match &condition.kind {
        ConditionKind::Measurement(measurement) => measured(condition, measurement, context),
        ConditionKind::Function(expression) => {
            let value = evaluate(expression, context)?;
            let (what, at) = (Brief.expression(expression), context.now());
            Ok(of(Some(value.is_true()), Evidence::Function { what, value, at }))
        }
        ConditionKind::TaskEnded(name) => {
            let Some(Value::Task(task)) = context.variable(name) else { return Ok(no_task(name, context)) };
            let state = context.task_state(task).map_or("unknown", |state| state.word());
            let evidence = Evidence::TaskState { task, state: Value::symbol(state), at: context.now() };
            Ok(of(Some(context.task_end(task).is_some()), evidence))
        }
        ConditionKind::TaskState { task, state } => of_task(condition, task, state, context),
        ConditionKind::Not(part) => {
            let Present { truth, evidence } = judge(part, context)?;
            Ok(Present { truth: truth.map(|truth| !truth), evidence })
        }
        ConditionKind::And(parts, _) => together(parts, false, context),
        ConditionKind::Or(parts, _) => together(parts, true, context),
        _ => Err(error(condition, "this condition cannot be judged at an instant".into())),
    }
}

fn error(condition: &Condition, message: String) -> EvaluationError {
    EvaluationError { message, place: condition.place }
}

/// Combines parts: one part with the truth `deciding` decides (true for "any", false for "all"), otherwise one unknown part does.
fn together(parts: &[Condition], deciding: bool, context: &dyn EvalContext) -> Result<Present, EvaluationError> {
    let mut truth = Some(!deciding);
    let mut evidence: Vec<Evidence> = Vec::new();
    for part in parts {
        let judged = judge(part, context)?;
        if judged.truth == Some(deciding) {
            return Ok(judged);
        }
        if judged.truth.is_none() && truth.is_some() {
            truth = None;
            evidence.clear();
        }
        if judged.truth == truth {
            evidence.extend(judged.evidence.iter().cloned());
        }
    }
    Ok(Present { truth, evidence: evidence.into_iter().collect() })
}

fn measured(
    condition: &Condition,
    measurement: &MeasurementCondition,
    context: &dyn EvalContext,
) -> Result<Present, EvaluationError> {
    let Some(variable) = known_variable(&measurement.variable, context) else {
        let what = format!("value of the object of ({} ..)", measurement.variable.attribute);
        return Ok(unknown(what, context));
    };
    let published = context.published(&variable).map(|value| (value, context.now()));
    let newest = || {
        let sample = context.histories().get(&variable).and_then(|history| history.newest())?;
        Some((sample.value.clone(), sample.at))
    };
    let Some((value, at)) = published.or_else(newest) else {
        return Ok(unknown(format!("sample of {variable}"), context));
    };
    let mut bindings = Bindings::new();
    let reading = RightSide::Value(unit_of(&measurement.variable.attribute, context.library()));
    let place = condition.place;
    let holds = all(&measurement.value, &value, reading, &mut bindings, context, place)?
        && all(&measurement.object, &variable.object, RightSide::Value(None), &mut bindings, context, place)?;
    let evidence = EvidenceList::one(Evidence::Sample { variable, value, at });
    Ok(Present { truth: Some(holds), evidence })
}

/// Returns an unknown verdict with the names of the missing data.
fn unknown(what: String, context: &dyn EvalContext) -> Present {
    Present { truth: None, evidence: EvidenceList::one(Evidence::Absence { what, at: context.now() }) }
}

/// Returns the verdict for a step without a task, because its procedure has not begun.
fn no_task(tag: &Symbol, context: &dyn EvalContext) -> Present {
    unknown(format!("task of ?{tag}"), context)
}

fn of_task(
    condition: &Condition,
    task: &Expr,
    wanted: &Pattern,
    context: &dyn EvalContext,
) -> Result<Present, EvaluationError> {
    if let ExprKind::Variable { name, .. } = &task.kind
        && context.variable(name).is_none()
    {
        return Ok(no_task(name, context));
    }
    let Value::Task(task) = evaluate(task, context)? else {
        return Err(error(condition, "no task is named here".into()));
    };
    let state = context.task_state(task).map_or("terminated", |state| state.word());
    let mut holds = false;
    for word in std::iter::once(&state).chain(context.task_outcome(task).unwrap_or_default()) {
        holds |= match_pattern(wanted, &Value::symbol(word), &mut Bindings::new(), context, condition.place)?;
    }
    let evidence = Evidence::TaskState { task, state: Value::symbol(state), at: context.now() };
    Ok(Present { truth: Some(holds), evidence: EvidenceList::one(evidence) })
}

/// Adds the variables and tasks that the condition reads.
pub(crate) fn add_reads(condition: &Condition, reads: &mut Reads) {
    match &condition.kind {
        ConditionKind::Measurement(measurement) => {
            let fixed = measurement.value.iter().chain(&measurement.object).all(is_fixed);
            reads.more |= !fixed || !is_literal(&measurement.variable.object);
            reads.attributes.insert(measurement.variable.attribute.clone());
        }
        ConditionKind::Not(part) => add_reads(part, reads),
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) => {
            parts.iter().for_each(|part| add_reads(part, reads));
        }
        _ => reads.more = true,
    }
}

fn is_literal(pattern: &Pattern) -> bool {
    match pattern {
        Pattern::Literal(_) => true,
        Pattern::List(parts) => parts.iter().all(is_literal),
        _ => false,
    }
}

fn is_fixed(constraint: &Constraint) -> bool {
    let constant = |expr: &Expr| matches!(expr.kind, ExprKind::Constant(_));
    match constraint {
        Constraint::Compare { right, tolerance, .. } => constant(right) && tolerance.as_ref().is_none_or(constant),
        Constraint::Matches(pattern) => matches!(pattern, Pattern::Literal(_)),
        Constraint::Range(low, high) => low.iter().chain(high).all(constant),
        Constraint::Predicate(..) => false,
    }
}

//! Monitor creation (M&I)
//! What: makes the monitor of a condition: a tree of parts, each with its window and its memory.
//! Runs: when a task is created or a clause becomes active.
//! Reads: the condition, histories, evaluation context.
//! Writes: a new monitor.
//! Bound: linear in the condition and in the remembered evidence within its window.
//! PDL: all conditions.
//! Paper: section IV, creating monitors from PDL specifications.

use crate::expression::arithmetic::duration;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::basic::time_conditions::{self, TimeForm};
use crate::monitoring::basic::{event, measurement, task_state};
use crate::monitoring::combination::condition_names::collect;
use crate::monitoring::combination::{absence, conjunction_firsts, conjunction_pairs, order_span, point_order, replay};
use crate::monitoring::episodes::episode;
use crate::monitoring::memory::reach;
use crate::monitoring::numbers::{cyclic, persistence, regression, statistics};
use crate::monitoring::part::{ConditionFaults, noting_limits};
use crate::monitoring::sampled::Sampled;
use crate::state::monitors::monitor::{
    AbsentPart, AllenPart, Composite, EventPart, FunctionPart, Keep, Part, PartKind, RelationSide, TaskEndedPart,
    TaskStatePart, TimePart, Window,
};
use apex_model::condition::{Condition, ConditionKind, Constraint, EpisodeCondition, Estimation, MeasurementCondition};
use apex_model::expression::Expr;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Role of a part within the whole.
#[derive(Clone, Copy)]
struct Role {
    window: Window,
    keep: Keep,
    any_pair: bool,
    /// True if ends and states of tasks count even if they were reached before the window.
    standing: bool,
    /// Whole runs are required: a run that later samples may invalidate is judged when it is over.
    whole_runs: bool,
    /// Only the first result for each set of bindings is requested.
    first_only: bool,
}

/// Returns the tree for `condition`, before it has looked back. With `standing`, ends and states that tasks have already reached count.
///
/// # Errors
/// When an expression that must be known now cannot be evaluated, or the construct is not supported.
pub(crate) fn tree(
    condition: &Condition,
    window: Window,
    (keep, standing): (Keep, bool),
    context: &dyn EvalContext,
) -> Result<Part, EvaluationError> {
    part(condition, Role { window, keep, any_pair: false, standing, whole_runs: false, first_only: true }, context)
}

fn part(condition: &Condition, role: Role, context: &dyn EvalContext) -> Result<Part, EvaluationError> {
    let mut window = role.window;
    let whole_past = Window { start: Time::BEGINNING, ..role.window };
    // Where an earliest time is written out, older evidence cannot count, and need not be remembered.
    let past = |limits: &mut dyn Iterator<Item = &Constraint>| {
        let limits: Vec<Constraint> = limits.cloned().collect();
        let span = reach::of_constraints(&limits, context.library());
        Window { start: span.map_or(Time::BEGINNING, |span| context.now() - span), ..role.window }
    };
    let kind = match &condition.kind {
        ConditionKind::Measurement(measurement) => {
            if !measurement.timestamp.is_empty() {
                window = past(&mut measurement.timestamp.iter());
            }
            measured(measurement, context)?
        }
        ConditionKind::Episode(episode) => {
            if !episode.timing.start.is_empty() || !episode.timing.end.is_empty() {
                window = whole_past;
            }
            of_run(episode, role, context)?
        }
        ConditionKind::Event { pattern, timing } => {
            if !timing.start.is_empty() || !timing.end.is_empty() {
                window = past(&mut timing.start.iter().chain(&timing.end));
            }
            let (pattern, timing) = (Arc::clone(pattern), Arc::clone(timing));
            PartKind::Event(Box::new(EventPart { pattern, timing, blind: false, settled: Vec::new() }))
        }
        ConditionKind::TaskEnded(variable) => {
            let (variable, standing) = (variable.clone(), role.standing);
            PartKind::TaskEnded(Box::new(TaskEndedPart { variable, standing, task: None, ended: None }))
        }
        ConditionKind::TaskState { task, state } => PartKind::TaskState(Box::new(TaskStatePart {
            expression: task.clone(),
            state: state.clone(),
            standing: role.standing,
            task: None,
            settled: Vec::new(),
        })),
        ConditionKind::And(parts, constraints) => {
            PartKind::And(Box::new(composite(parts, constraints, role, false, context)?))
        }
        ConditionKind::Or(parts, constraints) => {
            PartKind::Or(Box::new(alternatives(parts, constraints, role, context)?))
        }
        ConditionKind::InOrder(parts, constraints) => {
            PartKind::InOrder(Box::new(composite(parts, constraints, role, true, context)?))
        }
        ConditionKind::Not(inner) => PartKind::Not(Box::new(part(inner, Role { first_only: false, ..role }, context)?)),
        ConditionKind::Timestamp(from, to) => {
            PartKind::Timestamp(time_part((from, to.as_ref()), TimeForm::Timestamp, window.start, context)?)
        }
        ConditionKind::Delay(from, to) => {
            PartKind::Delay(time_part((from, to.as_ref()), TimeForm::Delay, window.start, context)?)
        }
        ConditionKind::Allen { .. } => PartKind::Allen(Box::new(allen(condition, role, context)?)),
        ConditionKind::Absent(inner, length) => PartKind::Absent(Box::new(absent(inner, length, role, context)?)),
        ConditionKind::Function(expression) => {
            let expression = expression.clone();
            PartKind::Function(Box::new(FunctionPart { expression, value: None, holds: None }))
        }
        ConditionKind::Cyclic(wanted) => PartKind::Cyclic(Box::new(cyclic::create(wanted, context)?)),
        // Task control pursues the goals of the probing; the monitor watches only the inner condition.
        ConditionKind::Probing { condition, .. } => return part(condition, role, context),
    };
    Ok(Part { tag: condition.tag.clone(), place: condition.place, window, keep: role.keep, forgotten: false, kind })
}

fn absent(
    inner: &Condition,
    length: &Expr,
    role: Role,
    context: &dyn EvalContext,
) -> Result<AbsentPart, EvaluationError> {
    let whole = Role { keep: Keep::Every, any_pair: false, whole_runs: true, first_only: false, ..role };
    let mut names = BTreeSet::new();
    collect(inner, &mut names);
    // Another part that evaluates the past again may need messages that the history has dropped.
    let alone = !role.whole_runs && names.iter().all(|name| context.variable(name).is_some());
    let mut absent = absence::create(part(inner, whole, context)?, length, role.window.start, context)?;
    if let PartKind::InOrder(order) = &absent.part.kind
        && alone
    {
        let order = point_order::create(order, false, context);
        absent.order = order.and_then(|order| order_span::create(&absent.part, *order));
    }
    Ok(absent)
}

fn allen(condition: &Condition, role: Role, context: &dyn EvalContext) -> Result<AllenPart, EvaluationError> {
    let ConditionKind::Allen { relation, parts, tolerance, constraints } = &condition.kind else {
        return Err(EvaluationError { message: "this is not a relation in time".into(), place: condition.place });
    };
    let tolerance = match tolerance {
        Some(tolerance) => {
            let value = evaluate(tolerance, context)?;
            duration(&value).map_err(|message| EvaluationError { message, place: tolerance.place })?
        }
        None => Duration::ZERO,
    };
    let inner = Role { keep: Keep::Every, any_pair: false, whole_runs: true, first_only: false, ..role };
    Ok(AllenPart {
        relation: *relation,
        tolerance,
        shares: !shared_variables(parts, context).is_empty(),
        sides: vec![RelationSide::default(); parts.len()],
        parts: parts.iter().map(|each| part(each, inner, context)).collect::<Result<_, _>>()?,
        constraints: constraints.clone(),
        found: Vec::new(),
        passing: Vec::new(),
        undecided: false,
        decides_at: None,
    })
}

fn measured(measurement: &Arc<MeasurementCondition>, context: &dyn EvalContext) -> Result<PartKind, EvaluationError> {
    Ok(match &measurement.estimation {
        None => PartKind::Measurement(Box::new(measurement::create(measurement, context)?)),
        Some(Estimation::Persist(timeout)) => {
            PartKind::Persisted(Box::new(persistence::create(measurement, timeout.as_ref(), context)?))
        }
        Some(Estimation::LinearRegression(options)) => {
            PartKind::Regression(Box::new(regression::create(measurement, options, context)?))
        }
    })
}

fn of_run(episode: &Arc<EpisodeCondition>, role: Role, context: &dyn EvalContext) -> Result<PartKind, EvaluationError> {
    Ok(if episode.stats.is_empty() && episode.trend.is_empty() {
        let mut part = episode::create(episode, role.any_pair || episode.any, context)?;
        part.at_close |= role.whole_runs && !episode.last_value.is_empty();
        PartKind::Episode(Box::new(part))
    } else {
        PartKind::Statistical(Box::new(statistics::create(episode, context)?))
    })
}

fn time_part(
    (from, to): (&Expr, Option<&Expr>),
    kind: TimeForm,
    start: Time,
    context: &dyn EvalContext,
) -> Result<Box<TimePart>, EvaluationError> {
    let part = TimePart { from: from.clone(), to: to.cloned(), span: None, reached: None, taken: false };
    time_conditions::check(&part, kind, start, context)?;
    Ok(Box::new(part))
}

fn composite(
    parts: &[Condition],
    constraints: &[Expr],
    role: Role,
    ordered: bool,
    context: &dyn EvalContext,
) -> Result<Composite, EvaluationError> {
    let shared = shared_variables(parts, context);
    let combines = ordered || !constraints.is_empty() || !shared.is_empty();
    let keep = if combines { Keep::Every } else { role.keep };
    let delayed = ordered && parts.iter().any(|part| matches!(part.kind, ConditionKind::Delay(..)));
    let mut names = BTreeSet::new();
    parts.iter().for_each(|part| collect(part, &mut names));
    let first_only = role.first_only && conjunction_firsts::tags_are_distinct(parts, &names);
    let unconstrained = first_only && constraints.is_empty();
    let within = Role { keep, any_pair: role.any_pair || delayed, first_only: unconstrained && !ordered, ..role };
    let made = parts.iter().map(|each| part(each, within, context)).collect::<Result<_, _>>()?;
    let constraints = constraints.to_vec();
    let mut composite =
        Composite { parts: made, constraints, combines, shared, order: None, sweep_at: None, pairs: Vec::new() };
    if first_only && ordered {
        let binds = names.iter().any(|name| context.variable(name).is_none());
        composite.order = point_order::create(&composite, binds, context);
        if composite.order.is_some() {
            composite.parts.iter_mut().for_each(point_order::keep_points);
        }
    } else if let Some(pairs) = conjunction_pairs::create(&composite, parts, context).filter(|_| first_only) {
        composite.pairs = pairs;
        composite.sweep_at = Some(conjunction_firsts::SWEEP_AT_LEAST);
    } else if unconstrained {
        composite.sweep_at = Some(conjunction_firsts::SWEEP_AT_LEAST);
    }
    Ok(composite)
}

fn alternatives(
    parts: &[Condition],
    constraints: &[Expr],
    role: Role,
    context: &dyn EvalContext,
) -> Result<Composite, EvaluationError> {
    let combines = !constraints.is_empty();
    let keep = if combines { Keep::Every } else { role.keep };
    let role = Role { keep, first_only: role.first_only && constraints.is_empty(), ..role };
    let parts = parts.iter().map(|each| part(each, role, context)).collect::<Result<_, _>>()?;
    let constraints = constraints.to_vec();
    Ok(Composite { parts, constraints, combines, shared: Vec::new(), order: None, sweep_at: None, pairs: Vec::new() })
}

/// Returns the unbound variables that occur in more than one part.
fn shared_variables(parts: &[Condition], context: &dyn EvalContext) -> Vec<Symbol> {
    let (mut seen, mut shared) = (BTreeSet::new(), BTreeSet::new());
    for part in parts {
        let mut own = BTreeSet::new();
        collect(part, &mut own);
        own.retain(|name| context.variable(name).is_none());
        shared.extend(own.intersection(&seen).copied());
        seen.extend(own);
    }
    shared.into_iter().cloned().collect()
}

/// Lets every part look back over the remembered data since the start of its window.
pub(crate) fn backfill(part: &mut Part, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    noting_limits(part, troubles, |part, troubles| backfill_kind(part, context, troubles));
}

fn backfill_kind(part: &mut Part, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    let site = crate::monitoring::part::site(part);
    match &mut part.kind {
        PartKind::Measurement(leaf) => leaf.backfill(site, context, troubles),
        PartKind::Episode(leaf) => episode::backfill(leaf, site, context, troubles),
        PartKind::Persisted(leaf) => leaf.backfill(site, context, troubles),
        PartKind::Regression(leaf) => leaf.backfill(site, context, troubles),
        PartKind::Statistical(leaf) => leaf.backfill(site, context, troubles),
        PartKind::Cyclic(leaf) => leaf.backfill(site, context, troubles),
        PartKind::Event(leaf) => event::backfill(leaf, site, context, troubles),
        PartKind::TaskEnded(leaf) => task_state::advance_ended(leaf, context),
        PartKind::TaskState(leaf) => task_state::advance_state(leaf, site, context, troubles),
        PartKind::Timestamp(leaf) => {
            time_conditions::advance(leaf, time_conditions::TimeForm::Timestamp, site, context)
        }
        PartKind::Delay(leaf) => time_conditions::advance(leaf, time_conditions::TimeForm::Delay, site, context),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| backfill(part, context, troubles));
        }
        PartKind::Not(inner) => backfill(inner, context, troubles),
        PartKind::Allen(leaf) => {
            // This pass reports data that are no longer remembered; afterwards everything is evaluated in order of time.
            leaf.parts.iter_mut().for_each(|part| backfill(part, context, troubles));
            replay::replay(part, None, context, troubles);
        }
        PartKind::Absent(leaf) => {
            backfill(&mut leaf.part, context, troubles);
            replay::replay(part, None, context, troubles);
        }
        PartKind::Function(_) => {}
    }
}

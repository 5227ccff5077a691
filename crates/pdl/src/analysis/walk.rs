//! Walks over nested expressions, nested conditions, and everything in a definition.

use apex_model::condition::{Condition, ConditionKind, Constraint, Estimation, Quality, Timing, VariablePattern};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{
    Activity, Hooks, Primitive, PriorityClause, Procedure, Repetition, ResourceNeed, Step, Transitions,
};
use apex_model::source::Place;
use apex_model::symbol::Symbol;

/// Receives every expression, outer ones before inner ones.
pub(crate) type Visit<'v, 'l> = &'v mut dyn FnMut(&'l Expr);

/// Visits the expression and everything inside of it.
pub(crate) fn expr<'l>(root: &'l Expr, visit: Visit<'_, 'l>) {
    visit(root);
    match &root.kind {
        ExprKind::Call { arguments: parts, .. }
        | ExprKind::And(parts)
        | ExprKind::Or(parts)
        | ExprKind::Sequence(parts) => exprs(parts, visit),
        ExprKind::Lambda { body, .. } => exprs(body, visit),
        ExprKind::If(test, then, otherwise) => {
            expr(test, visit);
            expr(then, visit);
            otherwise.iter().for_each(|part| expr(part, visit));
        }
        ExprKind::Cond(rows) => rows.iter().for_each(|(test, body)| {
            expr(test, visit);
            exprs(body, visit);
        }),
        ExprKind::Case(key, rows) => {
            expr(key, visit);
            rows.iter().for_each(|(_, body)| exprs(body, visit));
        }
        ExprKind::Let { bindings, body, .. } => {
            bindings.iter().for_each(|(_, value)| expr(value, visit));
            exprs(body, visit);
        }
        ExprKind::Assign { value, .. } => expr(value, visit),
        ExprKind::Template(inner) => template(inner, visit),
        _ => {}
    }
}

/// Visits every expression of a body.
pub(crate) fn exprs<'l>(parts: impl IntoIterator<Item = &'l Expr>, visit: Visit<'_, 'l>) {
    parts.into_iter().for_each(|part| expr(part, visit));
}

/// Visits every expression of a datum with holes.
pub(crate) fn template<'l>(root: &'l Template, visit: Visit<'_, 'l>) {
    match root {
        Template::Constant(_) => {}
        Template::Hole(inner) | Template::Splice(inner) => expr(inner, visit),
        Template::List(parts) => parts.iter().for_each(|part| template(part, visit)),
    }
}

/// Visits every expression of a pattern.
pub(crate) fn pattern<'l>(root: &'l Pattern, visit: Visit<'_, 'l>) {
    match root {
        Pattern::Computed(inner) | Pattern::Guard(inner) => expr(inner, visit),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter().for_each(|part| pattern(part, visit));
        }
        Pattern::Not(part) => pattern(part, visit),
        _ => {}
    }
}

/// Returns the parts of a condition that is made of conditions.
pub(crate) fn parts(condition: &Condition) -> &[Condition] {
    match &condition.kind {
        ConditionKind::And(parts, _)
        | ConditionKind::Or(parts, _)
        | ConditionKind::InOrder(parts, _)
        | ConditionKind::Allen { parts, .. } => parts,
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => std::slice::from_ref(part),
        ConditionKind::Probing { condition, .. } => std::slice::from_ref(condition),
        _ => &[],
    }
}

/// Visits the condition and all conditions inside of it.
pub(crate) fn conditions<'l>(root: &'l Condition, visit: &mut dyn FnMut(&'l Condition)) {
    visit(root);
    parts(root).iter().for_each(|part| conditions(part, visit));
}

/// Visits every expression of a condition, those of its parts included.
pub(crate) fn condition<'l>(root: &'l Condition, visit: Visit<'_, 'l>) {
    match &root.kind {
        ConditionKind::Measurement(measurement) => {
            pattern(&measurement.variable.object, visit);
            constraints(&measurement.value, visit);
            constraints(&measurement.object, visit);
            constraints(&measurement.timestamp, visit);
            match &measurement.estimation {
                Some(Estimation::Persist(timeout)) => exprs(timeout, visit),
                Some(Estimation::LinearRegression(options)) => options.iter().for_each(|(_, part)| expr(part, visit)),
                None => {}
            }
        }
        ConditionKind::Episode(episode) => {
            if let Quality::MaximumGap(gap) = &episode.quality {
                expr(gap, visit);
            }
            pattern(&episode.variable.object, visit);
            for each in [&episode.value, &episode.first_value, &episode.last_value, &episode.object] {
                constraints(each, visit);
            }
            timing(&episode.timing, visit);
            episode.stats.iter().chain(&episode.trend).for_each(|(_, each)| constraints(each, visit));
        }
        ConditionKind::And(_, tests) | ConditionKind::Or(_, tests) | ConditionKind::InOrder(_, tests) => {
            exprs(tests, visit);
        }
        ConditionKind::Allen { tolerance, constraints, .. } => exprs(tolerance.iter().chain(constraints), visit),
        ConditionKind::Absent(_, span) => expr(span, visit),
        ConditionKind::Delay(first, last) | ConditionKind::Timestamp(first, last) => {
            exprs(std::iter::once(first).chain(last), visit);
        }
        ConditionKind::Event { pattern: form, timing: limits } => {
            pattern(form, visit);
            timing(limits, visit);
        }
        ConditionKind::TaskState { task, state } => {
            expr(task, visit);
            pattern(state, visit);
        }
        ConditionKind::Function(test) => expr(test, visit),
        ConditionKind::Probing { goal, interval, time_limit, count_limit, .. } => {
            template(goal, visit);
            exprs(std::iter::once(interval).chain(time_limit).chain(count_limit), visit);
        }
        ConditionKind::Cyclic(cyclic) => pattern(&cyclic.variable.object, visit),
        ConditionKind::TaskEnded(_) | ConditionKind::Not(_) => {}
    }
    options(&root.kind).iter().for_each(|(_, each)| constraints(each, visit));
    parts(root).iter().for_each(|part| condition(part, visit));
}

/// Returns the constraints of a condition by the names of its options; empty for conditions whose constraints have fields.
pub(crate) fn options(kind: &ConditionKind) -> &[(Symbol, Vec<Constraint>)] {
    match kind {
        ConditionKind::Cyclic(cyclic) => &cyclic.options,
        _ => &[],
    }
}

fn timing<'l>(timing: &'l Timing, visit: Visit<'_, 'l>) {
    for each in [&timing.start, &timing.end, &timing.duration] {
        constraints(each, visit);
    }
}

/// Visits every expression of constraints.
pub(crate) fn constraints<'l>(all: &'l [Constraint], visit: Visit<'_, 'l>) {
    for each in all {
        match each {
            Constraint::Compare { right, tolerance, .. } => exprs(std::iter::once(right).chain(tolerance), visit),
            Constraint::Matches(inner) => pattern(inner, visit),
            Constraint::Predicate(_, arguments) => exprs(arguments, visit),
            Constraint::Range(low, high) => exprs(low.iter().chain(high), visit),
        }
    }
}

/// Visits every expression of an activity.
pub(crate) fn activity<'l>(root: &'l Activity, visit: Visit<'_, 'l>) {
    match root {
        Activity::Goal(goal) => template(goal, visit),
        Activity::Terminate { task, outcome, value } => {
            exprs([task, outcome, value].into_iter().filter_map(|part| part.as_deref()), visit);
        }
        Activity::BuiltIn(_, arguments) => exprs(arguments, visit),
    }
}

/// Returns the activities of a step: its own and that after a failure.
pub(crate) fn activities(step: &Step) -> impl Iterator<Item = &Activity> {
    std::iter::once(&step.activity).chain(step.on_failure.as_deref())
}

/// Returns the conditions of transition clauses with the clauses' names.
pub(crate) fn transitions(transitions: &Transitions) -> impl Iterator<Item = (&'static str, &Condition)> {
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
    } = transitions;
    [
        ("end-when", end_when),
        ("restart-when", restart_when),
        ("resume-when", resume_when),
        ("suspend-when", suspend_when),
        ("suspend-when", suspend_until),
        ("skip-when", skip_when),
        ("exit-when", exit_when),
        ("precondition", precondition),
        ("invariant", invariant),
    ]
    .into_iter()
    .filter_map(|(name, condition)| condition.as_deref().map(|condition| (name, condition)))
}

/// Returns the hooks with their names.
pub(crate) fn hooks(hooks: &Hooks) -> [(&'static str, &[Expr]); 4] {
    [
        ("on-start", &hooks.on_start),
        ("on-end", &hooks.on_end),
        ("on-suspend", &hooks.on_suspend),
        ("on-resume", &hooks.on_resume),
    ]
}

/// Returns the expressions of `repeating` and `responding`.
pub(crate) fn repetition(clause: &Repetition) -> impl Iterator<Item = &Expr> {
    let Repetition { while_true, until, enabled, recovery, minimum_interval, for_new: _, drop_missed: _ } = clause;
    [while_true, until, enabled, recovery, minimum_interval].into_iter().flatten()
}

/// Returns the expressions of priority clauses.
pub(crate) fn priorities(clauses: &[PriorityClause]) -> impl Iterator<Item = &Expr> {
    clauses.iter().flat_map(|clause| match clause {
        PriorityClause::Number(number) => vec![number],
        PriorityClause::UrgencyImportance(urgency, importance) => vec![urgency, importance],
    })
}

/// Visits every expression of a profile.
pub(crate) fn profile<'l>(needs: &'l [ResourceNeed], visit: Visit<'_, 'l>) {
    for need in needs {
        template(&need.resource, visit);
        exprs(&need.amount, visit);
    }
}

/// Visits every expression of a step.
pub(crate) fn step<'l>(step: &'l Step, visit: Visit<'_, 'l>) {
    activity(&step.activity, visit);
    step.on_failure.iter().for_each(|handler| activity(handler, visit));
    step.binds.iter().for_each(|result| pattern(result, visit));
    step.waitfor.iter().for_each(|each| condition(each, visit));
    exprs(step.select.iter().chain(step.forall.as_deref()).map(|(_, value)| value), visit);
    exprs(priorities(&step.priority).chain(step.rank.as_deref()).chain(step.interrupt_cost.as_deref()), visit);
    exprs(step.repeating.iter().chain(&step.responding).flat_map(|clause| repetition(clause)), visit);
    profile(&step.profile, visit);
    transitions(&step.transitions).for_each(|(_, each)| condition(each, visit));
    hooks(&step.hooks).into_iter().for_each(|(_, forms)| exprs(forms, visit));
}

/// Visits every expression of a procedure, its steps included.
pub(crate) fn procedure<'l>(procedure: &'l Procedure, visit: Visit<'_, 'l>) {
    pattern(&procedure.index, visit);
    profile(&procedure.profile, visit);
    procedure.log.iter().for_each(|policy| template(&policy.subject, visit));
    exprs(procedure.expected_duration.iter().chain(&procedure.interrupt_cost), visit);
    transitions(&procedure.transitions).for_each(|(_, each)| condition(each, visit));
    hooks(&procedure.hooks).into_iter().for_each(|(_, forms)| exprs(forms, visit));
    procedure.steps.iter().for_each(|each| step(each, visit));
}

/// Visits every expression of a primitive.
pub(crate) fn primitive<'l>(primitive: &'l Primitive, visit: Visit<'_, 'l>) {
    pattern(&primitive.index, visit);
    profile(&primitive.profile, visit);
    exprs(primitive.locals.iter().map(|(_, value)| value), visit);
    exprs(primitive.duration.iter().chain(&primitive.returns).chain(&primitive.on_completion), visit);
    if let Some((interval, forms)) = &primitive.update {
        exprs(interval.iter().chain(forms), visit);
    }
    hooks(&primitive.hooks).into_iter().for_each(|(_, forms)| exprs(forms, visit));
}

/// Visits every expression of a library.
pub(crate) fn library<'l>(library: &'l Library, visit: Visit<'_, 'l>) {
    library.procedures.iter().for_each(|each| procedure(each, visit));
    library.primitives.iter().for_each(|each| primitive(each, visit));
    library.functions.values().for_each(|function| exprs(&function.body, visit));
    exprs(library.indexicals.values(), visit);
    for solver in &library.solvers {
        pattern(&solver.index, visit);
        exprs(&solver.budget, visit);
        solver.meanwhile.iter().for_each(|goal| template(goal, visit));
    }
}

/// Visits every goal that is pursued while a condition of the procedure is waited for, with the condition's place.
pub(crate) fn probes<'l>(procedure: &'l Procedure, visit: &mut dyn FnMut(Place, &'l Template)) {
    conditions_of(procedure, &mut |condition| {
        if let ConditionKind::Probing { goal, .. } = &condition.kind {
            visit(condition.place, goal);
        }
    });
}

/// Returns the state variable that a condition watches; `None` if it watches something else.
pub(crate) fn variable_of(condition: &Condition) -> Option<&VariablePattern> {
    match &condition.kind {
        ConditionKind::Measurement(measurement) => Some(&measurement.variable),
        ConditionKind::Episode(episode) => Some(&episode.variable),
        ConditionKind::Cyclic(cyclic) => Some(&cyclic.variable),
        _ => None,
    }
}

/// Visits every condition of a procedure, outer ones before inner ones.
pub(crate) fn conditions_of<'l>(procedure: &'l Procedure, visit: &mut dyn FnMut(&'l Condition)) {
    transitions(&procedure.transitions).for_each(|(_, each)| conditions(each, visit));
    for step in &procedure.steps {
        step.waitfor.iter().for_each(|each| conditions(each, visit));
        transitions(&step.transitions).for_each(|(_, each)| conditions(each, visit));
    }
}

/// Functions whose first argument is the attribute of a state variable.
pub(crate) const QUERIES: &[&str] = &[
    "current-value",
    "value-at",
    "value-before",
    "most-recent-svvalue",
    "samples-over",
    "mean-over",
    "min-over",
    "max-over",
];

/// Returns the expressions to which a constraint compares a value.
pub(super) fn sides(constraint: &Constraint) -> Vec<&Expr> {
    match constraint {
        Constraint::Compare { right, tolerance, .. } => std::iter::once(right).chain(tolerance).collect(),
        Constraint::Range(low, high) => low.iter().chain(high).collect(),
        Constraint::Matches(_) | Constraint::Predicate(..) => Vec::new(),
    }
}

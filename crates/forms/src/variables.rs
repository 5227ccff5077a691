//! Pattern variables mentioned in a clause; they determine the information dependencies between steps.

use apex_model::condition::{
    Condition, ConditionKind, Constraint, EpisodeCondition, Estimation, MeasurementCondition, Timing,
};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::pattern::Pattern;
use apex_model::procedure::Activity;
use apex_model::symbol::Symbol;

/// Receives every occurrence of a variable, in textual order.
type Sink<'a> = &'a mut dyn FnMut(&Symbol);

/// Passes the variables of an expression to `sink`.
pub fn of_expr(expr: &Expr, sink: Sink<'_>) {
    match &expr.kind {
        ExprKind::Constant(_)
        | ExprKind::Local(_)
        | ExprKind::Indexical(_)
        | ExprKind::Named(_)
        | ExprKind::FunctionName(_) => {}
        ExprKind::Variable { name, .. } => sink(name),
        ExprKind::Call { arguments: parts, .. }
        | ExprKind::And(parts)
        | ExprKind::Or(parts)
        | ExprKind::Sequence(parts) => of_exprs(parts, sink),
        ExprKind::Lambda { parameters, body } => {
            parameters.optional.iter().filter_map(|(_, default)| default.as_ref()).for_each(|each| of_expr(each, sink));
            of_exprs(body, sink);
        }
        ExprKind::If(test, then, otherwise) => {
            of_expr(test, sink);
            of_expr(then, sink);
            otherwise.iter().for_each(|each| of_expr(each, sink));
        }
        ExprKind::Cond(rows) => rows.iter().for_each(|(test, body)| {
            of_expr(test, sink);
            of_exprs(body, sink);
        }),
        ExprKind::Case(key, rows) => {
            of_expr(key, sink);
            rows.iter().for_each(|(_, body)| of_exprs(body, sink));
        }
        ExprKind::Let { bindings, body, .. } => {
            bindings.iter().for_each(|(_, value)| of_expr(value, sink));
            of_exprs(body, sink);
        }
        ExprKind::Assign { name, of_task, value } => {
            if *of_task {
                sink(name);
            }
            of_expr(value, sink);
        }
        ExprKind::Template(template) => of_template(template, sink),
    }
}

fn of_exprs(parts: &[Expr], sink: Sink<'_>) {
    parts.iter().for_each(|part| of_expr(part, sink));
}

/// Passes the variables of a template to `sink`.
pub fn of_template(template: &Template, sink: Sink<'_>) {
    match template {
        Template::Constant(_) => {}
        Template::Hole(expr) | Template::Splice(expr) => of_expr(expr, sink),
        Template::List(parts) => parts.iter().for_each(|part| of_template(part, sink)),
    }
}

/// Passes the variables of a pattern to `sink`, including those that it may bind.
pub fn of_pattern(pattern: &Pattern, sink: Sink<'_>) {
    match pattern {
        Pattern::Literal(_) | Pattern::Anonymous => {}
        Pattern::Variable(name) | Pattern::BoundVariable(name) => sink(name),
        Pattern::Is { variable, .. } => sink(variable),
        Pattern::Computed(expr) | Pattern::Guard(expr) => of_expr(expr, sink),
        Pattern::Segment { variable, .. } => variable.iter().for_each(sink),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter().for_each(|part| of_pattern(part, sink));
        }
        Pattern::Not(part) => of_pattern(part, sink),
    }
}

/// Passes the variables of an activity to `sink`.
pub fn of_activity(activity: &Activity, sink: Sink<'_>) {
    match activity {
        Activity::Goal(template) => of_template(template, sink),
        Activity::Terminate { task, outcome, value } => {
            [task, outcome, value].into_iter().flatten().for_each(|part| of_expr(part, sink));
        }
        Activity::BuiltIn(_, arguments) => of_exprs(arguments, sink),
    }
}

/// Passes the variables of a condition to `sink`.
pub fn of_condition(condition: &Condition, sink: Sink<'_>) {
    match &condition.kind {
        ConditionKind::Measurement(measurement) => of_measurement(measurement, sink),
        ConditionKind::Episode(episode) => of_episode(episode, sink),
        ConditionKind::And(parts, constraints)
        | ConditionKind::Or(parts, constraints)
        | ConditionKind::InOrder(parts, constraints) => of_parts(parts, constraints, sink),
        ConditionKind::Allen { parts, tolerance, constraints, .. } => {
            of_parts(parts, constraints, sink);
            tolerance.iter().for_each(|part| of_expr(part, sink));
        }
        ConditionKind::Not(part) => of_condition(part, sink),
        ConditionKind::Absent(part, span) => {
            of_condition(part, sink);
            of_expr(span, sink);
        }
        ConditionKind::Delay(first, last) | ConditionKind::Timestamp(first, last) => {
            of_expr(first, sink);
            last.iter().for_each(|part| of_expr(part, sink));
        }
        ConditionKind::Event { pattern, timing } => {
            of_pattern(pattern, sink);
            of_timing(timing, sink);
        }
        ConditionKind::TaskEnded(task) => sink(task),
        ConditionKind::TaskState { task, state } => {
            of_expr(task, sink);
            of_pattern(state, sink);
        }
        ConditionKind::Function(expr) => of_expr(expr, sink),
        ConditionKind::Probing { condition, goal, interval, time_limit, count_limit } => {
            of_condition(condition, sink);
            of_template(goal, sink);
            [Some(interval), time_limit.as_ref(), count_limit.as_ref()]
                .into_iter()
                .flatten()
                .for_each(|part| of_expr(part, sink));
        }
        ConditionKind::Cyclic(cyclic) => {
            of_pattern(&cyclic.variable.object, sink);
            cyclic.options.iter().for_each(|(_, constraints)| of_constraints(constraints, sink));
        }
    }
}

fn of_parts(parts: &[Condition], constraints: &[Expr], sink: Sink<'_>) {
    parts.iter().for_each(|part| of_condition(part, sink));
    of_exprs(constraints, sink);
}

fn of_measurement(condition: &MeasurementCondition, sink: Sink<'_>) {
    of_pattern(&condition.variable.object, sink);
    of_constraints(&condition.value, sink);
    of_constraints(&condition.object, sink);
    of_constraints(&condition.timestamp, sink);
    match &condition.estimation {
        Some(Estimation::Persist(timeout)) => timeout.iter().for_each(|part| of_expr(part, sink)),
        Some(Estimation::LinearRegression(options)) => options.iter().for_each(|(_, part)| of_expr(part, sink)),
        None => {}
    }
}

fn of_episode(condition: &EpisodeCondition, sink: Sink<'_>) {
    of_pattern(&condition.variable.object, sink);
    for constraints in [&condition.value, &condition.first_value, &condition.last_value, &condition.object] {
        of_constraints(constraints, sink);
    }
    of_timing(&condition.timing, sink);
    condition.stats.iter().chain(&condition.trend).for_each(|(_, constraints)| of_constraints(constraints, sink));
}

fn of_timing(timing: &Timing, sink: Sink<'_>) {
    for constraints in [&timing.start, &timing.end, &timing.duration] {
        of_constraints(constraints, sink);
    }
}

fn of_constraints(constraints: &[Constraint], sink: Sink<'_>) {
    for constraint in constraints {
        match constraint {
            Constraint::Compare { right, tolerance, .. } => {
                of_expr(right, sink);
                tolerance.iter().for_each(|part| of_expr(part, sink));
            }
            Constraint::Matches(pattern) => of_pattern(pattern, sink),
            Constraint::Predicate(_, arguments) => of_exprs(arguments, sink),
            Constraint::Range(low, high) => {
                low.iter().chain(high.iter()).for_each(|part| of_expr(part, sink));
            }
        }
    }
}

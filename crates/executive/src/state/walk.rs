//! Traversal of expressions: every nested expression, the outer one first.

use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::procedure::Activity;

/// Calls `see` with the expression and all of its parts.
pub fn each(expr: &Expr, see: &mut dyn FnMut(&Expr)) {
    see(expr);
    match &expr.kind {
        ExprKind::Constant(_)
        | ExprKind::Variable { .. }
        | ExprKind::Local(_)
        | ExprKind::Indexical(_)
        | ExprKind::Named(_)
        | ExprKind::FunctionName(_) => {}
        ExprKind::Call { arguments: parts, .. }
        | ExprKind::And(parts)
        | ExprKind::Or(parts)
        | ExprKind::Sequence(parts) => all(parts, see),
        ExprKind::If(test, then, otherwise) => {
            each(test, see);
            each(then, see);
            otherwise.iter().for_each(|part| each(part, see));
        }
        ExprKind::Cond(rows) => rows.iter().for_each(|(test, body)| {
            each(test, see);
            all(body, see);
        }),
        ExprKind::Case(key, rows) => {
            each(key, see);
            rows.iter().for_each(|(_, body)| all(body, see));
        }
        ExprKind::Let { bindings, body, .. } => {
            bindings.iter().for_each(|(_, value)| each(value, see));
            all(body, see);
        }
        ExprKind::Lambda { parameters, body } => {
            parameters.optional.iter().filter_map(|(_, default)| default.as_ref()).for_each(|part| each(part, see));
            all(body, see);
        }
        ExprKind::Assign { value, .. } => each(value, see),
        ExprKind::Template(template) => of_template(template, see),
    }
}

/// Like [`each`], for every expression of an activity.
pub fn each_in_activity(activity: &Activity, see: &mut dyn FnMut(&Expr)) {
    match activity {
        Activity::Goal(template) => of_template(template, see),
        Activity::Terminate { task, outcome, value } => {
            [task, outcome, value].into_iter().flatten().for_each(|part| each(part, see));
        }
        Activity::BuiltIn(_, arguments) => all(arguments, see),
    }
}

fn all(parts: &[Expr], see: &mut dyn FnMut(&Expr)) {
    parts.iter().for_each(|part| each(part, see));
}

fn of_template(template: &Template, see: &mut dyn FnMut(&Expr)) {
    match template {
        Template::Constant(_) => {}
        Template::Hole(expr) | Template::Splice(expr) => each(expr, see),
        Template::List(parts) => parts.iter().for_each(|part| of_template(part, see)),
    }
}

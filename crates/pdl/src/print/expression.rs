//! Expressions, templates and patterns as text.

use super::value::{literal_text, value_text};
use super::{joined, list_text};
use apex_model::expression::{Expr, ExprKind, Parameters, Template};
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Functions whose first argument is a datum with holes.
const FORM_FIRST: &[&str] = &["cogevent", "command", "inform", "publish"];

/// The expression as text.
pub(crate) fn expression_text(expr: &Expr) -> String {
    match &expr.kind {
        ExprKind::Constant(value) => constant_text(value),
        ExprKind::Variable { name, must_be_bound: false } => format!("?{name}"),
        ExprKind::Variable { name, must_be_bound: true } => format!("<?{name}>"),
        ExprKind::Local(name) | ExprKind::Named(name) => name.to_string(),
        ExprKind::Indexical(name) => format!("+{name}+"),
        ExprKind::Call { function, arguments } => call_text(function, arguments),
        ExprKind::If(test, then, otherwise) => {
            let parts = [Some(test), Some(then), otherwise.as_ref()];
            list_text("if", parts.into_iter().flatten().map(|part| expression_text(part)))
        }
        ExprKind::Cond(clauses) => {
            let clause =
                |(test, body): &(Expr, Vec<Expr>)| list_text(&expression_text(test), body.iter().map(expression_text));
            list_text("cond", clauses.iter().map(clause))
        }
        ExprKind::Case(key, clauses) => {
            let clause = |(keys, body): &(Vec<Value>, Vec<Expr>)| {
                let head =
                    if keys.is_empty() { "otherwise".to_string() } else { list_text("", keys.iter().map(value_text)) };
                list_text(&head, body.iter().map(expression_text))
            };
            list_text("case", std::iter::once(expression_text(key)).chain(clauses.iter().map(clause)))
        }
        ExprKind::And(parts) => list_text("and", parts.iter().map(expression_text)),
        ExprKind::Or(parts) => list_text("or", parts.iter().map(expression_text)),
        ExprKind::Let { sequential, bindings, body } => {
            let binding = |(name, value): &(Symbol, Expr)| format!("({name} {})", expression_text(value));
            let bindings = list_text("", bindings.iter().map(binding));
            let head = if *sequential { "let*" } else { "let" };
            list_text(head, std::iter::once(bindings).chain(body.iter().map(expression_text)))
        }
        ExprKind::Lambda { parameters, body } => {
            list_text("lambda", std::iter::once(parameters_text(parameters)).chain(body.iter().map(expression_text)))
        }
        ExprKind::FunctionName(name) => format!("#'{name}"),
        ExprKind::Assign { name, of_task, value } => {
            let mark = if *of_task { "?" } else { "" };
            format!("(setq {mark}{name} {})", expression_text(value))
        }
        ExprKind::Sequence(parts) => list_text("progn", parts.iter().map(expression_text)),
        ExprKind::Template(template) => format!("`{}", template_text(template)),
    }
}

/// The parameters of a function as text.
fn parameters_text(parameters: &Parameters) -> String {
    let mut words: Vec<String> = parameters.required.iter().map(Symbol::to_string).collect();
    if !parameters.optional.is_empty() {
        words.push("&optional".to_string());
    }
    words.extend(parameters.optional.iter().map(|(name, default)| match default {
        Some(default) => format!("({name} {})", expression_text(default)),
        None => name.to_string(),
    }));
    words.extend(parameters.rest.iter().flat_map(|name| ["&rest".to_string(), name.to_string()]));
    list_text("", words)
}

fn call_text(function: &Symbol, arguments: &[Expr]) -> String {
    match arguments.split_first() {
        Some((form, rest)) if FORM_FIRST.contains(&function.folded()) => {
            let first = std::iter::once(form_text(form));
            list_text(function.printed(), first.chain(rest.iter().map(expression_text)))
        }
        _ => list_text(function.printed(), arguments.iter().map(expression_text)),
    }
}

/// An expression that stands where FORM is read.
pub(super) fn form_text(expr: &Expr) -> String {
    match &expr.kind {
        ExprKind::Constant(value) => literal_text(value),
        ExprKind::Template(template) => template_text(template),
        ExprKind::Variable { .. } | ExprKind::Indexical(_) => expression_text(expr),
        _ => format!(",{}", expression_text(expr)),
    }
}

/// A constant as an expression: names and lists are quoted.
fn constant_text(value: &Value) -> String {
    match value {
        Value::Symbol(symbol) if symbol.folded().starts_with(':') || symbol.is("t") => symbol.to_string(),
        Value::List(items) if items.is_empty() => "nil".to_string(),
        Value::Symbol(_) | Value::List(_) => format!("'{}", value_text(value)),
        other => value_text(other),
    }
}

/// An expression on the right side of a comparison, where names stand for themselves.
pub(super) fn operand_text(expr: &Expr) -> String {
    match &expr.kind {
        ExprKind::Constant(value @ Value::Symbol(_)) => literal_text(value),
        _ => expression_text(expr),
    }
}

/// The template as text.
pub(crate) fn template_text(template: &Template) -> String {
    match template {
        Template::Constant(value) => literal_text(value),
        Template::Hole(expr) => match &expr.kind {
            ExprKind::Variable { .. } | ExprKind::Indexical(_) => expression_text(expr),
            _ => format!(",{}", expression_text(expr)),
        },
        Template::Splice(expr) => format!(",@{}", expression_text(expr)),
        Template::List(parts) => list_text("", parts.iter().map(template_text)),
    }
}

/// The pattern as text.
pub(crate) fn pattern_text(pattern: &Pattern) -> String {
    match pattern {
        Pattern::Literal(value) => literal_text(value),
        Pattern::Variable(name) => format!("?{name}"),
        Pattern::BoundVariable(name) => format!("<?{name}>"),
        Pattern::Anonymous => "?".to_string(),
        Pattern::Computed(expr) => match &expr.kind {
            ExprKind::Indexical(_) => expression_text(expr),
            _ => format!(",{}", expression_text(expr)),
        },
        Pattern::List(parts) => list_text("", parts.iter().map(pattern_text)),
        Pattern::Segment { variable, minimum, maximum } => {
            let head = match (minimum, maximum) {
                (0, None) => "?*",
                (_, None) => "?+",
                _ => "??",
            };
            list_text(head, variable.iter().map(|name| format!("?{name}")))
        }
        Pattern::Guard(expr) => format!("(?if {})", expression_text(expr)),
        Pattern::Is { variable, predicate } => format!("(?is ?{variable} {predicate})"),
        Pattern::And(parts) => format!("(?and {})", joined(parts.iter().map(pattern_text))),
        Pattern::Or(parts) => format!("(?or {})", joined(parts.iter().map(pattern_text))),
        Pattern::Not(part) => format!("(?not {})", pattern_text(part)),
    }
}

//! Expressions, templates, patterns and activities as text.

use super::layout::{joined, list_text};
use super::style::Style;
use super::value::value_text;
use apex_model::expression::{Expr, ExprKind, Parameters, Template};
use apex_model::pattern::Pattern;
use apex_model::procedure::Activity;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Functions with a template, a datum with holes, as first argument.
const FORM_FIRST: &[&str] = &["cogevent", "command", "inform", "publish"];

impl Style {
    /// Returns the expression as text.
    pub fn expression(self, expr: &Expr) -> String {
        let text = |expr: &Expr| self.expression(expr);
        match &expr.kind {
            ExprKind::Constant(value) => self.constant(value),
            ExprKind::Variable { name, must_be_bound: false } => format!("?{name}"),
            ExprKind::Variable { name, must_be_bound: true } => format!("<?{name}>"),
            ExprKind::Local(name) | ExprKind::Named(name) => name.to_string(),
            ExprKind::Indexical(name) => format!("+{name}+"),
            ExprKind::Call { function, arguments } => self.call(function, arguments),
            ExprKind::And(parts) => list_text("and", parts.iter().map(text)),
            ExprKind::Or(parts) => list_text("or", parts.iter().map(text)),
            ExprKind::FunctionName(name) => format!("#'{name}"),
            ExprKind::Template(template) => format!("`{}", self.template(template)),
            ExprKind::If(..)
            | ExprKind::Cond(_)
            | ExprKind::Case(..)
            | ExprKind::Let { .. }
            | ExprKind::Lambda { .. }
            | ExprKind::Assign { .. }
            | ExprKind::Sequence(_) => match self {
                Style::Exact => with_body(&expr.kind),
                Style::Brief => without_body(&expr.kind),
            },
        }
    }

    /// Returns a constant as an expression: in exact text, names and lists are quoted.
    fn constant(self, value: &Value) -> String {
        match (self, value) {
            (Style::Brief, Value::List(items)) if !items.is_empty() => format!("'{value}"),
            (Style::Brief, _) => value.to_string(),
            (Style::Exact, Value::Symbol(symbol)) if symbol.folded().starts_with(':') || symbol.is("t") => {
                symbol.to_string()
            }
            (Style::Exact, Value::List(items)) if items.is_empty() => "nil".to_string(),
            (Style::Exact, Value::Symbol(_) | Value::List(_)) => format!("'{}", value_text(value)),
            (Style::Exact, other) => value_text(other),
        }
    }

    fn call(self, function: &Symbol, arguments: &[Expr]) -> String {
        match arguments.split_first() {
            Some((form, rest)) if self == Style::Exact && FORM_FIRST.contains(&function.folded()) => {
                let first = std::iter::once(form_text(form));
                list_text(function.printed(), first.chain(rest.iter().map(|part| self.expression(part))))
            }
            _ => list_text(function.printed(), arguments.iter().map(|part| self.expression(part))),
        }
    }

    /// Returns an expression on the right side of a comparison as text, where names represent themselves.
    pub(super) fn operand(self, expr: &Expr) -> String {
        match &expr.kind {
            ExprKind::Constant(value @ Value::Symbol(_)) => self.literal(value),
            _ => self.expression(expr),
        }
    }

    /// Returns the template as text, with its holes as they are written.
    pub fn template(self, template: &Template) -> String {
        match template {
            Template::Constant(value) => self.literal(value),
            Template::Hole(expr) => match &expr.kind {
                ExprKind::Variable { .. } | ExprKind::Indexical(_) => self.expression(expr),
                _ => self.hole(expr),
            },
            Template::Splice(expr) => format!(",@{}", self.expression(expr)),
            Template::List(parts) => list_text("", parts.iter().map(|part| self.template(part))),
        }
    }

    /// Returns a computed hole: its comma is left out in brief text.
    fn hole(self, expr: &Expr) -> String {
        match self {
            Style::Exact => format!(",{}", self.expression(expr)),
            Style::Brief => self.expression(expr),
        }
    }

    /// Returns the pattern as text.
    pub fn pattern(self, pattern: &Pattern) -> String {
        let text = |part: &Pattern| self.pattern(part);
        match pattern {
            Pattern::Literal(value) => self.literal(value),
            Pattern::Variable(name) => format!("?{name}"),
            Pattern::BoundVariable(name) => format!("<?{name}>"),
            Pattern::Anonymous => "?".to_string(),
            Pattern::Computed(expr) => match &expr.kind {
                ExprKind::Indexical(_) => self.expression(expr),
                _ => self.hole(expr),
            },
            Pattern::List(parts) => list_text("", parts.iter().map(text)),
            Pattern::Segment { variable, minimum, maximum } => {
                let head = match (minimum, maximum) {
                    (0, None) => "?*",
                    (_, None) => "?+",
                    _ => "??",
                };
                list_text(head, variable.iter().map(|name| format!("?{name}")))
            }
            Pattern::Guard(expr) => format!("(?if {})", self.expression(expr)),
            Pattern::Is { variable, predicate } => format!("(?is ?{variable} {predicate})"),
            Pattern::And(parts) => format!("(?and {})", joined(parts.iter().map(text))),
            Pattern::Or(parts) => format!("(?or {})", joined(parts.iter().map(text))),
            Pattern::Not(part) => format!("(?not {})", self.pattern(part)),
        }
    }

    /// Returns a step's activity as text, with its variables as written; for a built-in activity, the arguments in order.
    pub fn activity(self, activity: &Activity) -> String {
        match activity {
            Activity::Goal(goal) => self.template(goal),
            Activity::Terminate { task, outcome, value } => {
                let known = |expr: &Option<Box<Expr>>| expr.as_deref().map(|expr| self.expression(expr));
                let words = [known(task), known(outcome), known(value).map(|value| format!(">> {value}"))];
                list_text("terminate", words.into_iter().flatten())
            }
            Activity::BuiltIn(which, arguments) => {
                list_text(which.word(), arguments.iter().map(|argument| self.expression(argument)))
            }
        }
    }
}

/// Returns an expression in a place where FORM is expected, as exact text.
pub fn form_text(expr: &Expr) -> String {
    match &expr.kind {
        ExprKind::Constant(value) => Style::Exact.literal(value),
        ExprKind::Template(template) => Style::Exact.template(template),
        ExprKind::Variable { .. } | ExprKind::Indexical(_) => exact(expr),
        _ => format!(",{}", exact(expr)),
    }
}

fn exact(expr: &Expr) -> String {
    Style::Exact.expression(expr)
}

/// Returns control forms, definitions and assignments in full.
fn with_body(kind: &ExprKind) -> String {
    match kind {
        ExprKind::If(test, then, otherwise) => {
            let parts = [Some(test), Some(then), otherwise.as_ref()];
            list_text("if", parts.into_iter().flatten().map(|part| exact(part)))
        }
        ExprKind::Cond(clauses) => {
            let clause = |(test, body): &(Expr, Vec<Expr>)| list_text(&exact(test), body.iter().map(exact));
            list_text("cond", clauses.iter().map(clause))
        }
        ExprKind::Case(key, clauses) => {
            let clause = |(keys, body): &(Vec<Value>, Vec<Expr>)| {
                let head =
                    if keys.is_empty() { "otherwise".to_string() } else { list_text("", keys.iter().map(value_text)) };
                list_text(&head, body.iter().map(exact))
            };
            list_text("case", std::iter::once(exact(key)).chain(clauses.iter().map(clause)))
        }
        ExprKind::Let { sequential, bindings, body } => {
            let binding = |(name, value): &(Symbol, Expr)| format!("({name} {})", exact(value));
            let bindings = list_text("", bindings.iter().map(binding));
            let head = if *sequential { "let*" } else { "let" };
            list_text(head, std::iter::once(bindings).chain(body.iter().map(exact)))
        }
        ExprKind::Lambda { parameters, body } => {
            list_text("lambda", std::iter::once(parameters_text(parameters)).chain(body.iter().map(exact)))
        }
        ExprKind::Assign { name, of_task, value } => {
            let mark = if *of_task { "?" } else { "" };
            format!("(setq {mark}{name} {})", exact(value))
        }
        ExprKind::Sequence(parts) => list_text("progn", parts.iter().map(exact)),
        _ => String::new(),
    }
}

/// Returns the forms of [`with_body`] with abbreviated bodies.
fn without_body(kind: &ExprKind) -> String {
    match kind {
        ExprKind::If(test, ..) => format!("(if {} ..)", Style::Brief.expression(test)),
        ExprKind::Cond(_) => "(cond ..)".into(),
        ExprKind::Case(key, _) => format!("(case {} ..)", Style::Brief.expression(key)),
        ExprKind::Let { .. } => "(let ..)".into(),
        ExprKind::Lambda { .. } => "(lambda ..)".into(),
        ExprKind::Assign { name, .. } => format!("(setq {name} ..)"),
        ExprKind::Sequence(_) => "(progn ..)".into(),
        _ => String::new(),
    }
}

/// Returns the parameters of a function as text.
fn parameters_text(parameters: &Parameters) -> String {
    let mut words: Vec<String> = parameters.required.iter().map(Symbol::to_string).collect();
    if !parameters.optional.is_empty() {
        words.push("&optional".to_string());
    }
    words.extend(parameters.optional.iter().map(|(name, default)| match default {
        Some(default) => format!("({name} {})", exact(default)),
        None => name.to_string(),
    }));
    words.extend(parameters.rest.iter().flat_map(|name| ["&rest".to_string(), name.to_string()]));
    list_text("", words)
}

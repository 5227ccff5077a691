//! Conditions in words: the PDL text of a condition or of one of its parts, for `apex why`.

use crate::condition::{
    Constraint, EpisodeCondition, Estimation, MeasurementCondition, Quality, Relation, Timing, VariablePattern,
};
use crate::expression::{Expr, ExprKind, Template};
use crate::pattern::Pattern;
use crate::procedure::Activity;
use crate::symbol::Symbol;
use crate::value::Value;

/// The text of an expression, close to what its author wrote.
pub fn expression(expr: &Expr) -> String {
    match &expr.kind {
        ExprKind::Constant(Value::List(items)) if !items.is_empty() => format!("'{}", Value::List(items.clone())),
        ExprKind::Constant(value) => value.to_string(),
        ExprKind::Variable { name, must_be_bound: false } => format!("?{name}"),
        ExprKind::Variable { name, must_be_bound: true } => format!("<?{name}>"),
        ExprKind::Local(name) | ExprKind::Named(name) => name.to_string(),
        ExprKind::Indexical(name) => format!("+{name}+"),
        ExprKind::Call { function, arguments } => list(function, arguments.iter().map(expression)),
        ExprKind::And(parts) => list("and", parts.iter().map(expression)),
        ExprKind::Or(parts) => list("or", parts.iter().map(expression)),
        ExprKind::If(test, ..) => format!("(if {} ..)", expression(test)),
        ExprKind::Cond(_) => "(cond ..)".into(),
        ExprKind::Case(key, _) => format!("(case {} ..)", expression(key)),
        ExprKind::Let { .. } => "(let ..)".into(),
        ExprKind::Lambda { .. } => "(lambda ..)".into(),
        ExprKind::FunctionName(name) => format!("#'{name}"),
        ExprKind::Assign { name, .. } => format!("(setq {name} ..)"),
        ExprKind::Sequence(_) => "(progn ..)".into(),
        ExprKind::Template(inner) => format!("`{}", template(inner)),
    }
}

/// The text of a template, with its holes as they are written.
pub fn template(text: &Template) -> String {
    match text {
        Template::Constant(value) => value.to_string(),
        Template::Hole(expr) => expression(expr),
        Template::Splice(expr) => format!(",@{}", expression(expr)),
        Template::List(parts) => parenthesised(parts.iter().map(template)),
    }
}

/// The text of a step's activity, with its variables as they are written.
pub fn activity(activity: &Activity) -> String {
    let known = |expr: &Option<Box<Expr>>| expr.as_deref().map(expression);
    match activity {
        Activity::Goal(goal) => template(goal),
        Activity::Terminate { task, outcome, value } => {
            let words = [known(task), known(outcome), known(value).map(|value| format!(">> {value}"))];
            list("terminate", words.into_iter().flatten())
        }
        Activity::BuiltIn(which, arguments) => list(which.word(), arguments.iter().map(expression)),
    }
}

/// The text of a pattern.
pub fn pattern(pattern_to_tell: &Pattern) -> String {
    match pattern_to_tell {
        Pattern::Literal(value) => value.to_string(),
        Pattern::Variable(name) => format!("?{name}"),
        Pattern::BoundVariable(name) => format!("<?{name}>"),
        Pattern::Anonymous => "?".into(),
        Pattern::Computed(expr) => expression(expr),
        Pattern::List(parts) => parenthesised(parts.iter().map(pattern)),
        Pattern::Segment { variable, minimum, maximum } => {
            let sign = match (minimum, maximum) {
                (0, Some(1)) => "??",
                (0, _) => "?*",
                _ => "?+",
            };
            match variable {
                Some(name) => format!("({sign} ?{name})"),
                None => format!("({sign})"),
            }
        }
        Pattern::Guard(expr) => format!("(?if {})", expression(expr)),
        Pattern::Is { variable, predicate } => format!("(?is ?{variable} {predicate})"),
        Pattern::And(parts) => list("?and", parts.iter().map(pattern)),
        Pattern::Or(parts) => list("?or", parts.iter().map(pattern)),
        Pattern::Not(part) => format!("(?not {})", pattern(part)),
    }
}

/// The text of a state variable, without its parentheses.
pub fn variable(variable: &VariablePattern) -> String {
    match &variable.object {
        Pattern::Literal(Value::List(items)) if items.is_empty() => variable.attribute.to_string(),
        Pattern::List(parts) => std::iter::once(variable.attribute.to_string())
            .chain(parts.iter().map(pattern))
            .collect::<Vec<_>>()
            .join(" "),
        object => format!("{} {}", variable.attribute, pattern(object)),
    }
}

/// The text of a measurement condition.
pub fn measurement(condition: &MeasurementCondition) -> String {
    let short = condition.object.is_empty() && condition.timestamp.is_empty() && condition.estimation.is_none();
    if let (true, [only]) = (short, condition.value.as_slice()) {
        return format!("({} {})", variable(&condition.variable), bare(only));
    }
    format!(
        "(:measurement ({}){}{}{}{})",
        variable(&condition.variable),
        option(":value", &condition.value),
        option(":object", &condition.object),
        option(":timestamp", &condition.timestamp),
        condition.estimation.as_ref().map(estimation).unwrap_or_default()
    )
}

fn estimation(estimation: &Estimation) -> String {
    match estimation {
        Estimation::Persist(None) => " :estimation :persist".into(),
        Estimation::Persist(Some(timeout)) => format!(" :estimation (:persist :with-timeout {})", expression(timeout)),
        Estimation::LinearRegression(options) if options.is_empty() => " :estimation :linear-regression".into(),
        Estimation::LinearRegression(options) => {
            let options = options.iter().map(|(name, value)| format!(":{name} {}", expression(value)));
            format!(" :estimation {}", list(":linear-regression", options))
        }
    }
}

fn groups(name: &str, groups: &[(Symbol, Vec<Constraint>)]) -> String {
    if groups.is_empty() {
        return String::new();
    }
    let one = |(name, constraints): &(Symbol, Vec<Constraint>)| {
        let constraints = constraints.iter().map(|each| match (name.folded(), each) {
            ("significance", Constraint::Compare { right, .. }) => expression(right),
            ("custom", Constraint::Predicate(predicate, _)) => predicate.to_string(),
            _ => constraint(each),
        });
        list(format!(":{name}"), constraints)
    };
    format!(" {name} {}", groups.iter().map(one).collect::<Vec<_>>().join(" "))
}

/// The text of an episode condition.
pub fn episode(condition: &EpisodeCondition) -> String {
    let quality = match &condition.quality {
        Quality::NoConstraints => ":no-constraints".into(),
        Quality::MaximumGap(gap) => format!("(:max-gap {})", expression(gap)),
    };
    format!(
        "(:episode ({}){} :quality {quality}{}{}{}{}{}{}{})",
        variable(&condition.variable),
        if condition.any { " :any" } else { "" },
        option(":value", &condition.value),
        option(":first-value", &condition.first_value),
        option(":last-value", &condition.last_value),
        option(":object", &condition.object),
        timing(&condition.timing),
        groups(":stats", &condition.stats),
        groups(":trend", &condition.trend)
    )
}

fn timing(timing: &Timing) -> String {
    let parts: Vec<String> = [(":start", &timing.start), (":end", &timing.end), (":duration", &timing.duration)]
        .into_iter()
        .filter(|(_, constraints)| !constraints.is_empty())
        .map(|(name, constraints)| list(name, constraints.iter().map(constraint)))
        .collect();
    if parts.is_empty() { String::new() } else { format!(" :timing {}", parts.join(" ")) }
}

/// The text of an event condition.
pub fn event(form: &Pattern, when: &Timing) -> String {
    match timing(when) {
        none if none.is_empty() => pattern(form),
        some => format!("(:atomic-episode {}{some})", pattern(form)),
    }
}

/// The text of an option, with a blank before it; nothing without constraints.
pub fn option(name: &str, constraints: &[Constraint]) -> String {
    if constraints.is_empty() {
        return String::new();
    }
    format!(" {name} {}", constraints.iter().map(constraint).collect::<Vec<_>>().join(" "))
}

/// The text of a constraint.
pub fn constraint(constraint: &Constraint) -> String {
    match constraint {
        Constraint::Predicate(..) | Constraint::Range(..) => bare(constraint),
        other => format!("({})", bare(other)),
    }
}

fn bare(constraint: &Constraint) -> String {
    match constraint {
        Constraint::Compare { relation, right, tolerance } => {
            let tolerance = tolerance.as_ref().map(|value| format!(" +/- {}", expression(value))).unwrap_or_default();
            format!("{} {}{tolerance}", sign(*relation), expression(right))
        }
        Constraint::Matches(form) => format!("= {}", pattern(form)),
        Constraint::Predicate(name, arguments) => list(name, arguments.iter().map(expression)),
        Constraint::Range(Some(least), Some(most)) => format!("(:range {} {})", expression(least), expression(most)),
        Constraint::Range(Some(least), None) => format!("(:min {})", expression(least)),
        Constraint::Range(None, Some(most)) => format!("(:max {})", expression(most)),
        Constraint::Range(None, None) => "(:range)".into(),
    }
}

fn sign(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Different => "/=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}

/// The text of a wait for a task's state.
pub fn task_state(task: &Expr, state: &Pattern) -> String {
    format!("(state {} = {})", expression(task), pattern(state))
}

/// The text of `:delay` and `:timestamp`.
pub fn span(name: &str, from: &Expr, to: Option<&Expr>) -> String {
    list(name, std::iter::once(from).chain(to).map(expression))
}

fn list(head: impl std::fmt::Display, parts: impl Iterator<Item = String>) -> String {
    parenthesised(std::iter::once(head.to_string()).chain(parts))
}

fn parenthesised(parts: impl Iterator<Item = String>) -> String {
    format!("({})", parts.collect::<Vec<_>>().join(" "))
}

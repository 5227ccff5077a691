//! Conditions as text, in one canonical form each.

use super::expression::{expression_text, operand_text, pattern_text, template_text};
use super::{joined, list_text};
use apex_model::condition::{
    Condition, ConditionKind, Constraint, EpisodeCondition, Estimation, MeasurementCondition, Quality, Relation,
    Timing, VariablePattern,
};
use apex_model::expression::Expr;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// The condition as text.
pub(super) fn condition_text(condition: &Condition) -> String {
    with_probing(condition, String::new())
}

/// The condition with the text of its `:probing` option, which stands inside.
fn with_probing(condition: &Condition, probing: String) -> String {
    let tag = condition.tag.as_ref().map_or(String::new(), Symbol::to_string);
    let expressions = |all: &[Expr]| all.iter().map(expression_text).collect::<Vec<_>>();
    match &condition.kind {
        ConditionKind::Measurement(measurement) => measurement_text(tag, measurement, probing),
        ConditionKind::Episode(episode) => episode_text(tag, episode, probing),
        ConditionKind::And(parts, constraints) => composite_text(":and", tag, parts, None, constraints),
        ConditionKind::Or(parts, constraints) => composite_text(":or", tag, parts, None, constraints),
        ConditionKind::InOrder(parts, constraints) => composite_text(":in-order", tag, parts, None, constraints),
        ConditionKind::Allen { relation, parts, tolerance, constraints } => {
            let head = format!(":{}", relation.word());
            composite_text(&head, tag, parts, tolerance.as_ref(), constraints)
        }
        ConditionKind::Not(part) => list_text(":not", [tag, condition_text(part)]),
        ConditionKind::Absent(part, window) => {
            list_text(":absent", [tag, condition_text(part), format!(":for {}", expression_text(window))])
        }
        ConditionKind::Delay(least, most) => list_text(":delay", expressions(&pair(least, most))),
        ConditionKind::Timestamp(start, end) => list_text(":timestamp", expressions(&pair(start, end))),
        ConditionKind::Event { pattern, timing } => event_text(tag, pattern, timing, probing),
        ConditionKind::TaskEnded(name) => format!("(end ?{name})"),
        ConditionKind::TaskState { task, state } => {
            format!("(task-state {} = {})", expression_text(task), pattern_text(state))
        }
        ConditionKind::Function(expr) => format!("(:function {})", expression_text(expr)),
        ConditionKind::Probing { condition, goal, interval, time_limit, count_limit } => {
            let limit = |name: &str, expr: &Option<Expr>| {
                expr.as_ref().map_or(String::new(), |expr| format!(":{name} {}", expression_text(expr)))
            };
            let parts = [expression_text(interval), limit("time-limit", time_limit), limit("count-limit", count_limit)];
            with_probing(condition, format!(":probing {}", list_text(&template_text(goal), parts)))
        }
        ConditionKind::Cyclic(cyclic) => {
            let options = cyclic.options.iter().map(|(name, constraints)| group(name.printed(), constraints));
            list_text(":cyclic", [tag, variable_text(&cyclic.variable, String::new())].into_iter().chain(options))
        }
    }
}

fn pair(first: &Expr, second: &Option<Expr>) -> Vec<Expr> {
    std::iter::once(first.clone()).chain(second.clone()).collect()
}

fn composite_text(
    head: &str,
    tag: String,
    parts: &[Condition],
    tolerance: Option<&Expr>,
    constraints: &[Expr],
) -> String {
    let tolerance = tolerance.map_or(String::new(), |expr| format!(":tolerance {}", expression_text(expr)));
    let constraints = match constraints {
        [] => String::new(),
        all => format!(":constraint {}", joined(all.iter().map(expression_text))),
    };
    let parts = parts.iter().map(condition_text);
    list_text(head, std::iter::once(tag).chain(parts).chain([tolerance, constraints]))
}

/// `(ATTR OBJ.. rest)`
fn variable_text(variable: &VariablePattern, rest: String) -> String {
    let object = match &variable.object {
        Pattern::Literal(Value::List(items)) if items.is_empty() => String::new(),
        Pattern::Literal(Value::List(items)) if items.len() > 1 => {
            joined(items.iter().map(|item| pattern_text(&Pattern::Literal(item.clone()))))
        }
        Pattern::List(items) if items.len() > 1 => joined(items.iter().map(pattern_text)),
        one => pattern_text(one),
    };
    list_text(variable.attribute.printed(), [object, rest])
}

fn measurement_text(tag: String, measurement: &MeasurementCondition, probing: String) -> String {
    let is_plain = tag.is_empty()
        && probing.is_empty()
        && measurement.object.is_empty()
        && measurement.timestamp.is_empty()
        && measurement.estimation.is_none()
        && !measurement.value.is_empty();
    let operands: Option<Vec<String>> = measurement.value.iter().map(infix_text).collect();
    if let Some(operands) = operands.filter(|_| is_plain) {
        return variable_text(&measurement.variable, joined(operands));
    }
    let parts = [
        tag,
        variable_text(&measurement.variable, String::new()),
        group("value", &measurement.value),
        group("object", &measurement.object),
        group("timestamp", &measurement.timestamp),
        measurement.estimation.as_ref().map_or(String::new(), estimation_text),
        probing,
    ];
    list_text(":measurement", parts)
}

fn estimation_text(estimation: &Estimation) -> String {
    match estimation {
        Estimation::Persist(None) => ":estimation :persist".to_string(),
        Estimation::Persist(Some(timeout)) => {
            format!(":estimation (:persist :with-timeout {})", expression_text(timeout))
        }
        Estimation::LinearRegression(options) if options.is_empty() => ":estimation :linear-regression".to_string(),
        Estimation::LinearRegression(options) => {
            let options = options.iter().map(|(name, expr)| format!(":{name} {}", expression_text(expr)));
            format!(":estimation {}", list_text(":linear-regression", options))
        }
    }
}

fn episode_text(tag: String, episode: &EpisodeCondition, probing: String) -> String {
    let quality = match &episode.quality {
        Quality::NoConstraints => ":quality :no-constraints".to_string(),
        Quality::MaximumGap(gap) => format!(":quality (:max-gap {})", expression_text(gap)),
    };
    let named = |head: &str, groups: &[(Symbol, Vec<Constraint>)]| match groups {
        [] => String::new(),
        all => {
            let one = |(name, constraints): &(Symbol, Vec<Constraint>)| named_group(name, constraints);
            format!(":{head} {}", joined(all.iter().map(one)))
        }
    };
    let parts = [
        tag,
        variable_text(&episode.variable, String::new()),
        if episode.any { ":any".to_string() } else { String::new() },
        quality,
        group("value", &episode.value),
        group("first-value", &episode.first_value),
        group("last-value", &episode.last_value),
        group("object", &episode.object),
        timing_text(&episode.timing),
        named("stats", &episode.stats),
        named("trend", &episode.trend),
        probing,
    ];
    list_text(":episode", parts)
}

/// `(:name C..)`; two kinds of groups hold a plain operand instead of constraints.
fn named_group(name: &Symbol, constraints: &[Constraint]) -> String {
    let operand = match (name.folded(), constraints) {
        ("custom", [Constraint::Predicate(predicate, _)]) => Some(predicate.to_string()),
        ("significance", [Constraint::Compare { right, .. }]) => Some(expression_text(right)),
        _ => None,
    };
    match operand {
        Some(operand) => format!("(:{name} {operand})"),
        None => list_text(&format!(":{name}"), constraints.iter().map(constraint_text)),
    }
}

fn timing_text(timing: &Timing) -> String {
    let groups = [("start", &timing.start), ("end", &timing.end), ("duration", &timing.duration)];
    let groups: Vec<String> = groups
        .into_iter()
        .filter(|(_, constraints)| !constraints.is_empty())
        .map(|(name, constraints)| list_text(&format!(":{name}"), constraints.iter().map(constraint_text)))
        .collect();
    if groups.is_empty() { String::new() } else { format!(":timing {}", joined(groups)) }
}

fn event_text(tag: String, pattern: &Pattern, timing: &Timing, probing: String) -> String {
    let timing = timing_text(timing);
    let form = pattern_text(pattern);
    if tag.is_empty() && timing.is_empty() && probing.is_empty() && !reads_otherwise(pattern) {
        return form;
    }
    list_text(":atomic-episode", [tag, form, timing, probing])
}

/// True for event forms that would be read as another kind of condition.
fn reads_otherwise(pattern: &Pattern) -> bool {
    const HEADS: &[&str] = &["and", "or", "not", "end", "end-of", "end_of", "terminated", "state", "task-state"];
    const RELATIONS: &[&str] = &["=", "/=", "<", "<=", ">", ">="];
    let symbols: Vec<Option<&Symbol>> = match pattern {
        Pattern::Literal(Value::List(items)) => items.iter().map(Value::as_symbol).collect(),
        Pattern::List(items) => items
            .iter()
            .map(|item| match item {
                Pattern::Literal(value) => value.as_symbol(),
                _ => None,
            })
            .collect(),
        _ => return false,
    };
    let head = symbols.first().copied().flatten();
    head.is_some_and(|head| HEADS.contains(&head.folded()) || head.folded().starts_with(':'))
        || symbols.iter().skip(1).flatten().any(|symbol| RELATIONS.contains(&symbol.folded()))
}

/// `:name C..`, or nothing without constraints.
fn group(name: &str, constraints: &[Constraint]) -> String {
    match constraints {
        [] => String::new(),
        all => format!(":{name} {}", joined(all.iter().map(constraint_text))),
    }
}

fn constraint_text(constraint: &Constraint) -> String {
    if let Some(infix) = infix_text(constraint) {
        return format!("({infix})");
    }
    match constraint {
        Constraint::Range(Some(low), Some(high)) => {
            format!("(:range {} {})", expression_text(low), expression_text(high))
        }
        Constraint::Range(Some(low), None) => format!("(:min {})", expression_text(low)),
        Constraint::Range(None, Some(high)) => format!("(:max {})", expression_text(high)),
        Constraint::Predicate(name, arguments) => list_text(name.printed(), arguments.iter().map(expression_text)),
        _ => String::new(),
    }
}

/// `REL right [+/- tolerance]`
fn infix_text(constraint: &Constraint) -> Option<String> {
    match constraint {
        Constraint::Compare { relation, right, tolerance } => {
            let tolerance = tolerance.as_ref().map_or(String::new(), |expr| format!(" +/- {}", expression_text(expr)));
            Some(format!("{} {}{tolerance}", relation_text(*relation), operand_text(right)))
        }
        Constraint::Matches(pattern) => Some(format!("= {}", pattern_text(pattern))),
        Constraint::Predicate(..) | Constraint::Range(..) => None,
    }
}

fn relation_text(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::Different => "/=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}

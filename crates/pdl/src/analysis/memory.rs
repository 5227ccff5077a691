//! Unbounded memory of a program: histories that are never old enough, sets that only grow, tasks that
//! accumulate. The executive limits each of them; at the limit it drops the oldest entries.

use super::endings::{goes_on, is_endless, is_stopped, terminated_tags};
use super::walk::QUERIES;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use apex_model::condition::{Condition, ConditionKind, Constraint, Relation};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::limits::HISTORY_SAMPLES_MAX;
use apex_model::procedure::{Procedure, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeSet;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for (number, procedure) in program.library.procedures.iter().enumerate() {
        walk::conditions_of(procedure, &mut |condition| looking_back(condition, report));
        logs(procedure, report);
        let terminated = terminated_tags(procedure);
        for (index, step) in procedure.steps.iter().enumerate() {
            let ends = program.endings.activity_ends(number, index) || is_stopped(step, &terminated);
            piling_up(step, ends || program.endings.is_wild, report);
            unbounded_for_new(procedure, step, report);
            growing(procedure, step, report);
        }
        queries(procedure, report);
    }
    walk::library(program.library, &mut |expr| published(expr, report));
}

fn warn(span: Span, message: String, reason: String, help: &str, report: &mut FindingCollector<'_>) {
    let diagnostic = Diagnostic::new(Severity::Warning, codes::UNBOUNDED_MEMORY, span, message);
    report.add(diagnostic.reason(reason).help(help));
}

fn kept(what: &str) -> String {
    format!("{what}, up to the limit of {HISTORY_SAMPLES_MAX}")
}

/// Reports conditions about the past without an earliest time.
fn looking_back(condition: &Condition, report: &mut FindingCollector<'_>) {
    let (limits, what) = match &condition.kind {
        ConditionKind::Measurement(measurement) => (vec![&measurement.timestamp], "every sample is kept"),
        ConditionKind::Episode(episode) => (vec![&episode.timing.start, &episode.timing.end], "every sample is kept"),
        ConditionKind::Event { timing, .. } => (vec![&timing.start, &timing.end], "every message is kept"),
        _ => return,
    };
    let written: Vec<&Constraint> = limits.into_iter().flatten().collect();
    if written.is_empty() || written.iter().any(|limit| is_earliest(limit)) {
        return;
    }
    warn(
        report.locator.span(condition.place),
        "this condition looks back without end".to_string(),
        format!("it states the latest time of its evidence, but not the earliest: {}", kept(what)),
        "add an earliest time: `(> (- +now+ P10M))`, or `(:es T)` in `:timing`",
        report,
    );
}

/// Returns true for a limit that excludes the past.
fn is_earliest(limit: &Constraint) -> bool {
    let real = |expr: &Expr| !matches!(&expr.kind, ExprKind::Indexical(name) if name.is("beginning-of-time"));
    match limit {
        Constraint::Compare { relation, right, .. } => {
            matches!(relation, Relation::Greater | Relation::GreaterOrEqual | Relation::Equal) && real(right)
        }
        Constraint::Range(low, _) => low.as_ref().is_some_and(real),
        Constraint::Matches(_) | Constraint::Predicate(..) => false,
    }
}

fn logs(procedure: &Procedure, report: &mut FindingCollector<'_>) {
    for policy in procedure.log.iter().filter(|policy| policy.time_limit.is_none() && policy.count_limit.is_none()) {
        let head = crate::matching::View::Template(&policy.subject).head().cloned();
        let messages = head.as_ref().is_some_and(|head| head.is(":events"));
        let place = procedure.place;
        let span = match &head {
            Some(head) => report.locator.word_in_clause(place, "log", head),
            None => report.locator.clause(place, "log"),
        };
        let name = head.map_or_else(|| "a variable".to_string(), |head| format!("`{head}`"));
        warn(
            span,
            if messages {
                "every such message is logged".to_string()
            } else {
                format!("every sample of {name} is logged")
            },
            format!(
                "the policy has neither a time limit nor a count limit: {}",
                kept("all are kept while the procedure executes")
            ),
            "add `:time-limit P10M` or `:count-limit 5000`",
            report,
        );
    }
}

/// Reports responses that never end.
fn piling_up(step: &Step, ends: bool, report: &mut FindingCollector<'_>) {
    if ends || !step.responding.as_deref().is_some_and(is_endless) || step.on_failure.is_some() || step.forall.is_some()
    {
        return;
    }
    warn(
        report.locator.clause(step.place, "responding"),
        format!("tasks of `{}` pile up", step.tag),
        "each response begins a new task, and the step's activity does not end".to_string(),
        "give the step an `end-when`, or use `repeating`, which has one task at a time",
        report,
    );
}

/// Reports `:for-new` over values that never repeat.
fn unbounded_for_new(procedure: &Procedure, step: &Step, report: &mut FindingCollector<'_>) {
    let clause = match (&step.responding, &step.repeating) {
        (Some(clause), _) => ("responding", clause),
        (None, Some(clause)) => ("repeating", clause),
        (None, None) => return,
    };
    let endless = goes_on(procedure, step) || step.responding.as_deref().is_some_and(is_endless);
    if clause.1.for_new.is_empty() || !endless {
        return;
    }
    let mut measured: BTreeSet<&Symbol> = BTreeSet::new();
    for condition in &step.waitfor {
        walk::conditions(condition, &mut |each| {
            let values = match &each.kind {
                ConditionKind::Measurement(measurement) => &measurement.value,
                ConditionKind::Episode(episode) => &episode.value,
                _ => return,
            };
            for value in values {
                if let Constraint::Matches(pattern) = value {
                    measured.extend(super::bound::by_pattern(pattern).surely);
                }
            }
        });
    }
    if let Some(name) = clause.1.for_new.iter().find(|name| measured.contains(name)) {
        warn(
            report.locator.variable_in_clause(step.place, clause.0, name),
            format!("values of `?{name}` are remembered without end"),
            "`:for-new` keeps every combination that was answered, and a measured value is seldom the same again"
                .to_string(),
            "name a variable with few values, such as an object, or add `:while TEST`",
            report,
        );
    }
}

/// Reports lists that a hook of an endless step makes longer each time.
fn growing(procedure: &Procedure, step: &Step, report: &mut FindingCollector<'_>) {
    if !goes_on(procedure, step) && !step.responding.as_deref().is_some_and(is_endless) {
        return;
    }
    for (_, forms) in walk::hooks(&step.hooks) {
        let mut found: Option<(Symbol, Place)> = None;
        walk::exprs(forms, &mut |expr| {
            if let ExprKind::Assign { name, of_task: true, value } = &expr.kind
                && let ExprKind::Call { function, arguments } = &value.kind
                && matches!(function.folded(), "cons" | "append" | "concatenate")
                && arguments
                    .iter()
                    .any(|each| matches!(&each.kind, ExprKind::Variable { name: part, .. } if part == name))
            {
                found.get_or_insert((name.clone(), expr.place));
            }
        });
        if let Some((name, place)) = found {
            warn(
                report.locator.span(place),
                format!("`?{name}` grows with every repetition"),
                "nothing in the step ends the repetition, and nothing makes the list shorter".to_string(),
                "keep the last few: `(setq ?x (subseq ..))`, or end the repetition with `:until TEST`",
                report,
            );
        }
    }
}

/// Reports queries of a history at an instant of unlimited age.
fn queries(procedure: &Procedure, report: &mut FindingCollector<'_>) {
    let mut tags: BTreeSet<&Symbol> = BTreeSet::new();
    walk::conditions_of(procedure, &mut |condition| tags.extend(&condition.tag));
    let mut found: Vec<(Place, &'static str)> = Vec::new();
    walk::procedure(procedure, &mut |expr| {
        let ExprKind::Call { function, arguments } = &expr.kind else { return };
        if !QUERIES.contains(&function.folded()) || function.is("current-value") {
            return;
        }
        if !matches!(arguments.first().map(|attribute| &attribute.kind), Some(ExprKind::Constant(_))) {
            found.push((expr.place, "its state variable is known only when the query is evaluated"));
        } else if arguments.iter().skip(2).any(is_beginning) {
            found.push((expr.place, "its window has no beginning"));
        }
    });
    for (place, why) in found {
        warn(
            report.locator.span(place),
            "this looks back without end".to_string(),
            format!("{why}: {}", kept("every sample is kept")),
            "write the state variable's name, and a window such as `P10M`",
            report,
        );
    }
}

fn is_beginning(expr: &Expr) -> bool {
    matches!(&expr.kind, ExprKind::Indexical(name) if name.is("beginning-of-time"))
}

/// Reports published state variables with a computed object: each value creates one more history.
fn published(expr: &Expr, report: &mut FindingCollector<'_>) {
    let ExprKind::Call { function, arguments } = &expr.kind else { return };
    if !function.is("publish") {
        return;
    }
    let Some(ExprKind::Template(form)) = arguments.first().map(|form| &form.kind) else { return };
    let Template::List(parts) = &**form else { return };
    let computed = |part: &Template| match part {
        Template::Hole(hole) => match &hole.kind {
            ExprKind::Call { function, .. } => COUNTING.contains(&function.folded()),
            ExprKind::Indexical(name) => matches!(name.folded(), "now" | "met" | "tot"),
            _ => false,
        },
        Template::Constant(value) => matches!(value, Value::Real(_)),
        _ => false,
    };
    if parts.iter().skip(1).any(computed) {
        warn(
            report.locator.span(expr.place),
            "each of these is a separate state variable".to_string(),
            "its object is computed, and the history of every object is kept".to_string(),
            "publish one variable with the computed part in its value",
            report,
        );
    }
}

/// Functions that can return a new result at each call.
const COUNTING: &[&str] = &["*", "+", "-", "/", "1+", "1-", "concatenate", "format", "intern"];

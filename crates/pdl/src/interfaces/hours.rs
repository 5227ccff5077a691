//! Instants that conditions wait for, against the end of the mission.

use super::findings::Findings;
use super::known::KnownNames;
use crate::analysis::walk;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use apex_model::condition::ConditionKind;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::source::Place;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Reports instants after the end of the mission: the wait for one of them never ends. The text can be right for a longer mission.
pub(super) fn check(library: &Library, known: &KnownNames, findings: &mut Findings<'_>) {
    let Some(duration) = known.duration else { return };
    let mut late: Vec<(Place, Duration)> = Vec::new();
    for procedure in &library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            let from = match &condition.kind {
                ConditionKind::Timestamp(from, _) => since_start(from).map(|since| (from.place, since)),
                ConditionKind::Function(test) => least_time(test).map(|since| (test.place, since)),
                _ => None,
            };
            late.extend(from.filter(|(_, since)| *since > duration));
        });
    }
    for (place, since) in late {
        let message = format!("this instant is {since} after the start, and the mission lasts {duration}");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::UNREACHABLE, findings.locator.span(place), message)
            .reason("the mission ends earlier, so a step that waits for this instant never begins")
            .help("correct the time, or the `:duration` of the mission");
        findings.add(diagnostic);
    }
}

/// Returns the time from the start of the mission to an instant that is written as a sum of `+mission-start+` and durations.
fn since_start(expr: &Expr) -> Option<Duration> {
    match &expr.kind {
        ExprKind::Indexical(name) if name.is("mission-start") => Some(Duration::ZERO),
        ExprKind::Constant(Value::Time(at)) => Some(*at - Time::ZERO),
        ExprKind::Call { function, arguments } if function.is("+") => {
            let mut instants = 0;
            let mut sum = Duration::ZERO;
            for part in arguments {
                let length = match &part.kind {
                    ExprKind::Constant(Value::Duration(length)) => *length,
                    _ => {
                        instants += 1;
                        since_start(part)?
                    }
                };
                sum = Duration(sum.0.saturating_add(length.0));
            }
            (instants == 1).then_some(sum)
        }
        _ => None,
    }
}

/// Returns the time since the start from which on a test of `+met+` holds: `(> +met+ 30min)`.
fn least_time(test: &Expr) -> Option<Duration> {
    let ExprKind::Call { function, arguments } = &test.kind else { return None };
    let is_met = |expr: &Expr| matches!(&expr.kind, ExprKind::Indexical(name) if name.is("met"));
    let length = |expr: &Expr| match &expr.kind {
        ExprKind::Constant(Value::Duration(length)) => Some(*length),
        _ => None,
    };
    match (function.folded(), arguments.as_slice()) {
        (">" | ">=", [met, least]) if is_met(met) => length(least),
        ("<" | "<=", [least, met]) if is_met(met) => length(least),
        _ => None,
    }
}

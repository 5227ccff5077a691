//! Messages about `:probing`: invalid spans and counts, and goals with variables that only the condition itself binds.

use super::bound::{Bound, by_all, by_pattern};
use super::impossible::number;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use apex_forms::variables;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::procedure::{Procedure, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeSet;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for procedure in &program.library.procedures {
        walk::conditions_of(procedure, &mut |condition| amounts(program, condition, report));
        for step in &procedure.steps {
            needs_itself(procedure, step, report);
        }
    }
}

/// Reports intervals and limits of probing that are known at load time and not above zero.
fn amounts(program: &Program<'_>, condition: &Condition, report: &mut FindingCollector<'_>) {
    let ConditionKind::Probing { interval, time_limit, count_limit, .. } = &condition.kind else { return };
    let library = program.library;
    let spans = [(Some(interval), "interval"), (time_limit.as_ref(), "time limit")];
    for (span, name) in spans {
        let Some(span) = span else { continue };
        if number(span, library).is_some_and(|length| length <= 0.0) {
            let message = format!("the {name} of `:probing` is not above zero");
            let reason = match name {
                "interval" => "probes would follow one another at one instant, without end",
                _ => "probing would be over before the first probe",
            };
            report_amount(span, message, reason, "write a duration such as 10s", report);
        }
    }
    if let Some(limit) = count_limit
        && let ExprKind::Constant(value) = &limit.kind
        && !matches!(value, Value::Integer(1..))
    {
        let message = format!("the count limit of `:probing` is {value}, not a number of probes");
        let help = "write a whole number, 1 or more; without `:count-limit` there is no limit";
        report_amount(limit, message, "probes are counted from 1", help, report);
    }
}

fn report_amount(amount: &Expr, message: String, reason: &str, help: &str, report: &mut FindingCollector<'_>) {
    let span = report.locator.span(amount.place);
    report.add(Diagnostic::error(codes::NOTHING_TO_PROBE, span, message).reason(reason).help(help));
}

/// Reports probing outside of an agent: no task exists to pursue its goal.
pub(super) fn without_effect(conditions: &[Condition], report: &mut FindingCollector<'_>) {
    for condition in conditions {
        walk::conditions(condition, &mut |part| {
            if let ConditionKind::Probing { .. } = part.kind {
                let span = report.locator.probe(part.place);
                let message = "`:probing` has no effect here: no task pursues its goal";
                let diagnostic = Diagnostic::new(Severity::Warning, codes::WITHOUT_EFFECT, span, message)
                    .reason("a condition that is watched without a program has no task that could probe")
                    .help("remove the option, or let an agent wait for the condition: `(waitfor ..)` in a procedure");
                report.add(diagnostic);
            }
        });
    }
}

/// Reports goals whose variables are bound only by the waitfor that they probe for. A `select` is checked elsewhere.
fn needs_itself(procedure: &Procedure, step: &Step, report: &mut FindingCollector<'_>) {
    let mut goals: Vec<(Place, &Template)> = Vec::new();
    for condition in &step.waitfor {
        walk::conditions(condition, &mut |part| {
            if let ConditionKind::Probing { goal, .. } = &part.kind {
                goals.push((part.place, goal));
            }
        });
    }
    if goals.is_empty() {
        return;
    }
    let known = known_before(procedure);
    let waitfor = by_all(&step.waitfor);
    let mut told: BTreeSet<Symbol> = BTreeSet::new();
    for (place, goal) in goals {
        let mut names: Vec<Symbol> = Vec::new();
        variables::of_template(goal, &mut |name| names.push(name.clone()));
        for name in names {
            if !binds(&waitfor, &name) || known.contains(&name) || !told.insert(name.clone()) {
                continue;
            }
            let span = report.locator.variable_of_probe(place, &name);
            let message = format!("`?{name}` has no value yet when this is pursued");
            let diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, span, message)
                .reason("a probe begins before the condition holds that gives the variable its value")
                .help("name what is to be probed, or let the index or another step's result bind it");
            report.add(diagnostic);
        }
    }
}

/// Returns the variables that have a value while a step waits: those of the index, tags, results that the step waits for, and those that
/// a form assigns.
fn known_before(procedure: &Procedure) -> BTreeSet<Symbol> {
    let mut known: BTreeSet<Symbol> = procedure.steps.iter().map(|step| step.tag.clone()).collect();
    let results = procedure.steps.iter().filter_map(|step| step.binds.as_deref());
    for bound in results.chain([&procedure.index]).map(by_pattern) {
        known.extend(bound.surely.into_iter().chain(bound.perhaps.into_keys()).cloned());
    }
    walk::procedure(procedure, &mut |expr| {
        if let ExprKind::Assign { name, of_task: true, .. } = &expr.kind {
            known.insert(name.clone());
        }
    });
    known
}

fn binds(bound: &Bound<'_>, name: &Symbol) -> bool {
    bound.surely.contains(name) || bound.perhaps.contains_key(name) || bound.never.contains_key(name)
}

//! Diagnostics of conditions that can never hold, because their limits or their parts exclude each other.

use super::contradictions::{self, conjuncts};
use super::impossible::impossible;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use apex_model::condition::{Condition, ConditionKind};
use apex_model::procedure::{Procedure, Transitions};
use apex_model::source::Place;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for procedure in &program.library.procedures {
        for step in &procedure.steps {
            for each in &step.waitfor {
                look(program, each, true, report);
            }
            outcomes(procedure, &step.waitfor.iter().collect::<Vec<_>>(), Severity::Error, report);
            clauses(program, procedure, &step.transitions, report);
        }
        clauses(program, procedure, &procedure.transitions, report);
    }
}

fn clauses(program: &Program<'_>, procedure: &Procedure, transitions: &Transitions, report: &mut FindingCollector<'_>) {
    for (name, condition) in walk::transitions(transitions) {
        look(program, condition, false, report);
        outcomes(procedure, &[condition], Severity::Warning, report);
        // These are judged at one instant, by the newest samples.
        if matches!(name, "precondition" | "invariant") {
            let mut parts = Vec::new();
            conjuncts(condition, &mut parts);
            let found = contradictions::limits(&parts, program.library);
            exclude(found, Severity::Error, "exchange the limits, or write `(:or ..)`", report);
        }
    }
}

/// Reports outcomes of one step that exclude each other, in conditions that must all hold.
fn outcomes(procedure: &Procedure, conditions: &[&Condition], severity: Severity, report: &mut FindingCollector<'_>) {
    let mut parts = Vec::new();
    conditions.iter().for_each(|each| conjuncts(each, &mut parts));
    let found = contradictions::outcomes(&parts, procedure);
    exclude(found, severity, "write `(:or ..)` for either of them", report);
}

fn exclude(found: Option<(Place, String)>, severity: Severity, help: &str, report: &mut FindingCollector<'_>) {
    if let Some((place, reason)) = found {
        let span = report.locator.span(place);
        let message = "this condition can never hold together with the others";
        report.add(Diagnostic::new(severity, codes::IMPOSSIBLE_CONDITION, span, message).reason(reason).help(help));
    }
}

/// Reports impossible parts of a condition: errors if `decides` is true (the whole condition, and so a step, depends on the part),
/// else warnings.
fn look(program: &Program<'_>, condition: &Condition, decides: bool, report: &mut FindingCollector<'_>) {
    if let Some(found) = impossible(condition, program.library) {
        let span = report.locator.span(found.place);
        let severity = if decides { Severity::Error } else { Severity::Warning };
        let diagnostic = Diagnostic::new(severity, codes::IMPOSSIBLE_CONDITION, span, "this condition can never hold")
            .reason(found.reason)
            .help(found.help);
        return report.add(diagnostic);
    }
    let decides = decides
        && matches!(
            condition.kind,
            ConditionKind::And(..)
                | ConditionKind::InOrder(..)
                | ConditionKind::Allen { .. }
                | ConditionKind::Probing { .. }
        );
    walk::parts(condition).iter().for_each(|part| look(program, part, decides, report));
}

//! Diagnostics of conditions that can never hold, because their limits exclude each other.

use super::impossible::impossible;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use apex_model::condition::{Condition, ConditionKind};

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for procedure in &program.library.procedures {
        for step in &procedure.steps {
            for each in &step.waitfor {
                look(program, each, true, report);
            }
            walk::transitions(&step.transitions).for_each(|(_, each)| look(program, each, false, report));
        }
        walk::transitions(&procedure.transitions).for_each(|(_, each)| look(program, each, false, report));
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

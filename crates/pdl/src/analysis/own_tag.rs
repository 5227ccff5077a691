//! Reports messages that wait for the step's own task: a variable of the pattern has the name of the step.

use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use apex_model::condition::ConditionKind;
use apex_model::pattern::Pattern;
use apex_model::procedure::Step;
use apex_model::symbol::Symbol;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for step in program.library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        if step.waitfor.iter().any(|condition| waits_for(condition, &step.tag)) {
            about(step, report);
        }
    }
}

fn about(step: &Step, report: &mut FindingCollector<'_>) {
    let tag = &step.tag;
    let span = report.locator.variable_in_clause(step.place, "waitfor", tag);
    let message = format!("`?{tag}` is the task of this step, not what the message says");
    let diagnostic = Diagnostic::new(Severity::Warning, codes::OWN_TAG, span, message)
        .label(report.locator.tag(step.place), format!("this name makes `?{tag}` the step's task"))
        .reason(
            "the variable has a value before any message comes, so only a message that holds this very task matches",
        )
        .help("give the step or the variable another name");
    report.add(diagnostic);
}

fn waits_for(condition: &apex_model::condition::Condition, tag: &Symbol) -> bool {
    let mut found = false;
    walk::conditions(condition, &mut |part| {
        if let ConditionKind::Event { pattern, .. } = &part.kind {
            found |= has(pattern, tag);
        }
    });
    found
}

fn has(pattern: &Pattern, name: &Symbol) -> bool {
    match pattern {
        Pattern::Variable(variable) | Pattern::Is { variable, .. } => variable == name,
        Pattern::Segment { variable, .. } => variable.as_ref() == Some(name),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => parts.iter().any(|part| has(part, name)),
        // `<?x>` requires a known value; the others bind nothing.
        Pattern::Literal(_)
        | Pattern::BoundVariable(_)
        | Pattern::Anonymous
        | Pattern::Computed(_)
        | Pattern::Guard(_)
        | Pattern::Not(_) => false,
    }
}

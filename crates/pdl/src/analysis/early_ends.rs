//! Steps that end their procedure as it begins, although other steps have work to do.

use super::endings::{Endings, ends_procedure};
use super::walk;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::locate::Locator;
use apex_forms::awaited::Awaited;
use apex_model::library::Library;
use apex_model::procedure::{Activity, Procedure, ProcedureKind, Step};

/// Returns the findings of `(step finish (terminate))` without a condition in a procedure whose steps begin together.
pub(super) fn findings(library: &Library, endings: &Endings) -> Vec<Diagnostic> {
    let (mut locator, mut found) = (Locator::new(&library.sources), Vec::new());
    let procedures = library.procedures.iter().enumerate();
    for (number, procedure) in procedures.filter(|(_, procedure)| procedure.kind != ProcedureKind::Sequential) {
        let awaited = Awaited::new(procedure);
        let steps = || procedure.steps.iter().enumerate();
        let ends_at_once = |index: usize, step: &Step| {
            ends_procedure(&step.activity) && waits_for_nothing(step) && awaited.by(index).is_empty()
        };
        let Some((at, end)) = steps().find(|(index, step)| ends_at_once(*index, step)) else { continue };
        let takes_time =
            |index: usize, step: &Step| !endings.activity_takes_no_time(number, index) || !waits_for_nothing(step);
        let cut = steps().find(|(index, step)| *index != at && !is_end(step) && takes_time(*index, step));
        found.extend(cut.map(|(_, cut)| early_end(procedure, end, cut, &mut locator)));
    }
    found
}

fn is_end(step: &Step) -> bool {
    matches!(step.activity, Activity::Terminate { .. })
}

/// Returns true if the step begins with its procedure, whatever happens.
fn waits_for_nothing(step: &Step) -> bool {
    step.waitfor.is_empty()
        && step.profile.is_empty()
        && step.forall.is_none()
        && step.repeating.is_none()
        && step.responding.is_none()
        && walk::transitions(&step.transitions).next().is_none()
}

fn early_end(procedure: &Procedure, end: &Step, cut: &Step, locator: &mut Locator<'_>) -> Diagnostic {
    let last = procedure.steps.iter().rev().find(|step| !is_end(step)).map_or(&cut.tag, |step| &step.tag);
    let message = format!("`{}` ends the procedure as it begins, and `{}` is cut", end.tag, cut.tag);
    Diagnostic::new(Severity::Warning, codes::UNREACHABLE, locator.activity(end.place), message)
        .label(locator.tag(cut.place), "this takes longer")
        .reason("the steps of this procedure begin together, and nothing lets the end wait")
        .help(format!("write `(waitfor (end ?{last}))`, or a sequence, which needs no `(terminate)`"))
}

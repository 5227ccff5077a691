//! Goals, messages and commands against the declarations of a library: the types of their arguments, the names that they mention, and
//! messages that are awaited but never sent (`declare-event`, `declare-command`; `docs/reference/pdl.md`, Text).

mod answers;
mod arguments;
mod calls;
mod known;
mod messages;
mod types;

use super::methods::Methods;
use super::{Program, Report};
use crate::diagnostic::Diagnostic;
use crate::locate::Locator;
use apex_model::library::Library;
use calls::Calls;
pub use known::KnownNames;
use types::Types;

/// Checks that need no mission: types of arguments, and answers of questions.
pub(super) fn check(program: &Program<'_>, report: &mut Report<'_>) {
    answers::check(program, report);
    if !has_declarations(program.library) {
        return;
    }
    let calls = Calls::new(program.library, &program.methods);
    let types = Types::new(program.library, &program.methods, &calls);
    arguments::check(program.library, &calls, &types, report);
}

/// Checks a library without errors against the names of its mission: places, cameras, radios and aircraft that goals, commands and
/// conditions name, solvers, and messages that are awaited though nothing sends them.
pub fn check_names(library: &Library, known: &KnownNames) -> Vec<Diagnostic> {
    let methods = Methods::new(library);
    let mut report = Report { locator: Locator::new(&library.sources), diagnostics: Vec::new() };
    known::solvers(library, known, &mut report);
    known::objects(library, known, &mut report);
    if has_declarations(library) {
        let calls = Calls::new(library, &methods);
        let types = Types::new(library, &methods, &calls);
        known::arguments(known, &calls, &types, &mut report);
        messages::check(library, known, &calls, &mut report);
    }
    report.diagnostics.sort_by_key(|each| (each.span.file, each.span.line, each.span.column, each.severity));
    report.diagnostics
}

/// Without declarations the types of a program are unknown.
fn has_declarations(library: &Library) -> bool {
    !library.commands.is_empty() || !library.events.is_empty()
}

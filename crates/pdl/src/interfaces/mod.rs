//! Goals, messages and commands against the declarations of a library: the types of their arguments, the names that they mention, and
//! messages that are awaited but never sent (`declare-event`, `declare-command`; `docs/reference/pdl.md`, Text).

mod answers;
mod arguments;
mod calls;
mod findings;
mod hours;
mod known;
mod messages;
mod sums;
mod types;

use crate::analysis::methods::Methods;
use crate::diagnostic::Diagnostic;
use apex_model::library::Library;
use calls::Calls;
use findings::Findings;
pub use known::KnownNames;
use types::Types;

/// Checks that need no mission: types of arguments, and answers of questions.
pub(crate) fn check(library: &Library) -> Vec<Diagnostic> {
    let mut findings = Findings::new(&library.sources);
    if !has_declarations(library) && !answers::has_questions(library) {
        return findings.diagnostics;
    }
    let methods = Methods::new(library);
    answers::check(library, &methods, &mut findings);
    if has_declarations(library) {
        let calls = Calls::new(library, &methods);
        let types = Types::new(library, &methods, &calls);
        arguments::check(library, &calls, &types, &mut findings);
        messages::check_declared(library, &mut findings);
        sums::check(library, &types, &mut findings);
    }
    findings.diagnostics
}

/// Checks a library without errors against the names of its mission: places, cameras, radios and aircraft that goals, commands and
/// conditions name, solvers, instants after its end, and messages that are awaited though nothing sends them.
pub fn check_names(library: &Library, known: &KnownNames) -> Vec<Diagnostic> {
    let methods = Methods::new(library);
    let mut findings = Findings::new(&library.sources);
    known::solvers(library, known, &mut findings);
    known::objects(library, known, &mut findings);
    hours::check(library, known, &mut findings);
    if has_declarations(library) {
        let calls = Calls::new(library, &methods);
        let types = Types::new(library, &methods, &calls);
        known::arguments(known, &calls, &types, &mut findings);
        messages::check(library, known, &calls, &mut findings);
    }
    findings.diagnostics.sort_by_key(|each| (each.span.file, each.span.line, each.span.column, each.severity));
    findings.diagnostics
}

/// Returns true if the program declares messages or commands; without declarations, types are unknown.
fn has_declarations(library: &Library) -> bool {
    !library.commands.is_empty() || !library.events.is_empty()
}

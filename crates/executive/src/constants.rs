//! Constants: every `defconstant` that is an expression is computed once, as the agent is loaded.

use crate::expression::view::View;
use crate::expression::{EvalContext, evaluate};
use crate::state::agent::Agent;
use crate::state::clause::Level;
use apex_model::expression::{Expr, ExprKind};
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use std::sync::Arc;

/// Returns the constants of `library` that are not written as values, with their values.
///
/// # Errors
/// Place and reason of the first constant that has no value.
pub(crate) fn compute(library: &Library, context: &dyn EvalContext) -> Result<Vec<(Symbol, Expr)>, String> {
    let (values, failures) = values(library, context);
    match failures.into_iter().next() {
        Some((name, place, reason)) => {
            let place = library.describe_place(place);
            Err(format!("{place}: the constant `{name}` has no value: {reason}"))
        }
        None => Ok(values),
    }
}

/// Returns each constant of `library` that has no value: its name, the place of the expression that fails, and the reason. Returns an
/// empty list while a function that the host registers is missing, because constants may call it.
pub fn failing_constants(library: &Arc<Library>, host: HostFunctions) -> Vec<(Symbol, Place, String)> {
    let mut declared = library.host_functions.iter();
    if library.constants.is_empty() || declared.any(|(name, function)| !function.command && host.get(name).is_none()) {
        return Vec::new();
    }
    let mut agent = Agent::default();
    agent.attach(Arc::clone(library), host);
    // The expressions are evaluated without a task: the checker rejects constants whose expressions refer to one.
    let view = View { agent: &agent, task: TaskId(u64::MAX), level: Level::Procedure, now: agent.now };
    let mut failures = values(library, &view).1;
    // A constant that fails only because it uses another failing constant is not reported.
    let at = |place: Place| (place.file, place.line, place.column);
    failures.retain(|(name, place, _)| {
        let before = library.constants.iter().filter(|(_, expr)| at(expr.place) <= at(*place));
        before.max_by_key(|(_, expr)| at(expr.place)).is_none_or(|(owner, _)| owner == name)
    });
    failures
}

type Values = Vec<(Symbol, Expr)>;
type Failures = Vec<(Symbol, Place, String)>;

fn values(library: &Library, context: &dyn EvalContext) -> (Values, Failures) {
    let (mut values, mut failures) = (Vec::new(), Vec::new());
    for (name, expr) in library.constants.iter().filter(|(_, expr)| !matches!(expr.kind, ExprKind::Constant(_))) {
        match evaluate(expr, context) {
            Ok(value) => values.push((name.clone(), Expr { kind: ExprKind::Constant(value), place: expr.place })),
            Err(error) => failures.push((name.clone(), error.place, error.message)),
        }
    }
    (values, failures)
}

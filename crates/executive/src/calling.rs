//! Calls of library functions by name, outside of any task: for expressions in the data of a mission.

use crate::expression::evaluate;
use crate::expression::view::View;
use crate::state::agent::Agent;
use crate::state::clause::Level;
use apex_model::expression::{Expr, ExprKind};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Returns the value of a function of the agent's library, or of a host function, for `arguments`. The function sees the agent's
/// variables and samples but no task, and changes nothing.
///
/// # Errors
/// Place and reason if the function does not exist, does not accept these arguments, or has no value for them.
pub fn call(agent: &Agent, function: &Symbol, arguments: &[Value]) -> Result<Value, String> {
    let place = agent.library.functions.get(function).map_or_else(Place::default, |defined| defined.place);
    let constant = |value: &Value| Expr { kind: ExprKind::Constant(value.clone()), place };
    let arguments = arguments.iter().map(constant).collect();
    let expr = Expr { kind: ExprKind::Call { function: function.clone(), arguments }, place };
    let view = View { agent, task: TaskId(u64::MAX), level: Level::Procedure, now: agent.now };
    evaluate(&expr, &view).map_err(|error| format!("{}: {}", agent.library.describe_place(error.place), error.message))
}

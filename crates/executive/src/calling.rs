//! Functions of a library, called by their names outside of any task: what a mission's data are computed by.

use crate::expression::evaluate;
use crate::expression::view::View;
use crate::state::agent::Agent;
use crate::state::clause::Level;
use apex_model::expression::{Expr, ExprKind};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Returns the value of a function of the agent's library, or a host function, for these arguments. It sees what the agent knows and no
/// task, and changes nothing.
///
/// # Errors
/// Place and reason where there is no such function, it does not take these arguments, or it has no value for them.
pub fn call(agent: &Agent, function: &Symbol, arguments: &[Value]) -> Result<Value, String> {
    let place = agent.library.functions.get(function).map_or_else(Place::default, |defined| defined.place);
    let constant = |value: &Value| Expr { kind: ExprKind::Constant(value.clone()), place };
    let arguments = arguments.iter().map(constant).collect();
    let expr = Expr { kind: ExprKind::Call { function: function.clone(), arguments }, place };
    let view = View { agent, task: TaskId(u64::MAX), level: Level::Procedure, now: agent.now };
    evaluate(&expr, &view).map_err(|error| format!("{}: {}", agent.library.describe_place(error.place), error.message))
}

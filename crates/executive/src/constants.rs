//! Constants: every `defconstant` that is an expression is computed once, as the agent is loaded.

use crate::expression::evaluate;
use crate::view::View;
use apex_model::agent::Agent;
use apex_model::clause::Level;
use apex_model::expression::{Expr, ExprKind};
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use std::sync::Arc;

/// Replaces the definitions of the agent's constants by their values.
///
/// # Errors
/// Place and reason of the first constant that has no value.
pub(crate) fn compute(agent: &mut Agent) -> Result<(), String> {
    if agent.library.constants.values().all(|expr| matches!(expr.kind, ExprKind::Constant(_))) {
        return Ok(());
    }
    let mut values: Vec<(Symbol, Expr)> = Vec::new();
    // No task: the checker lets nothing into a constant that would ask for one.
    let view = View { agent, task: TaskId(u64::MAX), level: Level::Procedure, now: agent.now };
    for (name, expr) in &agent.library.constants {
        let value = evaluate(expr, &view).map_err(|error| {
            let place = agent.library.describe_place(error.place);
            format!("{place}: the constant `{name}` has no value: {}", error.message)
        })?;
        values.push((name.clone(), Expr { kind: ExprKind::Constant(value), place: expr.place }));
    }
    Arc::make_mut(&mut agent.library).constants.extend(values);
    Ok(())
}

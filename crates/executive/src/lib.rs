//! The executive: one door in, one door out.

mod expression;
mod monitoring;
#[cfg(test)]
mod test_support;

pub use apex_model::agent::Agent;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use std::sync::Arc;

/// Makes the agent described by `declaration`. Its root task is created by the first [`step`].
///
/// # Errors
/// A message for people when the library cannot be executed (an undeclared host function without implementation, say).
pub fn load(library: Arc<Library>, declaration: &AgentDeclaration, host: HostFunctions) -> Result<Agent, String> {
    let _ = declaration;
    let mut agent = Agent::default();
    agent.attach(library, host);
    Ok(agent)
}

/// Advances `agent` to `batch.now` with the batch's events; returns what it wants done, in order.
pub fn step(agent: &mut Agent, batch: &Batch) -> Vec<Effect> {
    let _ = (agent, batch);
    Vec::new()
}

//! The executive: one door in, one door out.
//!
//! [`load`] makes an agent, [`step`] advances it. Nothing else changes an agent; [`explanation`] reads it.
//! The executive knows no syntax, no clock, no I/O and no randomness: the same inputs give the same effects.

mod constants;
mod control;
mod cycle;
mod deliberation;
mod expression;
mod monitoring;
mod step;
#[cfg(test)]
mod test_support;
mod view;

pub mod explanation;
pub mod planted;

pub use apex_model::agent::Agent;
pub use step::step;

use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use std::sync::Arc;

/// Makes the agent described by `declaration`. Its root task is created by the first [`step`].
///
/// # Errors
/// A message for people when the library cannot be executed: it declares a host function that the host did not register,
/// or a constant that cannot be computed.
pub fn load(library: Arc<Library>, declaration: &AgentDeclaration, host: HostFunctions) -> Result<Agent, String> {
    for (name, function) in &library.host_functions {
        if !function.command && host.get(name).is_none() {
            let place = library.describe_place(function.place);
            return Err(format!(
                "{place}: the host function `{name}` is declared but not registered; register it before loading, or declare it with `:command t` if it is a command"
            ));
        }
    }
    let mut agent = Agent {
        name: declaration.name.clone(),
        initial_task: declaration.initial_task.clone(),
        bundles: declaration.bundles.clone(),
        workload: declaration.workload,
        ..Agent::default()
    };
    monitoring::prepare(&mut agent.histories, &library);
    agent.attach(library, host);
    constants::compute(&mut agent)?;
    Ok(agent)
}

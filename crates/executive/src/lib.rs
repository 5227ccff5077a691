//! The executive: a function that advances an agent by a batch of events and returns effects.
//!
//! [`load`] makes an agent, [`step`] advances it. Nothing else changes an agent; [`explanation`] reads it.
//! [`MonitorSession`] watches conditions without any agent or task.
//! The executive knows no syntax, no clock, no I/O and no randomness: the same inputs give the same effects.

mod calling;
mod constants;
mod control;
mod deliberation;
mod expression;
mod monitoring;
mod phases;
mod registration;
mod session;
mod step;
#[cfg(test)]
mod test_support;

pub mod explanation;
pub mod memory;
pub mod planted;
pub mod state;

pub use calling::call;
pub use constants::failing_constants;
pub use session::{Judgement, MonitorResult, MonitorSession, ResultEvent, SamplingGap, SessionError};
pub use state::agent::Agent;
pub use step::step;

use crate::expression::view::View;
use crate::monitoring::memory::retention;
use crate::state::clause::Level;
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::task::TaskId;
use std::sync::Arc;

/// Makes the agent described by `declaration`. Its root task is created by the first [`step`].
///
/// # Errors
/// An error message if the library cannot be executed: it declares a host function that the host did not register, or a constant that
/// cannot be computed.
pub fn load(library: Arc<Library>, declaration: &AgentDeclaration, host: HostFunctions) -> Result<Agent, String> {
    registration::all_registered(&library, &host)?;
    let mut agent = Agent {
        name: declaration.name.clone(),
        initial_task: declaration.initial_task.clone(),
        bundles: declaration.bundles.clone(),
        workload: declaration.workload,
        limits: declaration.limits.clone(),
        ..Agent::default()
    };
    agent.histories.limit(&agent.limits);
    agent.attach(library, host);
    retention::prepare(&mut agent.histories, &agent.library, Some(&agent.index));
    // The view has no task, because the checker excludes expressions that need one from constants.
    let nobody = View { agent: &agent, task: TaskId(u64::MAX), level: Level::Procedure, now: agent.now };
    let values = constants::compute(&agent.library, &nobody)?;
    if !values.is_empty() {
        Arc::make_mut(&mut agent.library).constants.extend(values);
    }
    Ok(agent)
}

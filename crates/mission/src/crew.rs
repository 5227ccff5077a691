//! Creates the agents of a mission with the host functions of that mission.

use crate::error::MissionResult;
use crate::ways::{Limits, register};
use crate::{Mission, acquisition, program};
use apex_executive::Agent;
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::source::SourceFile;
use std::sync::Arc;

/// Returns the functions of a mission: ways to places keep out of its zones, inside its permitted area and within its landing distance.
pub fn host_functions_of(mission: &Mission) -> HostFunctions {
    let mut functions = program::host_functions();
    register(Limits::of(mission), &mut functions);
    acquisition::register(mission, &mut functions);
    functions
}

/// Returns the agents of a mission's program, ready for their first steps, in the order of their declarations.
///
/// # Errors
/// If the program declares a host function that does not exist.
pub fn crew_of_mission(mission: &Mission) -> MissionResult<Vec<Agent>> {
    program::crew_with(&mission.library, &host_functions_of(mission))
}

/// Like [`program::load_recorded`], with the functions of the mission that the record holds.
///
/// # Errors
/// Like [`program::load_recorded`].
pub fn load_recorded_mission(
    mission: &Mission,
    sources: &[SourceFile],
) -> Result<(Arc<Library>, AgentDeclaration, HostFunctions), String> {
    let (library, declaration, _) = program::load_recorded(sources)?;
    Ok((library, declaration, host_functions_of(mission)))
}

//! Restores the agent at an instant, from the nearest snapshot and the inputs after it.

use super::reader::RecordReader;
use super::steps::Steps;
use crate::error::RecordError;
use apex_executive::{Agent, step};
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::source::SourceFile;
use apex_model::time::Time;
use std::sync::Arc;

/// Checked form of the PDL sources in a record: library, the agent to run, and host functions.
pub type RestoredProgram = (Arc<Library>, AgentDeclaration, HostFunctions);

/// Checks the recorded PDL sources again; passed in, because this crate knows no syntax.
pub type LoadProgram<'a> = &'a dyn Fn(&[SourceFile]) -> Result<RestoredProgram, String>;

impl RecordReader {
    /// Loads the recorded mission.
    ///
    /// # Errors
    /// [`RecordError::Damaged`] or [`RecordError::Load`] with the loader's message.
    pub fn load(&self, load: LoadProgram<'_>) -> Result<RestoredProgram, RecordError> {
        load(&self.pdl_sources()?).map_err(|message| RecordError::Load { path: self.path.clone(), message })
    }

    /// Returns the agent after the last step not later than `at`. Neither solvers nor the vehicle are called: their answers are in the
    /// record.
    ///
    /// # Errors
    /// [`RecordError`] when the record cannot be read or its mission not loaded.
    pub fn restore(&self, at: Time, load: LoadProgram<'_>) -> Result<Agent, RecordError> {
        let program = self.load(load)?;
        self.restore_with(at, &program)
    }

    /// Like [`RecordReader::restore`], with a program that is loaded already.
    ///
    /// # Errors
    /// [`RecordError`] when the record cannot be read or its mission not loaded.
    pub fn restore_with(&self, at: Time, program: &RestoredProgram) -> Result<Agent, RecordError> {
        self.check_growth()?;
        // A snapshot of another build may decode into nonsense. Ignoring it loses nothing: the inputs alone suffice.
        let stored = if self.has_own_states()? { self.snapshot_before(at)? } else { None };
        let snapshot =
            stored.and_then(|(batch, body)| postcard::from_bytes::<Agent>(&body).ok().map(|agent| (batch, agent)));
        let (first, mut agent) = match snapshot {
            Some((batch, mut agent)) => {
                agent.attach(Arc::clone(&program.0), program.2.clone());
                (batch + 1, agent)
            }
            None => (1, self.fresh_agent(program)?),
        };
        let gap = self.gaps()?.into_iter().rfind(|gap| gap.first_batch >= first && at > gap.after);
        if let Some(gap) = gap {
            return Err(RecordError::Question(format!(
                "The state at {at} is not known: the record has a gap ({gap}). Ask for an instant up to {}, or for a later one.",
                gap.after
            )));
        }
        for recorded in Steps::new(self, first, at)?.without_effects() {
            step(&mut agent, &recorded?.batch);
        }
        Ok(agent)
    }

    /// Returns the agent before its first step.
    pub(crate) fn fresh_agent(&self, program: &RestoredProgram) -> Result<Agent, RecordError> {
        self.fresh_agent_number(program, self.agent)
    }

    /// Returns agent `agent` before its first step.
    pub(crate) fn fresh_agent_number(&self, program: &RestoredProgram, agent: usize) -> Result<Agent, RecordError> {
        let (library, declaration, host) = program;
        let declaration = if self.has_several_agents() { library.agents.get(agent) } else { Some(declaration) };
        let missing = || RecordError::Load {
            path: self.path.clone(),
            message: format!("its PDL declares no agent number {}", agent + 1),
        };
        apex_executive::load(Arc::clone(library), declaration.ok_or_else(missing)?, host.clone())
            .map_err(|message| RecordError::Load { path: self.path.clone(), message })
    }
}

//! The agent: all state that can influence behaviour, in one value that can be cloned, compared and stored.

use crate::host::HostFunctions;
use crate::library::Library;
use crate::time::Time;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// An agent. A snapshot is its serialised form; library and host functions are put back by [`Agent::attach`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// The checked library; not part of a snapshot.
    #[serde(skip)]
    pub library: Arc<Library>,
    /// Registered host functions; not part of a snapshot.
    #[serde(skip)]
    pub host: HostFunctions,
}

impl Agent {
    /// Puts library and host functions back into an agent read from a snapshot.
    pub fn attach(&mut self, library: Arc<Library>, host: HostFunctions) {
        self.library = library;
        self.host = host;
    }

    /// When the agent must be stepped next if nothing happens before, and why.
    pub fn next_wake(&self) -> Option<(Time, String)> {
        None
    }

    /// True after `EndApplication`: nothing will happen any more.
    pub fn is_finished(&self) -> bool {
        false
    }
}

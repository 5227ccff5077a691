//! Memory of an agent in bytes, apart from items that are limited by number.

use serde::{Deserialize, Serialize};

/// Memory of the agent in addition to tasks and monitors, in bytes. Part of the agent, so that replay refuses the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryCount {
    /// Large values and samples at the last count.
    pub counted: u64,
    /// Large values that were bound since; some may be gone.
    pub since: u64,
}

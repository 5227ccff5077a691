//! Bytes that an agent holds in large values and samples; tasks and monitors are counted by number.

use serde::{Deserialize, Serialize};

/// Bytes of large values and samples. Part of the agent, so that replay refuses the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryCount {
    /// Large values and samples at the last count.
    pub counted: u64,
    /// Large values that were bound since; some may be gone.
    pub since: u64,
}

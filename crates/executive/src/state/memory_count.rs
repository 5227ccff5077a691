//! Bytes of large values and samples of an agent; tasks and monitors are counted by number.

use serde::{Deserialize, Serialize};

/// Bytes of large values and samples. Part of the agent, so that a replay rejects the same tasks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryCount {
    /// Bytes of large values and samples at the last count.
    pub counted: u64,
    /// Bytes of large values bound since the last count; some of these values may no longer exist.
    pub since: u64,
}

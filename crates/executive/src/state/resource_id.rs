//! Numbers of resources, by which holders and claimants refer to them.

use serde::{Deserialize, Serialize};

/// Number of a resource within one agent, in order of first use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ResourceId(pub u32);

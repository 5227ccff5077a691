//! Numbers of resources: what holders and claimants alike name a resource by.

use serde::{Deserialize, Serialize};

/// Numbers a resource within one agent, in order of first use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ResourceId(pub u32);

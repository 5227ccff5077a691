//! The means of continuing flights and of drafting plans.

use crate::operation::ReadDatum;
use crate::what_if::fork_list::Forks;
use apex_mission::deliberation::PlanningResources;
use std::sync::{Arc, Mutex};

/// The means of continuing flights and of drafting plans.
pub(crate) struct WhatIf {
    pub(crate) means: PlanningResources,
    pub(crate) read: ReadDatum,
    pub(crate) forks: Arc<Forks>,
    /// Permits one draft at a time.
    pub(crate) drafting: Mutex<()>,
}

impl WhatIf {
    pub(crate) fn new(means: PlanningResources, read: ReadDatum) -> WhatIf {
        WhatIf { means, read, forks: Arc::default(), drafting: Mutex::default() }
    }
}

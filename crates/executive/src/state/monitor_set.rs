//! Sets of monitors: most contain one, which needs no allocation; members are listed in order of their numbers.

use crate::state::clause::MonitorId;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;
use std::collections::BTreeSet;

/// Monitors that must receive a stimulus: mostly a few.
pub type MonitorIds = SmallVec<[MonitorId; 8]>;

/// A set of monitors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum MonitorSet {
    /// None.
    #[default]
    Empty,
    /// Just this one.
    One(MonitorId),
    /// Two or more; fewer only after removals.
    Many(Box<BTreeSet<MonitorId>>),
}

impl MonitorSet {
    /// Adds a monitor, unless it is there already.
    pub fn insert(&mut self, monitor: MonitorId) {
        match self {
            MonitorSet::Empty => *self = MonitorSet::One(monitor),
            MonitorSet::One(present) if *present == monitor => {}
            MonitorSet::One(present) => *self = MonitorSet::Many(Box::new(BTreeSet::from([*present, monitor]))),
            MonitorSet::Many(set) => {
                set.insert(monitor);
            }
        }
    }

    /// Removes a monitor. Returns false if it was not there.
    pub fn remove(&mut self, monitor: MonitorId) -> bool {
        match self {
            MonitorSet::Empty => false,
            MonitorSet::One(present) => {
                let found = *present == monitor;
                if found {
                    *self = MonitorSet::Empty;
                }
                found
            }
            MonitorSet::Many(set) => {
                let found = set.remove(&monitor);
                if set.is_empty() {
                    *self = MonitorSet::Empty;
                }
                found
            }
        }
    }

    /// Returns true if there are no members.
    pub fn is_empty(&self) -> bool {
        matches!(self, MonitorSet::Empty)
    }

    /// Adds all members to `found`.
    pub fn collect_into(&self, found: &mut MonitorIds) {
        match self {
            MonitorSet::Empty => {}
            MonitorSet::One(present) => found.push(*present),
            MonitorSet::Many(set) => found.extend(set.iter().copied()),
        }
    }
}

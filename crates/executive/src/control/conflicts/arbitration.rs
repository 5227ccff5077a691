//! Outcome of an arbitration (TC)
//! What: states the grants, losses and refusals, with the rule and the strengths that decided.
//! Runs: made in the contend phase, read in the commit phase.  Reads: nothing.  Writes: nothing.
//! Bound: O(1).
//! PDL: section 9, conflict.  Paper: section III, detecting and resolving conflicts.

use crate::control::conflicts::sharing::UseKind;
use crate::state::resource_id::ResourceId;
use apex_model::because::{ConflictRule, Strength};
use apex_model::task::TaskId;
use std::rc::Rc;

/// Decisions of an arbitration.
#[derive(Default)]
pub(crate) struct Arbitration {
    /// Claimants that get all they need.
    pub(crate) granted: Vec<TaskId>,
    /// Holders that lose their resources.
    pub(crate) displaced: Vec<Defeat>,
    /// Claimants that get nothing, displaced holders included.
    pub(crate) refused: Vec<Refusal>,
    /// Claimants whose needs exceed the whole resource: claimant, resource, needed amount, total of the resource.
    pub(crate) impossible: Vec<(TaskId, ResourceId, f64, f64)>,
    /// Claimants that were excluded because their parents seemed to stop, although their parents continue in the final result.
    pub(crate) barred: Vec<TaskId>,
    /// Claimants that may win later because priorities change with time.
    pub(crate) watched: Vec<PriorityWatch>,
}

impl Arbitration {
    /// Adds the decisions about other resources.
    pub(crate) fn absorb(&mut self, part: Arbitration) {
        let Arbitration { granted, displaced, refused, impossible, barred, watched } = part;
        self.granted.extend(granted);
        self.displaced.extend(displaced);
        self.refused.extend(refused);
        self.impossible.extend(impossible);
        self.barred.extend(barred);
        self.watched.extend(watched);
    }
}

/// A conflict lost.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Defeat {
    /// The loser.
    pub(crate) loser: TaskId,
    /// The resource that the conflict is about.
    pub(crate) resource: ResourceId,
    /// The winner.
    pub(crate) winner: TaskId,
    /// The rule that decided.
    pub(crate) rule: ConflictRule,
    /// The winner's priority or rank; includes its interrupt cost if the winner is the holder.
    pub(crate) winner_strength: Strength,
    /// The loser's priority or rank, by the same rule.
    pub(crate) loser_strength: Strength,
    /// True if the winner has the resource or gets it in this arbitration; false if it is only an earlier claimant.
    pub(crate) winner_holds: bool,
}

/// A claimant that gets nothing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    /// The conflict that is reported.
    pub(crate) loss: Defeat,
    /// Kind of use with which this claim counts against later claimants.
    pub(crate) claim: UseKind,
    /// Tasks whose priorities count for the loser: itself, and those that it precedes.
    pub(crate) stands_for: Rc<[TaskId]>,
    /// All tasks that block the claimant: at least one of them would have to yield.
    pub(crate) rivals: Vec<Rival>,
}

/// A task that blocks a claimant.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rival {
    /// Its number.
    pub(crate) task: TaskId,
    /// True if the rival has the resource, false if it only claims it.
    pub(crate) holds: bool,
    /// Tasks whose priorities count for the rival.
    pub(crate) stands_for: Rc<[TaskId]>,
}

/// A claimant whose priority is compared again when the passing of time may have reversed the order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PriorityWatch {
    /// The claimant.
    pub(crate) task: TaskId,
    /// Tasks whose priorities count for the claimant.
    pub(crate) stands_for: Rc<[TaskId]>,
    /// All tasks that block the claimant.
    pub(crate) rivals: Vec<Rival>,
}

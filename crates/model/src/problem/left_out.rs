//! Targets that a plan leaves out.

use serde::{Deserialize, Serialize};

/// A target that a plan does not visit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The target's name.
    pub target: String,
    /// Reason, for example "needs 41 min more than endurance leaves".
    pub reason: String,
    /// The same as a value, if the reason is one of the list; the text rounds its figures.
    #[serde(default)]
    pub obstacle: Option<Obstacle>,
}

/// Obstacle of a visit: what would have to be different for a target to be visited, by the planner's own arithmetic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Obstacle {
    /// Flying there takes longer than a limit allows.
    Late {
        /// Seconds beyond the limit.
        over_s: f64,
        /// The limit.
        limit: TimeLimit,
        /// True if the target cannot be visited as the only one either.
        alone: bool,
    },
    /// A visit earns less than its time costs.
    Score {
        /// Points by which the score would fall.
        loss: f64,
    },
    /// A visit would let the others wait longer.
    ExpectedCost {
        /// Expected cost without the visit.
        without: f64,
        /// Expected cost with it.
        with: f64,
    },
    /// A visit is worth nothing.
    Worthless,
    /// The last time window closes too early.
    Window,
}

/// Limit on the time of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TimeLimit {
    /// The limit of the flight.
    Flight {
        /// Its name: `endurance`, `the end of the mission`.
        name: String,
        /// Its cause, if the problem states one.
        cause: Option<String>,
        /// True if it is the time for which the energy lasts.
        is_energy: bool,
    },
    /// The horizon of the plan.
    Horizon,
    /// The time between the other visits.
    OtherVisits,
}

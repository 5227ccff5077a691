//! Parts of the situation that the report and the next plan read: notes, chosen procedures, the plan that is flown.

use apex_model::problem::Plan;
use apex_model::source::Place;
use apex_model::time::Time;
use serde::{Deserialize, Serialize};

/// A notable decision.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// Instant.
    pub at: Time,
    /// Text, one line.
    pub text: String,
}

/// A procedure that was chosen for a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Chosen {
    /// Place of the procedure.
    pub place: Place,
    /// Instant of its choice.
    pub since: Time,
}

/// A plan and the instant of its request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MadePlan {
    /// The plan.
    pub plan: Plan,
    /// Instant at which its problem was posed.
    pub made: Time,
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::{LeftOut, Obstacle, SurveillancePlan, TimeLimit};

    /// Snapshots of the situation have no names of members, so that none may be left out.
    #[test]
    fn a_plan_with_and_without_obstacles_comes_back_from_a_snapshot() {
        let left_out = |obstacle| LeftOut { target: "barn".into(), reason: "far".into(), obstacle };
        let limit = TimeLimit::Flight { name: "endurance".into(), cause: None, is_energy: true };
        let late = Obstacle::Late { over_s: 90.25, limit, alone: false };
        let plan = SurveillancePlan {
            solver: "x".into(),
            cycle: Vec::new(),
            visits: Vec::new(),
            return_s: None,
            expected_cost: 1.0,
            expected_cost_bound: None,
            left_out: vec![left_out(None), left_out(Some(late)), left_out(Some(Obstacle::Window))],
            summary: String::new(),
        };
        let made = MadePlan { plan: Plan::Surveillance(plan), made: Time(5) };
        let bytes = postcard::to_stdvec(&made).unwrap();
        assert_eq!(postcard::from_bytes::<MadePlan>(&bytes).unwrap(), made);
    }
}

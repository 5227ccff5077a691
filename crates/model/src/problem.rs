//! Planning problems and plans: the input and output of solvers (paper, sections II and V.C).
//!
//! Plain data, so that a problem or a plan can be stored, sent and compared as a whole. All numbers are SI; times are seconds since the
//! problem's own zero (usually the start of the mission). Travel, wind and light are computed by `apex-geo`, cost and score by
//! `apex-metrics`.

mod left_out;
mod place;
mod single_visit;
mod surveillance;
mod travel_times;

pub use left_out::{LeftOut, Obstacle, TimeLimit};
pub use place::{AirspaceZone, Area, FOREVER_S, LandingPlace, Position, TimeWindow, WindField, WindLayer, ZoneKind};
pub use single_visit::{
    CrewMember, FailureTerm, Light, Manoeuvre, MustVisit, NamedLimit, PictureWork, PlannedVisit, QualityFactor,
    QualityFactors, SingleVisitPlan, SingleVisitProblem, SingleVisitTarget, SingleVisitVehicle,
};
pub use surveillance::{
    CostFunction, EventRate, SurveillancePlan, SurveillanceProblem, SurveillanceTarget, SurveillanceVisit,
};
pub use travel_times::{LaterTimes, TravelTimes, UNREACHABLE_S};

use serde::{Deserialize, Serialize};

/// A planning problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(clippy::large_enum_variant, reason = "few problems exist at a time; a box would complicate every match")]
pub enum Problem {
    /// Observe targets repeatedly; minimise the expected cost of ignorance.
    Surveillance(SurveillanceProblem),
    /// Visit a subset of targets once each; maximise the mission score.
    SingleVisit(SingleVisitProblem),
}

/// A plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Plan {
    /// Answers [`Problem::Surveillance`].
    Surveillance(SurveillancePlan),
    /// Answers [`Problem::SingleVisit`].
    SingleVisit(SingleVisitPlan),
}

impl Plan {
    /// Returns the name of the solver that made it.
    pub fn solver(&self) -> &str {
        match self {
            Plan::Surveillance(plan) => &plan.solver,
            Plan::SingleVisit(plan) => &plan.solver,
        }
    }

    /// Returns one line for operators: visits, value, and left-out targets.
    pub fn summary(&self) -> &str {
        match self {
            Plan::Surveillance(plan) => &plan.summary,
            Plan::SingleVisit(plan) => &plan.summary,
        }
    }

    /// Returns the targets that the plan does not visit, each with the reason.
    pub fn left_out(&self) -> &[LeftOut] {
        match self {
            Plan::Surveillance(plan) => &plan.left_out,
            Plan::SingleVisit(plan) => &plan.left_out,
        }
    }

    /// Returns the visited targets' names in order; a cycle is listed as flown until the horizon.
    pub fn targets(&self) -> Vec<&str> {
        match self {
            Plan::Surveillance(plan) => plan.visits.iter().map(|visit| visit.target.as_str()).collect(),
            Plan::SingleVisit(plan) => plan.visits.iter().map(|visit| visit.target.as_str()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_include_their_start_and_not_their_end() {
        let window = TimeWindow { from_s: 10.0, until_s: 20.0 };
        assert!(window.contains(10.0) && !window.contains(20.0));
        assert!(TimeWindow::ALWAYS.contains(-1e9) && TimeWindow::ALWAYS.contains(1e9));
        assert!(window.overlaps(19.0, 30.0) && !window.overlaps(20.0, 30.0));
    }

    #[test]
    fn a_rate_holds_from_its_step_on_and_the_first_step_reaches_back() {
        let rate = EventRate { steps: vec![(0.0, 1.0), (100.0, 3.0)] };
        assert_eq!((rate.at(-5.0), rate.at(99.0), rate.at(100.0)), (1.0, 1.0, 3.0));
        assert_eq!(EventRate { steps: vec![] }.at(0.0), 0.0);
    }

    #[test]
    fn timing_is_interpolated_and_held_at_its_ends() {
        let target = SingleVisitTarget { timing: vec![(0.0, 0.0), (10.0, 1.0)], ..SingleVisitTarget::default() };
        assert_eq!((target.timing_at(-1.0), target.timing_at(5.0), target.timing_at(11.0)), (0.0, 0.5, 1.0));
        assert_eq!(SingleVisitTarget::default().timing_at(3.0), 1.0);
    }
}

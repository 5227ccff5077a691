//! The surveillance problem: observe targets repeatedly for the least expected cost of ignorance (paper, sections II and V.C).

use super::{LeftOut, Position, TravelTimes};
use serde::{Deserialize, Serialize};

/// Watch `targets` from time 0 to `horizon_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurveillanceProblem {
    /// Targets to watch; names are unique.
    pub targets: Vec<SurveillanceTarget>,
    /// Travel times between places.
    pub travel: TravelTimes,
    /// End of the mission: open intervals of ignorance are closed here.
    pub horizon_s: f64,
    /// True if the vehicle must be back at its base by the horizon and by the end of its endurance.
    pub return_to_base: bool,
    /// Flight time that fuel or batteries allow, without the reserve; `None`: unlimited.
    pub endurance_s: Option<f64>,
}

/// A target to be observed repeatedly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurveillanceTarget {
    /// Its name.
    pub name: String,
    /// Position, for features of the problem and for display, not for travel times.
    pub position: Position,
    /// Duration of one observation. Ignorance is reset at its end.
    pub dwell_s: f64,
    /// Likelihood of the event that matters.
    pub rate: EventRate,
    /// Cost of an event that is not known, by its age.
    pub cost: CostFunction,
    /// Time since the last observation when the mission starts; 0 is fresh.
    pub initial_age_s: f64,
}

/// Events per second, piecewise constant (events are rare: rates add up as probabilities).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventRate {
    /// `(from_s, events_per_s)` by rising time; the first also holds before its time. Empty is never.
    pub steps: Vec<(f64, f64)>,
}

impl EventRate {
    /// Returns the same rate forever.
    pub fn constant(events_per_s: f64) -> EventRate {
        EventRate { steps: vec![(0.0, events_per_s)] }
    }

    /// Returns the events per second at `time_s`.
    pub fn at(&self, time_s: f64) -> f64 {
        let later = self.steps.iter().rev().find(|(from_s, _)| *from_s <= time_s);
        later.or_else(|| self.steps.first()).map_or(0.0, |(_, events_per_s)| *events_per_s)
    }
}

/// Cost of not knowing of an event for `d` seconds; never falls with `d`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CostFunction {
    /// `cost_per_s d`.
    Linear {
        /// Cost per second of age.
        cost_per_s: f64,
    },
    /// `maximum (1 - exp(-rate_per_s d))`.
    Saturating {
        /// Cost of an event that is never found.
        maximum: f64,
        /// Rate at which the cost grows.
        rate_per_s: f64,
    },
    /// 0 before the deadline, `maximum` from then on.
    Step {
        /// Age from which on the event costs `maximum`.
        deadline_s: f64,
        /// Cost of being late.
        maximum: f64,
    },
    /// `maximum / (1 + exp(-rate_per_s (d - midpoint_s)))`.
    Logistic {
        /// Cost of an event that is never found.
        maximum: f64,
        /// Steepness.
        rate_per_s: f64,
        /// Age of half the maximum.
        midpoint_s: f64,
    },
    /// Another function of the age plus the time that help needs to arrive.
    Delayed {
        /// Added to the age before the cost is taken.
        response_s: f64,
        /// The cost by age of the event when help arrives.
        cost: Box<CostFunction>,
    },
    /// Straight lines between points, constant before the first and after the last.
    Table {
        /// `(age_s, cost)` by rising age.
        points: Vec<(f64, f64)>,
    },
}

/// One observation of one target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurveillanceVisit {
    /// The target's name.
    pub target: String,
    /// Arrival, and begin of the observation.
    pub arrive_s: f64,
    /// End of the observation, at which ignorance is reset.
    pub end_s: f64,
}

/// Observations in order of time, until the horizon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurveillancePlan {
    /// Name of the planner.
    pub solver: String,
    /// Cycle that is flown repeatedly; empty if the plan is not a cycle.
    pub cycle: Vec<String>,
    /// Every visit that ends by the horizon.
    pub visits: Vec<SurveillanceVisit>,
    /// Return to the base, if the problem requires it.
    pub return_s: Option<f64>,
    /// Expected cost of ignorance over the horizon.
    pub expected_cost: f64,
    /// No plan can cost less than this, where a bound is known.
    pub expected_cost_bound: Option<f64>,
    /// Targets never visited, with reasons.
    pub left_out: Vec<LeftOut>,
    /// One line for operators.
    pub summary: String,
}

impl SurveillancePlan {
    /// Returns how much more the plan may cost than the best one, as a share of its cost: 0 means proven optimal. `None` if no bound is
    /// known.
    pub fn gap(&self) -> Option<f64> {
        let bound = self.expected_cost_bound?;
        Some(if self.expected_cost > 0.0 { ((self.expected_cost - bound) / self.expected_cost).max(0.0) } else { 0.0 })
    }
}

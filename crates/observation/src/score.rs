//! The mission score `M = sum_j v_j c_j r_j s_j o_j - (sum_k H_k W_k + P (R C_v + M_l C_m))`.
//!
//! Costs are money, values are points: the mission states how much money one point is worth. In the failure term, P is the
//! probability of a critical failure, C_v the cost of the vehicle and C_m that of the mission, R and M_l the shares of them
//! that are then lost (after L. Young, J. Yetter, M. Guynn, "System analysis applied to autonomy: application to
//! high-altitude long-endurance remotely operated aircraft", AIAA 2005-7103).

use crate::result::TargetResult;
use serde::{Deserialize, Serialize};

/// One entry of the table of costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostRow {
    /// Name of the purpose.
    pub name: String,
    /// Computation of the cost.
    pub term: CostTerm,
}

/// Computation of a cost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CostTerm {
    /// Hours of a member of the crew: `H W`.
    Work {
        /// H.
        hours: f64,
        /// W, money per hour.
        wage_per_hour: f64,
    },
    /// A loss with a probability (predicted), or with the number of its occurrences (flown): `P share cost`.
    Risk {
        /// Probability, or number of occurrences.
        probability: f64,
        /// Share of the cost that is then lost.
        share: f64,
        /// Money.
        cost: f64,
    },
}

impl CostTerm {
    /// Returns the cost in money.
    pub fn money(&self) -> f64 {
        match *self {
            CostTerm::Work { hours, wage_per_hour } => hours * wage_per_hour,
            CostTerm::Risk { probability, share, cost } => probability * share * cost,
        }
    }
}

/// A cost in money and in points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScoredCost {
    /// Name of the purpose.
    pub name: String,
    /// Money.
    pub money: f64,
    /// Points.
    pub points: f64,
}

/// The score with its parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MissionScore {
    /// Points of all targets.
    pub benefits: f64,
    /// Costs, those of missed looks last.
    pub costs: Vec<ScoredCost>,
    /// Sum of the costs in points.
    pub cost_points: f64,
    /// M: benefits less costs, in points.
    pub total: f64,
}

/// Returns the score of results and costs. `money_per_point` converts costs into points and must be positive; it is 1 if the mission
/// states values in money.
pub fn mission_score(results: &[TargetResult], costs: &[CostRow], money_per_point: f64) -> MissionScore {
    let scored = |name: String, money: f64| ScoredCost { name, money, points: money / money_per_point };
    let mut rows: Vec<ScoredCost> = costs.iter().map(|row| scored(row.name.clone(), row.term.money())).collect();
    for result in results {
        for look in &result.looks {
            rows.extend(look.must_missed.map(|cost| scored(format!("{}/{} missed", result.name, look.name), cost)));
        }
    }
    let benefits: f64 = results.iter().map(TargetResult::points).sum();
    let cost_points: f64 = rows.iter().map(|row| row.points).sum();
    MissionScore { benefits, costs: rows, cost_points, total: benefits - cost_points }
}

/// Returns the probability of a critical failure in flight phases, each with a rate per hour and a time in hours:
/// `1 - exp(-sum lambda t)`.
pub fn failure_probability(phases: &[(f64, f64)]) -> f64 {
    let exposure: f64 = phases.iter().map(|(rate_per_hour, hours)| rate_per_hour * hours.max(0.0)).sum();
    -libm::expm1(-exposure)
}

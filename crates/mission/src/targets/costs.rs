//! Costs of ignorance of sites.

use apex_model::problem::CostFunction;

/// Returns the greatest cost of an event; for a cost without a limit that of an hour.
pub(super) fn maximum(cost: &CostFunction) -> f64 {
    match cost {
        CostFunction::Linear { cost_per_s } => cost_per_s * 3600.0,
        CostFunction::Saturating { maximum, .. }
        | CostFunction::Step { maximum, .. }
        | CostFunction::Logistic { maximum, .. } => *maximum,
        CostFunction::Table { points } => points.last().map_or(0.0, |(_, cost)| *cost),
        CostFunction::Delayed { cost, .. } => maximum(cost),
    }
}

//! Variation of the importance of targets: cost of an undetected event times its probability.

use super::classifier::{Classification, Classifier, ClassifierInput};
use super::variability;
use apex_metrics::eci;
use apex_model::problem::CostFunction;

/// The classifier.
#[derive(Clone, Copy, Debug, Default)]
pub struct Importance;

impl Classifier for Importance {
    fn name(&self) -> &'static str {
        "cost"
    }

    fn bins(&self) -> &'static [&'static str] {
        variability::BINS
    }

    fn read(&self, given: &ClassifierInput<'_>) -> Classification {
        let problem = given.problem();
        let importance = |target: &apex_model::problem::SurveillanceTarget| {
            target.rate.at(0.0) * never_found(&target.cost, problem.horizon_s)
        };
        variability::read(&problem.targets.iter().map(importance).collect::<Vec<f64>>())
    }
}

/// Returns the cost of an event that is never detected: the limit if there is one, otherwise the cost at the horizon.
fn never_found(cost: &CostFunction, horizon_s: f64) -> f64 {
    match cost {
        CostFunction::Saturating { maximum, .. }
        | CostFunction::Step { maximum, .. }
        | CostFunction::Logistic { maximum, .. } => *maximum,
        CostFunction::Delayed { cost, .. } => never_found(cost, horizon_s),
        CostFunction::Linear { .. } | CostFunction::Table { .. } => eci::cost_at(cost, horizon_s),
    }
}

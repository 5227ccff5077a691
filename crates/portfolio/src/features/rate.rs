//! Variation of the rates at which the costs of ignorance grow.

use super::classifier::{Classification, Classifier, ClassifierInput};
use super::variability;
use apex_metrics::eci;
use apex_model::problem::CostFunction;

/// Number of halvings of the horizon in the search for the age at which half of the cost is reached: the result is exact to a billionth of
/// the horizon.
const HALVINGS: usize = 30;

/// The classifier.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rate;

impl Classifier for Rate {
    fn name(&self) -> &'static str {
        "rate"
    }

    fn bins(&self) -> &'static [&'static str] {
        variability::BINS
    }

    fn read(&self, given: &ClassifierInput<'_>) -> Classification {
        let problem = given.problem();
        let rate = |target: &apex_model::problem::SurveillanceTarget| rate_per_s(&target.cost, problem.horizon_s);
        variability::read(&problem.targets.iter().map(rate).collect::<Vec<f64>>())
    }
}

/// Returns the rate of a saturating cost. For other costs, returns the rate of the saturating cost that reaches half of its limit at the
/// age at which they reach half of their cost at the horizon.
fn rate_per_s(cost: &CostFunction, horizon_s: f64) -> f64 {
    if let CostFunction::Saturating { rate_per_s, .. } = cost {
        return *rate_per_s;
    }
    let half = 0.5 * eci::cost_at(cost, horizon_s);
    let (mut low_s, mut high_s) = (0.0, horizon_s);
    for _ in 0..HALVINGS {
        let middle_s = 0.5 * (low_s + high_s);
        if eci::cost_at(cost, middle_s) < half { low_s = middle_s } else { high_s = middle_s }
    }
    if high_s > 0.0 { std::f64::consts::LN_2 / high_s } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_of_other_kinds_are_compared_by_their_half() {
        let linear = rate_per_s(&CostFunction::Linear { cost_per_s: 3.0 }, 1000.0);
        assert!((linear - std::f64::consts::LN_2 / 500.0).abs() < 1e-9);
        let step = rate_per_s(&CostFunction::Step { deadline_s: 250.0, maximum: 2.0 }, 1000.0);
        assert!((step - std::f64::consts::LN_2 / 250.0).abs() < 1e-9);
        assert_eq!(rate_per_s(&CostFunction::Saturating { maximum: 2.0, rate_per_s: 0.01 }, 1000.0), 0.01);
    }
}

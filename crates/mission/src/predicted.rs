//! Predicted result of an observation in a plan.

use apex_model::problem::{PlannedVisit, QualityFactors};
use serde::{Deserialize, Serialize};

/// Prediction of a plan for an observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// Coverage, resolution and clarity.
    pub quality: QualityFactors,
    /// Timing factor, 0 to 1.
    pub timing: f64,
    /// Points.
    pub worth: f64,
    /// Mission time of its planned beginning, s: the first line, after the lead-in.
    pub begin_s: f64,
    /// Mission time of its planned end, s.
    pub end_s: f64,
}

impl Predicted {
    /// Returns the prediction of a planned visit whose first line begins `lead_in_s` after it; `None` without a predicted quality.
    pub(crate) fn of(visit: &PlannedVisit, lead_in_s: f64) -> Option<Predicted> {
        let (quality, timing, worth) = (visit.quality.clone()?, visit.timing, visit.worth);
        Some(Predicted { quality, timing, worth, begin_s: visit.begin_s + lead_in_s, end_s: visit.end_s })
    }

    /// Returns the value that the plan counted: that of the look when it was planned, less the worth that had been seen before and that
    /// other visits of the plan were to show. `None` if a factor is 0.
    pub(crate) fn value(&self) -> Option<f64> {
        let factors = self.quality.product() * self.timing;
        (factors > 0.0).then(|| self.worth / factors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_value_times_the_factors_is_the_worth() {
        let mut quality = QualityFactors::default();
        (quality.coverage.factor, quality.clarity.factor) = (0.5, 0.8);
        let predicted = Predicted { quality, timing: 0.5, worth: 4.0, begin_s: 0.0, end_s: 1.0 };
        assert_eq!(predicted.value(), Some(20.0));
        assert_eq!(Predicted { timing: 0.0, worth: 0.0, ..predicted }.value(), None);
    }
}

//! Predicted result of an observation in a plan.

use apex_model::problem::QualityFactors;
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

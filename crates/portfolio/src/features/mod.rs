//! Problem classification (paper, section V.C): features of a mission, which select the best planner.
//!
//! A classifier determines one feature: readable numbers, and the distance of the mission from each of the feature's bins. Each is one
//! file and a row in [`CLASSIFIERS`]; third parties add theirs in the same way and pass their own list to [`classify_with`]. Bound:
//! O(n^2) in the number of targets.

mod classifier;
mod count;
mod importance;
mod pattern;
mod rate;
mod scale;
mod spread;
mod variability;

pub use classifier::{Classification, Classifier, ClassifierInput};
pub use count::Count;
pub use importance::Importance;
pub use rate::Rate;
pub use scale::Scale;
pub use spread::Spread;

use apex_model::problem::SurveillanceProblem;

/// Every classifier, in the order in which names of cells have their words.
pub const CLASSIFIERS: &[&dyn Classifier] = &[&Scale, &Rate, &Importance, &Count, &Spread];

/// A determined feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Its name.
    pub name: &'static str,
    /// The word of its bin.
    pub bin: &'static str,
    /// Numbers and distances.
    pub reading: Classification,
    bins: &'static [&'static str],
}

impl Feature {
    /// Returns the distance to the bin called `word`; `None` if there is no such bin.
    pub fn distance(&self, word: &str) -> Option<f64> {
        let bin = self.bins.iter().position(|bin| *bin == word)?;
        self.reading.distances.get(bin).copied()
    }
}

/// Reads every feature of `problem`.
///
/// # Errors
/// An error message if the problem is invalid.
pub fn classify(problem: &SurveillanceProblem) -> Result<Vec<Feature>, String> {
    classify_with(CLASSIFIERS, problem)
}

/// Reads the features of `classifiers`.
///
/// # Errors
/// An error message if the problem is invalid.
pub fn classify_with(classifiers: &[&dyn Classifier], problem: &SurveillanceProblem) -> Result<Vec<Feature>, String> {
    let given = ClassifierInput::new(problem)?;
    let read = |classifier: &&dyn Classifier| {
        let (reading, bins) = (classifier.read(&given), classifier.bins());
        let bin = bins.get(reading.bin()).copied().unwrap_or_default();
        Feature { name: classifier.name(), bin, reading, bins }
    };
    Ok(classifiers.iter().map(read).collect())
}

/// Returns the features as text, for reasons.
pub fn described(features: &[Feature]) -> String {
    let one = |feature: &Feature| {
        let numbers: Vec<String> =
            feature.reading.numbers.iter().map(|(name, number)| format!("{name} {}", shortened(*number))).collect();
        format!("{} {} ({})", feature.name, feature.bin, numbers.join(", "))
    };
    features.iter().map(one).collect::<Vec<String>>().join("; ")
}

fn shortened(number: f64) -> String {
    if number.abs() >= 10.0 || number.fract() == 0.0 { format!("{number:.0}") } else { format!("{number:.2}") }
}

#[cfg(test)]
mod tests;

//! Number of targets.

use super::classifier::{Classification, Classifier, ClassifierInput};
use crate::cell::COUNTS;

/// The classifier. Counts are compared by their ratio: 6 is as far from 4 as 12 from 8.
#[derive(Clone, Copy, Debug, Default)]
pub struct Count;

impl Classifier for Count {
    fn name(&self) -> &'static str {
        "count"
    }

    fn bins(&self) -> &'static [&'static str] {
        &["4", "8", "16"]
    }

    fn read(&self, given: &ClassifierInput<'_>) -> Classification {
        let count = given.problem().targets.len() as f64;
        let distance = |bin: usize| libm::log2(count / bin as f64).abs();
        Classification { numbers: vec![("targets", count)], distances: COUNTS.into_iter().map(distance).collect() }
    }
}

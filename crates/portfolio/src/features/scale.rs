//! Size of the map, relative to the distance that the vehicle can fly in the mission's time.
//!
//! The number is kappa: the time of the shortest tour over all targets, dwells included, divided by the available time; at 1 a single lap
//! fits. The bin is that of the likeliest pattern of the table.

use super::classifier::{Classification, Classifier, ClassifierInput};
use super::pattern;
use apex_planning::solver::{Budget, WorkBudget};
use apex_planning::tour;

/// Work spent on the tour: a descent, exact for few targets.
const TOUR_UNITS: u64 = 2_000;

/// The classifier.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scale;

impl Classifier for Scale {
    fn name(&self) -> &'static str {
        "scale"
    }

    fn bins(&self) -> &'static [&'static str] {
        &["large", "medium", "small"]
    }

    fn read(&self, given: &ClassifierInput<'_>) -> Classification {
        let unlikelihoods = pattern::unlikelihoods(given);
        let best = |row: &[f64; 3]| row.iter().copied().fold(f64::INFINITY, f64::min);
        Classification { numbers: vec![("kappa", kappa(given))], distances: unlikelihoods.iter().map(best).collect() }
    }
}

/// Returns the time of the shortest tour found over the time available.
fn kappa(given: &ClassifierInput<'_>) -> f64 {
    let (scenario, problem) = (&given.scenario, given.problem());
    let mut budget = WorkBudget::new(TOUR_UNITS);
    let cycle = tour::shortest(scenario, scenario.usable(), &mut budget as &mut dyn Budget);
    let dwell_s: f64 = cycle.iter().filter_map(|index| problem.targets.get(*index)).map(|target| target.dwell_s).sum();
    let travel_s = tour::length(&cycle, |from, to| scenario.typical().between(from, to));
    (travel_s + dwell_s) / scenario.limit_s()
}

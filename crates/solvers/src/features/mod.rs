//! Problem classification (paper, section V.C): features of a given mission, by which the best planner is looked up.
//!
//! A classifier reads one feature: numbers for people, and how far the mission is from each of the feature's bins. Each is
//! one file and a row in [`CLASSIFIERS`]; third parties add theirs the same way and hand their own list to
//! [`classify_with`]. Bound: O(n^2) in the number of targets.

mod count;
mod importance;
mod pattern;
mod rate;
mod scale;
mod spread;
mod variability;

pub use count::Count;
pub use importance::Importance;
pub use rate::Rate;
pub use scale::Scale;
pub use spread::Spread;

use crate::surveillance::scenario::Scenario;
use apex_geo::geodesy::Position;
use apex_geo::plane::{Plane, Point};
use apex_model::problem::{SurveillanceProblem, UNREACHABLE_S};

/// Distance that the missions of the profile table could fly in theirs: an hour at 20 m/s. Maps are compared in this measure,
/// so that a vehicle of twice the speed sees a map of half the size.
const REACH_M: f64 = 72_000.0;
/// Pairs of targets that are looked at to know the speed.
const SPEED_PAIRS_MAX: usize = 1_000;

/// How targets lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Space {
    /// In two crowds.
    TwoClusters,
    /// In one crowd.
    Globular,
    /// Everywhere.
    Uniform,
}

/// A mission with what classifiers ask of it.
#[derive(Debug)]
pub struct Given<'a> {
    scenario: Scenario<'a>,
    points: Vec<Point>,
    reach_m: f64,
}

impl<'a> Given<'a> {
    /// Looks at `problem`.
    ///
    /// # Errors
    /// A sentence where the problem makes no sense or no target can be observed at all.
    pub fn new(problem: &'a SurveillanceProblem) -> Result<Given<'a>, String> {
        let scenario = Scenario::new(problem)?;
        let positions: Vec<Position> = problem.targets.iter().map(|target| target.position).collect();
        let plane = Plane::around(&positions);
        let points: Vec<Point> = positions.iter().filter_map(|position| plane.project(*position)).collect();
        let reach_m = speed_mps(problem, &points) * problem.horizon_s;
        Ok(Given { scenario, points, reach_m })
    }

    /// The problem.
    pub fn problem(&self) -> &'a SurveillanceProblem {
        self.scenario.problem()
    }

    /// Where targets are, in metres on a plane around them.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Metres of the given map for one metre of the table's: 1 for a mission of an hour at 20 m/s.
    fn metres_per_metre(&self) -> f64 {
        if self.reach_m > 0.0 { self.reach_m / REACH_M } else { 1.0 }
    }
}

/// The middle speed from target to target; 0 where there is no way between any two.
fn speed_mps(problem: &SurveillanceProblem, points: &[Point]) -> f64 {
    let pairs = points.iter().enumerate().flat_map(|(from, a)| {
        points.iter().enumerate().skip(from + 1).map(move |(to, b)| (from, to, b.minus(*a).length()))
    });
    let speed = |(from, to, distance_m): (usize, usize, f64)| {
        let time_s = 0.5 * (problem.travel.between(from, to) + problem.travel.between(to, from));
        (time_s > 0.0 && time_s < UNREACHABLE_S).then_some(distance_m / time_s)
    };
    let mut speeds: Vec<f64> = pairs.filter_map(speed).take(SPEED_PAIRS_MAX).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.get(speeds.len() / 2).copied().unwrap_or(0.0)
}

/// What a classifier reads from a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Numbers, each with its name and unit (`tour time over horizon`).
    pub numbers: Vec<(&'static str, f64)>,
    /// How far the mission is from each bin, in the order of [`Classifier::bins`]; the bin with the least is the mission's.
    pub distances: Vec<f64>,
}

impl Reading {
    /// Index of the nearest bin; the first of equals.
    pub fn bin(&self) -> usize {
        let nearest = self.distances.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b));
        nearest.map_or(0, |(bin, _)| bin)
    }
}

/// A problem classifier: one feature of missions of surveillance.
pub trait Classifier: Sync {
    /// The feature's name in tables.
    fn name(&self) -> &'static str;
    /// Words of its bins.
    fn bins(&self) -> &'static [&'static str];
    /// Reads the feature.
    fn read(&self, given: &Given<'_>) -> Reading;
}

/// Every classifier, in the order in which names of cells have their words.
pub const CLASSIFIERS: &[&dyn Classifier] = &[&Scale, &Rate, &Importance, &Count, &Spread];

/// A feature as it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Its name.
    pub name: &'static str,
    /// The word of its bin.
    pub bin: &'static str,
    /// Numbers and distances.
    pub reading: Reading,
    bins: &'static [&'static str],
}

impl Feature {
    /// Distance to the bin called `word`; none where there is no such bin.
    pub fn distance(&self, word: &str) -> Option<f64> {
        let bin = self.bins.iter().position(|bin| *bin == word)?;
        self.reading.distances.get(bin).copied()
    }
}

/// Reads every feature of `problem`.
///
/// # Errors
/// A sentence where the problem makes no sense.
pub fn classify(problem: &SurveillanceProblem) -> Result<Vec<Feature>, String> {
    classify_with(CLASSIFIERS, problem)
}

/// Reads the features of `classifiers`.
///
/// # Errors
/// A sentence where the problem makes no sense.
pub fn classify_with(classifiers: &[&dyn Classifier], problem: &SurveillanceProblem) -> Result<Vec<Feature>, String> {
    let given = Given::new(problem)?;
    let read = |classifier: &&dyn Classifier| {
        let (reading, bins) = (classifier.read(&given), classifier.bins());
        let bin = bins.get(reading.bin()).copied().unwrap_or_default();
        Feature { name: classifier.name(), bin, reading, bins }
    };
    Ok(classifiers.iter().map(read).collect())
}

/// The features in words, for reasons.
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

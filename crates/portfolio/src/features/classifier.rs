//! Classifiers: each determines one feature of a mission.

use apex_geo::geodesy::Position;
use apex_geo::plane::{Plane, Point};
use apex_model::problem::{SurveillanceProblem, UNREACHABLE_S};
use apex_planning::surveillance::scenario::Scenario;

/// Distance that a vehicle can fly in a mission of the profile table: an hour at 20 m/s. Maps are measured relative to this distance, so
/// that a vehicle of twice the speed has a map of half the size.
const REACH_M: f64 = 72_000.0;
/// Greatest number of pairs of targets that are examined to know the speed.
const SPEED_PAIRS_MAX: usize = 1_000;

/// A mission with derived data for classifiers.
#[derive(Debug)]
pub struct ClassifierInput<'a> {
    pub(super) scenario: Scenario<'a>,
    points: Vec<Point>,
    reach_m: f64,
}

impl<'a> ClassifierInput<'a> {
    /// Prepares the input from `problem`.
    ///
    /// # Errors
    /// An error message if the problem is invalid or no target can be observed.
    pub fn new(problem: &'a SurveillanceProblem) -> Result<ClassifierInput<'a>, String> {
        let scenario = Scenario::new(problem)?;
        let positions: Vec<Position> = problem.targets.iter().map(|target| target.position).collect();
        let plane = Plane::around(&positions);
        let points: Vec<Point> = positions.iter().filter_map(|position| plane.project(*position)).collect();
        let reach_m = speed_mps(problem, &points) * problem.horizon_s;
        Ok(ClassifierInput { scenario, points, reach_m })
    }

    /// Returns the problem.
    pub fn problem(&self) -> &'a SurveillanceProblem {
        self.scenario.problem()
    }

    /// Returns the positions of targets, in metres on a plane around them.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Returns the metres of this map per metre of the table's maps: 1 for a mission of an hour at 20 m/s.
    pub(super) fn metres_per_metre(&self) -> f64 {
        if self.reach_m > 0.0 { self.reach_m / REACH_M } else { 1.0 }
    }
}

/// Returns the median speed between targets; 0 if no path exists between any two.
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

/// Result of a classifier.
#[derive(Clone, Debug, PartialEq)]
pub struct Classification {
    /// Numbers, each with its name and unit (`tour time over horizon`).
    pub numbers: Vec<(&'static str, f64)>,
    /// Distance of the mission from each bin, in the order of [`Classifier::bins`]; the bin with the least is the
    /// mission's.
    pub distances: Vec<f64>,
}

impl Classification {
    /// Returns the index of the nearest bin; the first of equals.
    pub fn bin(&self) -> usize {
        let nearest = self.distances.iter().enumerate().min_by(|(_, a), (_, b)| a.total_cmp(b));
        nearest.map_or(0, |(bin, _)| bin)
    }
}

/// A problem classifier: determines one feature of surveillance missions.
pub trait Classifier: Sync {
    /// Returns the feature's name in tables.
    fn name(&self) -> &'static str;
    /// Returns the words of its bins.
    fn bins(&self) -> &'static [&'static str];
    /// Reads the feature.
    fn read(&self, given: &ClassifierInput<'_>) -> Classification;
}

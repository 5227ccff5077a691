//! Problem classification (paper, section V.C): features of a given problem by which the best planner is chosen.
//!
//! Count, spatial distribution, map size, variability of importance and of cost accumulation, and the share of the
//! mission that one tour takes. Bound: O(n^2).

use crate::surveillance::scenario::Scenario;
use crate::two_opt::tour;
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::{Plane, Point};
use apex_metrics::eci;
use apex_model::problem::{SingleVisitProblem, SurveillanceProblem};
use apex_model::solver::{Budget, WorkBudget};

/// Work spent on the tour estimate: a descent from a few starts.
const TOUR_UNITS: u64 = 20_000;
/// Rounds of the division into two clusters: it settles in a few.
const CLUSTER_ROUNDS_MAX: usize = 50;
/// Silhouette above which targets lie in two clusters.
const TWO_CLUSTERS_SILHOUETTE: f64 = 0.65;
/// Nearest-neighbour index below which targets crowd together.
const CROWDED_INDEX: f64 = 0.85;

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

impl std::fmt::Display for Space {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Space::TwoClusters => "in two clusters",
            Space::Globular => "in one cluster",
            Space::Uniform => "uniformly spread",
        })
    }
}

/// The features of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Features {
    /// Number of targets.
    pub count: usize,
    /// How they lie.
    pub space: Space,
    /// Mean silhouette of the best division in two, -1..1.
    pub silhouette: f64,
    /// Mean distance to the nearest neighbour over what a random spread in the same box would have.
    pub neighbour_index: f64,
    /// Longest extent of the targets.
    pub extent_m: f64,
    /// Area of the box around them.
    pub area_m2: f64,
    /// Coefficient of variation of importance: event rate times the cost of an event never found (or value).
    pub importance_variation: f64,
    /// Coefficient of variation of how fast cost gathers.
    pub rate_variation: f64,
    /// Time of the shortest tour with dwells over the time available.
    pub tour_share: f64,
}

/// Features of a surveillance problem.
///
/// # Errors
/// A sentence where the problem makes no sense.
pub fn surveillance(problem: &SurveillanceProblem) -> Result<Features, String> {
    let scenario = Scenario::new(problem)?;
    let positions: Vec<Position> = problem.targets.iter().map(|target| target.position).collect();
    let importance =
        problem.targets.iter().map(|target| target.rate.at(0.0) * eci::cost_at(&target.cost, problem.horizon_s));
    // How fast cost gathers: the share of the horizon's cost that has gathered after a tenth of it.
    let gathering = problem.targets.iter().map(|target| {
        let whole = eci::cost_at(&target.cost, problem.horizon_s);
        if whole > 0.0 { eci::cost_at(&target.cost, 0.1 * problem.horizon_s) / whole } else { 0.0 }
    });
    let mut budget = WorkBudget::new(TOUR_UNITS);
    let cycle = tour::shortest(&scenario, scenario.usable(), &mut budget as &mut dyn Budget);
    let dwell_s: f64 = cycle.iter().filter_map(|index| problem.targets.get(*index)).map(|target| target.dwell_s).sum();
    let travel_s = tour::length(&cycle, |from, to| problem.travel.between(from, to));
    let (importance, gathering) = (importance.collect::<Vec<f64>>(), gathering.collect::<Vec<f64>>());
    let tour_share = (travel_s + dwell_s) / scenario.limit_s();
    Ok(features(&positions, variation(&importance), variation(&gathering), tour_share))
}

/// Features of a single-visit problem. The tour is estimated from the area (0.71 sqrt(n A) for many random points).
pub fn single_visit(problem: &SingleVisitProblem) -> Features {
    let positions: Vec<Position> = problem.targets.iter().map(|target| target.position).collect();
    let values: Vec<f64> = problem.targets.iter().map(|target| target.value).collect();
    let mut features = features(&positions, variation(&values), 0.0, 0.0);
    let tour_m = 0.7124 * libm::sqrt(features.count as f64 * features.area_m2);
    let time_s = problem.vehicle.endurance_s - problem.vehicle.endurance_reserve_s;
    features.tour_share = match &problem.travel {
        // The quickest way into each target: no tour is shorter.
        Some(travel) => {
            let into_s = |to: usize| {
                let from = (0..features.count).filter(|from| *from != to).map(|from| travel.between(from, to));
                from.fold(travel.start_to(to), f64::min)
            };
            (0..features.count).map(into_s).sum::<f64>()
                / (problem.end_s.unwrap_or(time_s) - problem.start_s).min(time_s)
        }
        None => tour_m / problem.vehicle.true_airspeed_mps / time_s,
    };
    features
}

fn features(positions: &[Position], importance_variation: f64, rate_variation: f64, tour_share: f64) -> Features {
    let plane = Plane::around(positions);
    let points: Vec<Point> = positions.iter().filter_map(|position| plane.project(*position)).collect();
    let range = |axis: fn(&Point) -> f64| {
        let bounds = points.iter().map(axis);
        let (low, high) =
            bounds.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        (high - low).max(0.0)
    };
    let area_m2 = range(|point| point.x) * range(|point| point.y);
    let silhouette = two_cluster_silhouette(&points);
    let neighbour_index = neighbour_index(&points, area_m2);
    let space = if points.len() >= 4 && silhouette > TWO_CLUSTERS_SILHOUETTE {
        Space::TwoClusters
    } else if neighbour_index < CROWDED_INDEX {
        Space::Globular
    } else {
        Space::Uniform
    };
    let farthest = |from: &Position| positions.iter().map(|to| geodesy::distance_m(*from, *to)).fold(0.0, f64::max);
    // Beyond a few hundred targets the extent of a sample is as good.
    let extent_m = positions.iter().step_by(positions.len() / 300 + 1).map(farthest).fold(0.0, f64::max);
    Features {
        count: positions.len(),
        space,
        silhouette,
        neighbour_index,
        extent_m,
        area_m2,
        importance_variation,
        rate_variation,
        tour_share,
    }
}

/// Standard deviation over mean; 0 where the mean is.
pub fn variation(numbers: &[f64]) -> f64 {
    let count = numbers.len().max(1) as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let variance = numbers.iter().map(|number| (number - mean) * (number - mean)).sum::<f64>() / count;
    if mean > 0.0 { libm::sqrt(variance) / mean } else { 0.0 }
}

fn neighbour_index(points: &[Point], area_m2: f64) -> f64 {
    let count = points.len();
    if count < 2 || area_m2 <= 0.0 {
        return 1.0;
    }
    let nearest = |at: usize, point: &Point| {
        let others = points.iter().enumerate().filter(|(other, _)| *other != at);
        others.map(|(_, other)| point.minus(*other).length()).fold(f64::INFINITY, f64::min)
    };
    let mean = points.iter().enumerate().map(|(at, point)| nearest(at, point)).sum::<f64>() / count as f64;
    mean / (0.5 * libm::sqrt(area_m2 / count as f64))
}

/// Divides in two from the farthest pair and returns the mean silhouette.
fn two_cluster_silhouette(points: &[Point]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let far = |from: Point| {
        let farther = |a: &&Point, b: &&Point| from.minus(**a).length().total_cmp(&from.minus(**b).length());
        points.iter().max_by(farther).copied().unwrap_or(from)
    };
    let mut centres = (far(*first), far(far(*first)));
    let mut sides = vec![false; points.len()];
    for _ in 0..CLUSTER_ROUNDS_MAX {
        let side = |point: &Point| point.minus(centres.1).length() < point.minus(centres.0).length();
        let next: Vec<bool> = points.iter().map(side).collect();
        let settled = next == sides;
        sides = next;
        let (Some(a), Some(b)) = (mean_of(points, &sides, false), mean_of(points, &sides, true)) else { return 0.0 };
        centres = (a, b);
        if settled {
            break;
        }
    }
    let scores = points.iter().zip(&sides).enumerate().map(|(at, (point, side))| {
        let own = mean_distance(points, &sides, *side, *point, at);
        let other = mean_distance(points, &sides, !*side, *point, at);
        match (own, other) {
            (Some(own), Some(other)) if own.max(other) > 0.0 => (other - own) / own.max(other),
            _ => 0.0,
        }
    });
    scores.sum::<f64>() / points.len() as f64
}

fn mean_of(points: &[Point], sides: &[bool], side: bool) -> Option<Point> {
    let members = points.iter().zip(sides).filter(|(_, at)| **at == side).map(|(point, _)| *point);
    let (sum, count) = members.fold((Point::default(), 0.0), |(sum, count), point| (sum.plus(1.0, point), count + 1.0));
    (count > 0.0).then(|| Point { x: sum.x / count, y: sum.y / count })
}

fn mean_distance(points: &[Point], sides: &[bool], side: bool, point: Point, own: usize) -> Option<f64> {
    let members = points.iter().zip(sides).enumerate().filter(|(at, (_, of))| **of == side && *at != own);
    let (sum, count) =
        members.fold((0.0, 0.0), |(sum, count), (_, (other, _))| (sum + point.minus(*other).length(), count + 1.0));
    (count > 0.0).then(|| sum / count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Generator;
    use crate::surveillance::examples;

    fn spread(count: usize, seed: u64, place: impl Fn(&mut Generator, usize) -> (f64, f64)) -> Features {
        let mut generator = Generator::new(seed);
        let mut problem = examples::random(count, seed);
        for (index, target) in problem.targets.iter_mut().enumerate() {
            let (east, north) = place(&mut generator, index);
            target.position = Position::new(37.0 + north / 111_000.0, -122.0 + east / 88_700.0);
        }
        surveillance(&problem).unwrap()
    }

    #[test]
    fn clusters_are_told_from_a_uniform_spread() {
        for seed in 0..10 {
            let two = spread(16, seed, |random, index| {
                let side = if index % 2 == 0 { -1500.0 } else { 1500.0 };
                (side + 300.0 * random.unit(), 300.0 * random.unit())
            });
            assert_eq!(two.space, Space::TwoClusters, "{two:?}");
            let even = spread(16, seed, |_, index| (1000.0 * (index % 4) as f64, 1000.0 * (index / 4) as f64));
            assert_eq!(even.space, Space::Uniform, "{even:?}");
        }
    }

    #[test]
    fn variation_and_tour_share() {
        assert_eq!(variation(&[2.0, 2.0]), 0.0);
        assert_eq!(variation(&[1.0, 3.0]), 0.5);
        let equal = surveillance(&examples::equal(8, 3)).unwrap();
        assert!(equal.importance_variation < 1e-12 && equal.rate_variation < 1e-12);
        let features = surveillance(&examples::random(16, 3)).unwrap();
        assert!(features.importance_variation > 0.2 && features.tour_share > 0.1 && features.tour_share < 1.0);
    }
}

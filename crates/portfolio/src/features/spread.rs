//! Distribution of targets: two clusters, one cluster, or uniform.
//!
//! The bin is that of the likeliest pattern of the table; silhouette and nearest-neighbour index are for operators and for future
//! classifiers.

use super::classifier::{Classification, Classifier, ClassifierInput};
use super::pattern;
use crate::cell::Space;
use apex_geo::plane::Point;

/// The classifier.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread;

impl Classifier for Spread {
    fn name(&self) -> &'static str {
        "space"
    }

    fn bins(&self) -> &'static [&'static str] {
        &["two-cluster", "globular", "uniform"]
    }

    fn read(&self, given: &ClassifierInput<'_>) -> Classification {
        let unlikelihoods = pattern::unlikelihoods(given);
        let best =
            |space: usize| unlikelihoods.iter().filter_map(|row| row.get(space)).copied().fold(f64::INFINITY, f64::min);
        let numbers = vec![
            ("silhouette", silhouette(given.points())),
            ("nearest-neighbour index", neighbour_index(given.points())),
        ];
        Classification { numbers, distances: (0..Space::ALL.len()).map(best).collect() }
    }
}

/// Returns the mean distance to the nearest neighbour, divided by that of a random distribution in the same box; 1 without a box.
fn neighbour_index(points: &[Point]) -> f64 {
    let range = |axis: fn(&Point) -> f64| {
        let (low, high) = points
            .iter()
            .map(axis)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        high - low
    };
    let area_m2 = range(|point| point.x) * range(|point| point.y);
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

/// Returns the mean silhouette of the division in two, -1..1; 0 if one part is empty.
fn silhouette(points: &[Point]) -> f64 {
    let sides = pattern::divided(points);
    let scores = points.iter().zip(&sides).enumerate().map(|(at, (point, side))| {
        let own = mean_distance(points, &sides, *side, *point, at);
        let other = mean_distance(points, &sides, !*side, *point, at);
        match (own, other) {
            (Some(own), Some(other)) if own.max(other) > 0.0 => (other - own) / own.max(other),
            _ => 0.0,
        }
    });
    scores.sum::<f64>() / points.len().max(1) as f64
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

    fn points(places: &[(f64, f64)]) -> Vec<Point> {
        places.iter().map(|(x, y)| Point { x: *x, y: *y }).collect()
    }

    #[test]
    fn two_pairs_have_a_high_silhouette_and_a_grid_a_high_index() {
        let pairs = points(&[(0.0, 0.0), (1.0, 0.0), (100.0, 0.0), (101.0, 1.0)]);
        assert!(silhouette(&pairs) > 0.98, "{}", silhouette(&pairs));
        let grid: Vec<(f64, f64)> = (0..16).map(|at| (f64::from(at % 4), f64::from(at / 4))).collect();
        // Neighbours at 1 on an area of 9: 1 / (0.5 sqrt(9 / 16)).
        assert!((neighbour_index(&points(&grid)) - 1.0 / 0.375).abs() < 1e-12);
        assert!(silhouette(&points(&grid)) < 0.6);
        assert_eq!((silhouette(&[]), neighbour_index(&[])), (0.0, 1.0));
    }
}

//! Pattern of the profile table that a set of points resembles most: the likelihood of nine patterns, three
//! distributions on maps of three sizes, for any centre.
//!
//! Size and kind are estimated together, because neither is known from the distances alone: four targets in one cluster on a large map are
//! as far apart as four random ones on a medium map.

use super::classifier::ClassifierInput;
use crate::cell::{Scale, Space};
use apex_geo::plane::Point;
use std::f64::consts::PI;

/// Standard deviation of a cluster as a share of the map's side: of a single cluster, and of each of two clusters with the distance of
/// their centres.
const GLOBULAR: f64 = 0.08;
const TWO_CLUSTERS: (f64, f64) = (0.05, 0.76);
/// Width of the transition, as a share of the side, in which the likelihood of a map that is too small for its points falls.
const EDGE: f64 = 0.05;
/// Maximum number of iterations of 2-means clustering; it converges in a few.
const CLUSTER_ROUNDS_MAX: usize = 50;

/// Returns the negative log-likelihood per target of each scale (row) and space (column), less the least of them.
pub(super) fn unlikelihoods(given: &ClassifierInput<'_>) -> [[f64; 3]; 3] {
    let points: Vec<Point> = given
        .points()
        .iter()
        .map(|point| Point { x: point.x / given.metres_per_metre(), y: point.y / given.metres_per_metre() })
        .collect();
    let shape = PointStatistics::of(&points);
    let each = Scale::ALL.map(|scale| Space::ALL.map(|space| -shape.log_likelihood(scale.side_m(), space)));
    let least = each.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let count = points.len().max(1) as f64;
    each.map(|row| row.map(|unlikely| (unlikely - least) / count))
}

/// Statistics of the points for the likelihoods.
struct PointStatistics {
    count: f64,
    width_m: f64,
    height_m: f64,
    square_m2: f64,
    counts: (f64, f64),
    between_m: f64,
    within_m2: f64,
}

impl PointStatistics {
    fn of(points: &[Point]) -> PointStatistics {
        let range = |axis: fn(&Point) -> f64| {
            let ends = points
                .iter()
                .map(axis)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
            (ends.1 - ends.0).max(0.0)
        };
        let sides = divided(points);
        let (a, b) = (mean_of(points, &sides, false), mean_of(points, &sides, true));
        let centre = mean_of(points, &vec![false; points.len()], false);
        let squares = |centre: Option<Point>, chosen: &dyn Fn(bool) -> bool| {
            let members = points.iter().zip(&sides).filter(|(_, side)| chosen(**side));
            members.map(|(point, _)| centre.map_or(0.0, |centre| point.minus(centre).dot(point.minus(centre)))).sum()
        };
        let right = sides.iter().filter(|side| **side).count() as f64;
        let within_m2: f64 = squares(a, &|side| !side);
        PointStatistics {
            count: points.len() as f64,
            width_m: range(|point| point.x),
            height_m: range(|point| point.y),
            square_m2: squares(centre, &|_| true),
            counts: (points.len() as f64 - right, right),
            between_m: a.zip(b).map_or(0.0, |(a, b)| b.minus(a).length()),
            within_m2: within_m2 + squares(b, &|side| side),
        }
    }

    /// Returns the logarithm of the density of the points, integrated over all positions of the map.
    fn log_likelihood(&self, side_m: f64, space: Space) -> f64 {
        match space {
            Space::Uniform => {
                // The map may be shifted as long as it contains all points; the likelihood falls smoothly if they hardly fit.
                let room = |extent_m: f64| {
                    let edge_m = EDGE * side_m;
                    let over = ((extent_m - side_m + edge_m) / edge_m).max(0.0);
                    libm::log((side_m - extent_m).max(edge_m)) - 0.5 * over * over
                };
                room(self.width_m) + room(self.height_m) - 2.0 * self.count * libm::log(side_m)
            }
            Space::Globular => crowd(self.count, self.square_m2, GLOBULAR * side_m),
            Space::TwoClusters => {
                let (deviation_m, distance_m) = (TWO_CLUSTERS.0 * side_m, TWO_CLUSTERS.1 * side_m);
                if self.counts.0.min(self.counts.1) < 1.0 {
                    return f64::NEG_INFINITY;
                }
                let crowds = crowd(self.counts.0, 0.0, deviation_m) + crowd(self.counts.1, 0.0, deviation_m);
                let variance_m2 = deviation_m * deviation_m * (1.0 / self.counts.0 + 1.0 / self.counts.1);
                let off_m = self.between_m - distance_m;
                // All directions are equally likely, and a point may belong to either cluster.
                crowds
                    - 0.5 * self.within_m2 / (deviation_m * deviation_m)
                    - 0.5 * off_m * off_m / variance_m2
                    - 0.5 * libm::log(2.0 * PI * variance_m2)
                    - libm::log(2.0 * PI * self.between_m.max(deviation_m))
                    - (self.count - 1.0) * std::f64::consts::LN_2
            }
        }
    }
}

/// Returns the log-likelihood of a normal cluster of `count` points with this sum of squares about their mean.
fn crowd(count: f64, square_m2: f64, deviation_m: f64) -> f64 {
    let variance_m2 = deviation_m * deviation_m;
    -(count - 1.0) * libm::log(2.0 * PI * variance_m2) - libm::log(count) - 0.5 * square_m2 / variance_m2
}

/// Divides points in two by 2-means clustering (Lloyd's algorithm) until nothing changes; true is the second cluster. The initial centres
/// are the point that is farthest from the first point, and the point that is farthest from that one.
pub(super) fn divided(points: &[Point]) -> Vec<bool> {
    let mut sides = vec![false; points.len()];
    let Some(first) = points.first() else { return sides };
    let far = |from: Point| {
        let farther = |a: &&Point, b: &&Point| from.minus(**a).length().total_cmp(&from.minus(**b).length());
        points.iter().max_by(farther).copied().unwrap_or(from)
    };
    let mut centres = (far(*first), far(far(*first)));
    for _ in 0..CLUSTER_ROUNDS_MAX {
        let side = |point: &Point| point.minus(centres.1).length() < point.minus(centres.0).length();
        let next: Vec<bool> = points.iter().map(side).collect();
        let settled = next == sides;
        sides = next;
        let (Some(a), Some(b)) = (mean_of(points, &sides, false), mean_of(points, &sides, true)) else { break };
        centres = (a, b);
        if settled {
            break;
        }
    }
    sides
}

fn mean_of(points: &[Point], sides: &[bool], side: bool) -> Option<Point> {
    let members = points.iter().zip(sides).filter(|(_, at)| **at == side).map(|(point, _)| *point);
    let (sum, count) = members.fold((Point::default(), 0.0), |(sum, count), point| (sum.plus(1.0, point), count + 1.0));
    (count > 0.0).then(|| Point { x: sum.x / count, y: sum.y / count })
}

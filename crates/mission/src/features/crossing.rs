//! Detects outlines that cross themselves: area, inside and grid of such a shape are undefined.
//!
//! Bound: edges are sorted by longitude and compared with those that overlap in longitude; O(n log n) for outlines of many
//! short edges, O(n^2) at worst.

use apex_model::problem::Position;

/// An edge of a ring as a segment of the plane of degrees.
#[derive(Clone, Copy)]
struct RingEdge {
    /// Number of its first corner.
    number: usize,
    from: (f64, f64),
    to: (f64, f64),
}

impl RingEdge {
    fn west(&self) -> f64 {
        self.from.0.min(self.to.0)
    }

    fn east(&self) -> f64 {
        self.from.0.max(self.to.0)
    }

    /// Returns true if the two cross inside of both: outlines may touch themselves.
    fn crosses(&self, other: &RingEdge) -> bool {
        let side = |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
        let apart = |a: f64, b: f64| (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0);
        apart(side(self.from, self.to, other.from), side(self.from, self.to, other.to))
            && apart(side(other.from, other.to, self.from), side(other.from, other.to, self.to))
    }

    fn overlaps_north_south(&self, other: &RingEdge) -> bool {
        self.from.1.min(self.to.1) <= other.from.1.max(other.to.1)
            && other.from.1.min(other.to.1) <= self.from.1.max(self.to.1)
    }
}

/// Returns the numbers of the corners, from 1, at which two crossing edges of a ring begin; `None` if no edges cross. The ring is given
/// without its closing corner.
pub(super) fn crossing(ring: &[Position]) -> Option<(usize, usize)> {
    let mut edges = edges(ring);
    edges.sort_by(|a, b| a.west().total_cmp(&b.west()).then(a.number.cmp(&b.number)));
    for (index, edge) in edges.iter().enumerate() {
        let near = edges.iter().skip(index + 1).take_while(|other| other.west() <= edge.east());
        for other in near {
            if edge.overlaps_north_south(other) && edge.crosses(other) {
                return Some((edge.number.min(other.number), edge.number.max(other.number)));
            }
        }
    }
    None
}

fn edges(ring: &[Position]) -> Vec<RingEdge> {
    let Some(first) = ring.first() else { return Vec::new() };
    // Longitudes continue beyond 180 degrees, because an outline across the date line does not cross itself.
    let mut before = first.longitude_deg;
    let mut corners: Vec<(f64, f64)> = Vec::with_capacity(ring.len() + 1);
    for corner in ring {
        let turns = ((before - corner.longitude_deg) / 360.0).round();
        before = corner.longitude_deg + 360.0 * turns;
        corners.push((before, corner.latitude_deg));
    }
    let next = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(next).zip(1..).map(|((from, to), number)| RingEdge { number, from: *from, to: *to }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    fn ring(corners: &[(f64, f64)]) -> Vec<Position> {
        corners.iter().map(|(longitude, latitude)| Position::new(*latitude, *longitude)).collect()
    }

    /// Compares every edge with every other edge (naive twin).
    fn naive(ring: &[Position]) -> bool {
        let edges = edges(ring);
        edges.iter().enumerate().any(|(index, edge)| edges.iter().skip(index + 1).any(|other| edge.crosses(other)))
    }

    #[test]
    fn bow_ties_cross_and_outlines_do_not() {
        assert_eq!(crossing(&ring(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])), Some((1, 3)));
        assert_eq!(crossing(&ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])), None);
        assert_eq!(crossing(&ring(&[(179.0, 0.0), (-179.0, 0.0), (-179.0, 1.0), (179.0, 1.0)])), None, "date line");
        let touching = [(0.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 2.0), (0.0, 2.0), (1.0, 1.0)];
        assert_eq!(crossing(&ring(&touching)), None, "an outline may touch itself");
        assert_eq!(crossing(&[]), None);
    }

    #[test]
    fn random_rings_are_judged_as_by_comparing_all_edges() {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        let mut next = || (generator.next_u64() >> 40) as f64 / f64::from(1 << 24);
        let mut crossed = 0;
        for number in 0..3000_u32 {
            let corners = 3 + number as usize % 9;
            // Around a middle with random radii nothing crosses; a random corner may.
            let mut around: Vec<(f64, f64)> = (0..corners)
                .map(|corner| {
                    let angle = corner as f64 / corners as f64 * std::f64::consts::TAU;
                    let radius = 0.2 + next();
                    (radius * libm::cos(angle), radius * libm::sin(angle))
                })
                .collect();
            if number % 2 == 0 {
                let index = (next() * corners as f64) as usize;
                around[index] = (next() * 2.0 - 1.0, next() * 2.0 - 1.0);
            }
            let ring = ring(&around);
            assert_eq!(crossing(&ring).is_some(), naive(&ring), "{around:?}");
            crossed += u32::from(naive(&ring));
        }
        assert!((300..2500).contains(&crossed), "{crossed}");
    }

    #[test]
    fn a_fire_outline_of_fifty_thousand_corners_does_not_cross_itself() {
        let corners: Vec<(f64, f64)> = (0..50_000_u32)
            .map(|corner| {
                let angle = f64::from(corner) / 50_000.0 * std::f64::consts::TAU;
                let radius = 0.3 + 0.05 * libm::sin(angle * 40.0) + 0.002 * libm::sin(angle * 3001.0);
                (radius * libm::cos(angle) - 119.0, radius * libm::sin(angle) + 34.0)
            })
            .collect();
        assert_eq!(crossing(&ring(&corners)), None);
    }
}

//! Parts of a turning path that zones close, and the departures that they close.

use super::air::Air;
use super::course::Block;
use super::spans::Span;

/// A part of a path that a zone closes at some times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShutPart {
    /// Length of the path, turns included, until the vehicle has passed the part.
    through: f64,
    /// Times at which it is closed.
    time_s: Span,
}

impl ShutPart {
    /// Returns the part that a block closes on a chord of the path, from and to these lengths of it.
    pub(super) fn of(block: Block, (from, to): (f64, f64)) -> ShutPart {
        ShutPart { through: from + block.part.1 * (to - from), time_s: block.time_s }
    }

    /// Returns the part as one of a path that begins `before` earlier.
    pub(super) fn after(self, before: f64) -> ShutPart {
        ShutPart { through: before + self.through, ..self }
    }

    /// Returns the departures that parts close, for a path that takes at most `longest_s`, of which turns take `extra_s`. A vehicle that
    /// leaves before a zone closes must have passed the part in time. Its time is twice that against the strongest wind, because the wind
    /// may also change between two pieces of the path.
    pub(super) fn closed_s(parts: Vec<ShutPart>, air: &Air, (longest_s, extra_s): (f64, f64)) -> Vec<Span> {
        let slowest_mps = 2.0 * air.true_airspeed_mps() - air.ground_speed_mps_max();
        let closed_s = |part: ShutPart| {
            let through_s = if slowest_mps > 0.0 { (part.through / slowest_mps).min(longest_s) } else { longest_s };
            let (shut_s, open_s) = part.time_s;
            (shut_s - (2.0 * through_s + extra_s), open_s)
        };
        parts.into_iter().map(closed_s).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Air, Network, PlaneZone, TravelError};
    use crate::plane::Point;

    /// A vehicle inside a zone that shuts later may leave for a distant place: only the part of the way inside the zone counts, not the
    /// whole way.
    #[test]
    fn a_zone_that_shuts_is_left_on_a_long_way_with_turns() {
        let p = |x: f64, y: f64| Point { x, y };
        let corners = vec![p(0.0, -50.0), p(100.0, -50.0), p(100.0, 50.0), p(0.0, 50.0)];
        let zone = PlaneZone { corners, active_s: vec![(1_000.0, 90_000.0)], ..PlaneZone::default() };
        let mut network = Network::on_plane(&[zone], (0.0, 5.0), Air::still(1.0), (0.0, 100_000.0)).unwrap();
        let (from, to) = (network.add_point(p(50.0, 0.0)).unwrap(), network.add_point(p(900.0, 0.0)).unwrap());
        network.head(from, Some(std::f64::consts::PI));
        let mut departs = |ready_s: f64| network.trip(from, to, ready_s).map(|trip| trip.depart_s);
        assert_eq!(departs(700.0), Ok(700.0), "50 m and a turn are left in 70 s");
        assert_eq!(departs(970.0), Err(TravelError::Shut), "inside as it shuts");
    }
}

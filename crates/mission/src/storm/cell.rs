//! One cell: its place, its radius, and its drift as measured.

use apex_geo::geodesy;
use apex_model::problem::Position;
use serde::{Deserialize, Serialize};

/// The drift is measured between sightings that are this long apart, and half as long while the older one is renewed.
const BASELINE_S: f64 = 1_200.0;
/// A radar states bearings to a tenth of a degree: a cell that has moved less far may stand still.
const NOISE_M: f64 = 600.0;
/// A cell is assumed to continue on its course, or to stand, for this long.
pub(crate) const AHEAD_S: f64 = 7_200.0;
/// Two sightings are of one cell if its place differs from the expected one by at most this, and by this for each second between them ..
const SAME_M: f64 = 2_000.0;
const SAME_MPS: f64 = 30.0;
/// .. and its radius by at most this share.
const SAME_RADIUS: f64 = 0.1;

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StormTrack {
    /// Its radius.
    pub(crate) radius_m: f64,
    /// Its middle at the last sighting.
    middle: Position,
    /// Instant of that sighting.
    pub(crate) seen_s: f64,
    /// Sighting from which the drift is measured.
    old: (f64, Position),
    /// The sighting that replaces it.
    recent: (f64, Position),
}

impl StormTrack {
    /// Returns a cell that is seen for the first time.
    pub(crate) fn new(at_s: f64, middle: Position, radius_m: f64) -> StormTrack {
        StormTrack { radius_m, middle, seen_s: at_s, old: (at_s, middle), recent: (at_s, middle) }
    }

    /// Returns true if a sighting may be of this cell.
    pub(crate) fn is_at(&self, at_s: f64, middle: Position, radius_m: f64) -> bool {
        let off_m = SAME_M + SAME_MPS * (at_s - self.seen_s);
        (self.radius_m - radius_m).abs() <= SAME_RADIUS * self.radius_m
            && geodesy::distance_m(self.middle_at(at_s), middle) <= off_m
    }

    /// Takes a sighting.
    pub(crate) fn follow(&mut self, at_s: f64, middle: Position, radius_m: f64) {
        if at_s - self.recent.0 >= 0.5 * BASELINE_S {
            (self.old, self.recent) = (self.recent, (at_s, middle));
        }
        (self.seen_s, self.middle, self.radius_m) = (at_s, middle, radius_m);
    }

    /// Returns the speed and the direction of the drift; speed 0 until it is known.
    fn drift(&self) -> (f64, f64) {
        let (from_s, from) = self.old;
        let (moved_m, azimuth_deg) = geodesy::inverse(from, self.middle);
        let speed_mps = if moved_m < NOISE_M { 0.0 } else { moved_m / (self.seen_s - from_s).max(1.0) };
        (speed_mps, azimuth_deg)
    }

    /// Returns true if the cell has not moved.
    pub(crate) fn stands(&self) -> bool {
        self.drift().0 <= 0.0
    }

    /// Returns the middle at an instant, at most [`AHEAD_S`] after the last sighting.
    pub(crate) fn middle_at(&self, at_s: f64) -> Position {
        let (speed_mps, azimuth_deg) = self.drift();
        let moved_m = speed_mps * (at_s - self.seen_s).clamp(0.0, AHEAD_S);
        if moved_m > 0.0 { geodesy::destination(self.middle, azimuth_deg, moved_m) } else { self.middle }
    }

    /// Returns the distance of a position from the edge at an instant; negative inside.
    pub(crate) fn distance_m(&self, position: Position, at_s: f64) -> f64 {
        geodesy::distance_m(self.middle_at(at_s), position) - self.radius_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Position = Position::new(35.0, -118.0);

    #[test]
    fn a_cell_that_drifts_is_expected_on_its_course() {
        let at = |seconds: f64| geodesy::destination(HERE, 90.0, 5.0 * seconds);
        let mut cell = StormTrack::new(0.0, HERE, 25_000.0);
        for minute in 1..120 {
            let at_s = 60.0 * f64::from(minute);
            assert!(cell.is_at(at_s, at(at_s), 25_000.0));
            cell.follow(at_s, at(at_s), 25_000.0);
        }
        let off_m = geodesy::distance_m(cell.middle_at(10_800.0), at(10_800.0));
        assert!(off_m < 200.0, "{off_m}");
        assert!(!cell.is_at(7_200.0, HERE, 25_000.0) && !cell.is_at(7_200.0, at(7_200.0), 15_000.0));
    }

    #[test]
    fn the_error_of_a_bearing_is_not_a_drift() {
        let mut cell = StormTrack::new(0.0, HERE, 8_000.0);
        (1..60).for_each(|number| {
            let off_m = if number % 2 == 0 { 250.0 } else { -250.0 };
            cell.follow(60.0 * f64::from(number), geodesy::destination(HERE, 0.0, off_m), 8_000.0);
        });
        assert!(cell.stands());
    }
}

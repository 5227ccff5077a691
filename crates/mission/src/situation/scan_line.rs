//! Scanner lines with their seen parts.

use apex_geo::geodesy;
use apex_model::problem::Position;
use serde::{Deserialize, Serialize};

/// Length of the pieces in which a line is judged, m.
const PIECE_M: f64 = 400.0;
/// A sample farther from the line than this does not show the line, m.
const CROSS_TRACK_M_MAX: f64 = 600.0;
/// Maximum number of pieces between two samples that count as seen: samples come once a second.
const PIECES_PER_SAMPLE_MAX: usize = 4;
/// Metres in a degree of latitude.
const METRES_PER_DEGREE: f64 = 111_195.0;

/// One line over a target, cut into pieces that are seen or not, with wings level or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScanLine {
    from: Position,
    /// Unit vector along the line: east, north.
    along: (f64, f64),
    /// Metres per degree of longitude at the line's middle.
    metres_per_longitude: f64,
    /// For each piece, `None`: not seen, false: seen with a wing low, true: seen with wings level.
    pieces: Vec<Option<bool>>,
    /// The last marked piece, so that the pieces between two samples count as seen.
    last: Option<usize>,
}

impl ScanLine {
    /// Returns a line of which nothing has been seen.
    pub fn new(from: Position, to: Position) -> ScanLine {
        let middle_deg = 0.5 * (from.latitude_deg + to.latitude_deg);
        let metres_per_longitude = METRES_PER_DEGREE * libm::cos(middle_deg.to_radians());
        let east_m = (to.longitude_deg - from.longitude_deg) * metres_per_longitude;
        let north_m = (to.latitude_deg - from.latitude_deg) * METRES_PER_DEGREE;
        let norm_m = libm::hypot(east_m, north_m).max(1.0);
        let count = (geodesy::distance_m(from, to) / PIECE_M).ceil().clamp(1.0, 100_000.0);
        let along = (east_m / norm_m, north_m / norm_m);
        ScanLine { from, along, metres_per_longitude, pieces: vec![None; count as usize], last: None }
    }

    /// Marks the position on the present line as seen, or as lost if the wings are not level. A position off the line marks nothing.
    pub fn mark(&mut self, position: Position, level: bool) {
        let east_m = (position.longitude_deg - self.from.longitude_deg) * self.metres_per_longitude;
        let north_m = (position.latitude_deg - self.from.latitude_deg) * METRES_PER_DEGREE;
        let along_m = east_m * self.along.0 + north_m * self.along.1;
        let cross_m = east_m * self.along.1 - north_m * self.along.0;
        if along_m < 0.0 || cross_m.abs() > CROSS_TRACK_M_MAX {
            self.last = None;
            return;
        }
        let index = (along_m / PIECE_M) as usize;
        let near = |last: &usize| *last <= index && index - *last <= PIECES_PER_SAMPLE_MAX;
        let begin = self.last.filter(near).unwrap_or(index);
        for piece in self.pieces.iter_mut().take(index + 1).skip(begin) {
            *piece = Some(level || *piece == Some(true));
        }
        self.last = Some(index);
    }

    /// Returns beginning and end of the line, to the length of a piece.
    pub(crate) fn ends(&self) -> (Position, Position) {
        let length_m = self.pieces.len() as f64 * PIECE_M;
        let to = Position::new(
            self.from.latitude_deg + length_m * self.along.1 / METRES_PER_DEGREE,
            self.from.longitude_deg + length_m * self.along.0 / self.metres_per_longitude,
        );
        (self.from, to)
    }

    /// Returns the numbers of pieces: in all, seen, and seen with wings level.
    pub fn count(&self) -> (usize, usize, usize) {
        let seen = self.pieces.iter().flatten().count();
        let level = self.pieces.iter().flatten().filter(|level| **level).count();
        (self.pieces.len(), seen, level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refly_mends_pieces_that_were_seen_with_a_wing_low() {
        let mut line = ScanLine::new(Position::new(40.0, -120.0), Position::new(40.1, -120.0));
        let at = |along_m: u32| Position::new(40.0 + f64::from(along_m) / METRES_PER_DEGREE, -120.001);
        (0..11_200).step_by(180).for_each(|along| line.mark(at(along), !(3_000..4_000).contains(&along)));
        let (all, seen, level) = line.count();
        assert_eq!(all, seen);
        assert!(level < seen);
        (2_500..4_500).step_by(180).for_each(|along| line.mark(at(along), true));
        assert_eq!(line.count(), (all, all, all));
    }

    #[test]
    fn a_position_next_to_the_line_shows_nothing() {
        let mut line = ScanLine::new(Position::new(40.0, -120.0), Position::new(40.1, -120.0));
        line.mark(Position::new(40.05, -120.1), true);
        assert_eq!(line.count().1, 0);
    }
}

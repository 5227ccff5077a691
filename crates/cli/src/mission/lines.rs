//! A scanner line with what has been seen of it.

use apex_geo::geodesy;
use apex_model::problem::Position;
use apex_model::value::Value;

/// Length of the pieces in which a line is judged, m.
const PIECE_M: f64 = 400.0;

/// One line over a target, cut into pieces that are seen or not, with wings level or not.
#[derive(Debug, Clone)]
pub struct ScanLine {
    /// Where it begins.
    pub from: Position,
    /// Where it ends.
    pub to: Position,
    /// Per piece: none not seen, false seen with a wing low, true seen with wings level.
    pieces: Vec<Option<bool>>,
    /// The last piece marked, so that a gap between two samples counts as seen.
    last: Option<usize>,
}

impl ScanLine {
    /// A line of which nothing has been seen.
    pub fn new(from: Position, to: Position) -> ScanLine {
        let length_m = geodesy::distance_m(from, to);
        let count = (length_m / PIECE_M).ceil().clamp(1.0, 100_000.0);
        ScanLine { from, to, pieces: vec![None; count as usize], last: None }
    }

    /// The line of a goal `(scan TARGET along (FROM TO))`.
    pub fn of_goal(goal: &Value) -> Option<ScanLine> {
        let [Value::Symbol(head), _, _, line] = goal.as_list()? else { return None };
        let ends = head.is("scan").then(|| line.as_list())??;
        let (from, _) = super::bookkeeping::location(ends.first()?)?;
        let (to, _) = super::bookkeeping::location(ends.get(1)?)?;
        Some(ScanLine::new(from, to))
    }

    /// The aircraft is abeam `along_m` from the beginning; are its wings level?
    pub fn mark(&mut self, along_m: f64, level: bool) {
        if along_m < 0.0 {
            self.last = None;
            return;
        }
        let index = (along_m / PIECE_M) as usize;
        // Samples come once a second: the few pieces since the last sample have been seen too.
        let begin = self.last.filter(|last| *last <= index && index - *last <= 4).unwrap_or(index);
        for piece in self.pieces.iter_mut().take(index + 1).skip(begin) {
            *piece = Some(level || *piece == Some(true));
        }
        self.last = Some(index);
    }

    /// Pieces in all, seen, and seen with wings level.
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
        (0..12_000).step_by(180).for_each(|along| line.mark(f64::from(along), !(3_000..4_000).contains(&along)));
        let (all, seen, level) = line.count();
        assert_eq!(all, seen);
        assert!(level < seen);
        (2_500..4_500).step_by(180).for_each(|along| line.mark(f64::from(along), true));
        assert_eq!(line.count(), (all, all, all));
    }
}

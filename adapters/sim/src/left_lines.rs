//! Interrupted lines and the distance flown along each, so that a line commanded again is resumed there.

use crate::flight::{ActiveOrder, Order, Stage};
use crate::path::Line;
use apex_model::problem::Position;

/// Maximum number of remembered lines: more than a plan has interrupted at any time.
const LINES_MAX: usize = 16;
/// A flown part extends the line if it lies within `ASIDE_M` of it and begins at most `GAP_M` after the interruption.
const ASIDE_M: f64 = 120.0;
const GAP_M: f64 = 300.0;

/// Interrupted lines that are not resumed yet.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeftLines(Vec<LeftLine>);

#[derive(Clone, Debug)]
struct LeftLine {
    from: Position,
    to: Position,
    along_m: f64,
}

impl LeftLines {
    /// Stores that the line was flown for `along_m`; drops the oldest entry at the limit.
    pub(crate) fn remember(&mut self, from: Position, to: Position, along_m: f64) {
        self.0.retain(|line| (line.from, line.to) != (from, to));
        self.0.push(LeftLine { from, to, along_m });
        if self.0.len() > LINES_MAX {
            self.0.remove(0);
        }
    }

    /// Returns the distance at which to resume the line, zero if it was not interrupted. Each interruption is used once.
    pub(crate) fn take(&mut self, from: Position, to: Position) -> f64 {
        let found = self.0.iter().position(|line| (line.from, line.to) == (from, to));
        found.map_or(0.0, |index| self.0.remove(index).along_m)
    }

    /// Records that the line between two positions was flown to its end. If it is a part of an interrupted line and ends
    /// after the point of interruption, that line is resumed from its end.
    pub(crate) fn flown(&mut self, from: Position, to: Position) {
        for left in &mut self.0 {
            let line = Line::new(left.from, left.to);
            let (begin_m, begin_aside_m, _) = line.locate(from);
            let (end_m, end_aside_m, _) = line.locate(to);
            let on_it = begin_aside_m.abs() <= ASIDE_M && end_aside_m.abs() <= ASIDE_M;
            if on_it && begin_m <= left.along_m + GAP_M && end_m > left.along_m {
                left.along_m = end_m.min(line.length_m);
            }
        }
    }
}

impl ActiveOrder {
    /// Returns the ends of the commanded line and the distance flown along it; `None` if it was not begun.
    pub(crate) fn unfinished(&self) -> Option<(Position, Position, f64)> {
        let (from, to) = self.ends_of_line()?;
        let line = self.line.as_ref()?;
        // If the vehicle is interrupted on its way back to the line, the line is resumed at the first interruption.
        let along_m = if matches!(self.stage, Stage::OnLine) { line.length_m - self.to_go_m } else { self.begin_m };
        (along_m > 0.0).then(|| (from, to, along_m.min(line.length_m)))
    }

    /// Returns the ends of the commanded line; `None` for other orders.
    pub(crate) fn ends_of_line(&self) -> Option<(Position, Position)> {
        match &self.order {
            Order::FlyLine { from, to } => Some((from.position, to.position)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_flown_past_the_break_moves_it_and_other_lines_do_not() {
        let (from, to) = (Position::new(40.0, -120.0), Position::new(40.0, -119.0));
        let at = |longitude_deg| Position::new(40.0, longitude_deg);
        let line = Line::new(from, to);
        let mut left = LeftLines::default();
        let break_m = line.locate(at(-119.6)).0;
        left.remember(from, to, break_m);
        left.flown(at(-119.5), at(-119.4));
        left.flown(at(-119.5), at(-119.7));
        left.flown(Position::new(40.1, -119.7), Position::new(40.1, -119.5));
        left.flown(at(-119.8), at(-119.65));
        assert_eq!(left.clone().take(from, to), break_m);
        left.flown(at(-119.7), at(-119.5));
        assert_eq!(left.take(from, to), line.locate(at(-119.5)).0);
        assert_eq!(left.take(from, to), 0.0);
    }

    #[test]
    fn the_oldest_line_is_forgotten() {
        let mut left = LeftLines::default();
        let end = |index: u32| Position::new(f64::from(index), 0.0);
        (1..=20).for_each(|index| left.remember(Position::new(0.0, 1.0), end(index), 5.0));
        assert_eq!(
            (left.take(Position::new(0.0, 1.0), end(4)), left.take(Position::new(0.0, 1.0), end(5))),
            (0.0, 5.0)
        );
    }
}

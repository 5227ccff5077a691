//! Measured properties of a link: level by cell, the last place with a good level, and the places of losses.
//!
//! Computed only from `(signal-level MODEM)` and the locations in the record. Bound: O(log cells) per sample; memory is bounded by
//! [`CELLS_MAX`] cells, of which the oldest is dropped, and [`LOSSES_MAX`] losses.

use crate::lost_link::{LostDefault, LostLink};
use apex_geo::geodesy;
use apex_model::planned::Location;
use apex_model::problem::Position;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Maximum number of cells of one link: with cells of 200 m, more than a day of flight of a small aircraft.
const CELLS_MAX: usize = 4_096;
/// Number of oldest cells that one search collects for removal.
const OLDEST_KEPT: usize = 512;
/// Remembered losses: more than any flight has, because repeated losses end a flight.
const LOSSES_MAX: usize = 64;
/// Least length of a cell's side, m (correlation of shadows: tens to hundreds of metres).
const CELL_M_MIN: f64 = 200.0;
/// Flight time across a cell at cruise, s: the vehicle reports its location that often.
const CELL_S: f64 = 10.0;
/// Height of a cell, m.
pub(crate) const BAND_M: f64 = 100.0;
/// Time constant in seconds of the smoothed level that decides whether a link is good: fading is faster.
const SMOOTHING_S: f64 = 4.0;
/// Seconds for which the link must stay good after a place before that place counts as good: this excludes the edge of the signal.
const STAYED_S: f64 = 5.0;
/// Maximum number of places behind the vehicle that are kept for [`STAYED_S`].
const TRAIL_MAX: usize = 32;
const DEGREE_M: f64 = 111_195.0;

/// A cell: steps north and east of the mission's start, and upwards from sea level.
pub(crate) type LinkCell = (i32, i32, i32);

/// Size and origin of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cells {
    pub(crate) origin: Position,
    pub(crate) side_m: f64,
}

impl Cells {
    /// Returns the cells of a mission that starts at `origin`.
    pub(crate) fn new(origin: Position, cruise_mps: f64) -> Cells {
        Cells { origin, side_m: (CELL_S * cruise_mps).max(CELL_M_MIN) }
    }

    fn east_m(&self) -> f64 {
        libm::cos(self.origin.latitude_deg.to_radians()).max(0.01) * DEGREE_M
    }

    /// Steps north and east of the origin, with fractions.
    pub(crate) fn steps(&self, position: Position) -> (f64, f64) {
        let north_m = (position.latitude_deg - self.origin.latitude_deg) * DEGREE_M;
        let east_m = geodesy::wrap_180(position.longitude_deg - self.origin.longitude_deg) * self.east_m();
        (north_m / self.side_m, east_m / self.side_m)
    }

    /// Returns the cell of a place.
    pub(crate) fn of(&self, position: Position, altitude_m: f64) -> LinkCell {
        let (north, east) = self.steps(position);
        let step = |steps: f64| libm::floor(steps) as i32;
        (step(north), step(east), step(altitude_m / BAND_M))
    }

    /// Returns the middle of a cell, with its altitude.
    pub(crate) fn middle(&self, (north, east, band): LinkCell) -> (Position, f64) {
        let (low, high) = (self.corner(north, east), self.corner(north + 1, east + 1));
        let position = Position {
            latitude_deg: 0.5 * (low.latitude_deg + high.latitude_deg),
            longitude_deg: low.longitude_deg + 0.5 * geodesy::wrap_180(high.longitude_deg - low.longitude_deg),
        };
        (position, (f64::from(band) + 0.5) * BAND_M)
    }

    /// Returns the corner `north` and `east` steps from the origin.
    pub(crate) fn corner(&self, north: i32, east: i32) -> Position {
        let latitude_deg = self.origin.latitude_deg + f64::from(north) * self.side_m / DEGREE_M;
        let longitude_deg = self.origin.longitude_deg + f64::from(east) * self.side_m / self.east_m();
        Position { latitude_deg, longitude_deg: geodesy::wrap_180(longitude_deg) }
    }
}

/// Levels measured in a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    /// Sum of the levels.
    sum: f64,
    /// Number of samples.
    count: u32,
    /// The last sample, s of mission time.
    last_s: f64,
}

impl Measured {
    /// Returns the number of samples.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// Returns the mean level.
    pub(crate) fn mean(&self) -> f64 {
        self.sum / f64::from(self.count.max(1))
    }
}

/// A loss of the link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Loss {
    /// Instant, s of mission time.
    pub(crate) at_s: f64,
    /// Position of the vehicle.
    pub(crate) here: Location,
    /// Destination of the vehicle.
    pub(crate) goal: Option<Position>,
    /// The level then.
    pub(crate) level: f64,
}

/// Memory of one link.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Learned {
    cells: BTreeMap<LinkCell, Measured>,
    pub(crate) losses: Vec<Loss>,
    /// Number of losses, including those that were dropped from `losses`.
    pub(crate) losses_count: u32,
    /// The smoothed level and its instant.
    smoothed: Option<(f64, f64)>,
    level: f64,
    good_since_s: Option<f64>,
    trail: Vec<(f64, Location)>,
    /// Last place with a good link.
    pub(crate) good_place: Option<Location>,
    #[serde(skip)]
    oldest: Oldest,
}

/// The cells visited longest ago, the oldest last, as of the last refill: a cache, and not part of the state.
#[derive(Clone, Debug, Default)]
struct Oldest(Vec<(f64, LinkCell)>);

impl PartialEq for Oldest {
    fn eq(&self, _: &Oldest) -> bool {
        true
    }
}

impl Oldest {
    /// Returns the cell visited longest ago. Bound: O(1), and O(cells log cells) after [`OLDEST_KEPT`] of them.
    fn take(&mut self, cells: &BTreeMap<LinkCell, Measured>) -> Option<LinkCell> {
        loop {
            while let Some((last_s, cell)) = self.0.pop() {
                if cells.get(&cell).is_some_and(|measured| measured.last_s == last_s) {
                    return Some(cell);
                }
            }
            if cells.is_empty() {
                return None;
            }
            self.0 = cells.iter().map(|(cell, measured)| (measured.last_s, *cell)).collect();
            self.0.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            self.0.truncate(OLDEST_KEPT);
            self.0.reverse();
        }
    }
}

impl Learned {
    /// Takes a sample of the level at a place.
    pub(crate) fn measure(&mut self, lost: &LostLink, cells: &Cells, (at_s, here): (f64, Location), level: f64) {
        self.level = level;
        let smoothed = match self.smoothed {
            Some((before_s, before)) => before + (level - before) * (1.0 - libm::exp((before_s - at_s) / SMOOTHING_S)),
            None => level,
        };
        self.smoothed = Some((at_s, smoothed));
        self.remember(cells.of(here.position, here.altitude_m), at_s, level);
        if smoothed < lost.known_good() {
            self.good_since_s = None;
            self.trail.clear();
            return;
        }
        let since_s = *self.good_since_s.get_or_insert(at_s);
        if at_s - since_s >= lost.good_for_s {
            self.trail.push((at_s, here));
        }
        let settled = self.trail.iter().rposition(|(then_s, _)| at_s - then_s >= STAYED_S);
        if let Some((_, place)) = settled.and_then(|index| self.trail.get(index)) {
            self.good_place = Some(*place);
        }
        self.trail.drain(..settled.unwrap_or(0));
        let surplus = self.trail.len().saturating_sub(TRAIL_MAX);
        self.trail.drain(..surplus);
    }

    fn remember(&mut self, cell: LinkCell, at_s: f64, level: f64) {
        if self.cells.len() >= CELLS_MAX && !self.cells.contains_key(&cell) {
            let oldest = self.oldest.take(&self.cells);
            oldest.and_then(|oldest| self.cells.remove(&oldest));
        }
        let measured = self.cells.entry(cell).or_default();
        measured.sum += level;
        measured.count = measured.count.saturating_add(1);
        measured.last_s = at_s;
    }

    /// Records that the link was lost here, on the way to `goal`.
    pub(crate) fn lose(&mut self, at_s: f64, here: Location, goal: Option<Position>) {
        self.losses.push(Loss { at_s, here, goal, level: self.level });
        let surplus = self.losses.len().saturating_sub(LOSSES_MAX);
        self.losses.drain(..surplus);
        self.losses_count = self.losses_count.saturating_add(1);
    }

    /// Counts a loss of a link whose level does not depend on the place.
    pub(crate) fn lose_everywhere(&mut self) {
        self.losses_count = self.losses_count.saturating_add(1);
    }

    /// Returns the response to the last loss if no instruction arrives: the contingency route if an earlier loss had the same goal or the
    /// greatest number of losses is reached, otherwise the response that the mission states.
    pub(crate) fn default_of(&self, lost: &LostLink, cells: &Cells) -> LostDefault {
        let is_again = self.losses.split_last().is_some_and(|(last, before)| {
            let near = |goal: Position| {
                let is_near = |other: Position| geodesy::distance_m(goal, other) < cells.side_m;
                before.iter().filter_map(|loss| loss.goal).any(is_near)
            };
            last.goal.is_some_and(near)
        });
        if is_again || self.losses_count >= lost.losses_max { LostDefault::GoHome } else { lost.default }
    }

    /// Cells with their levels.
    pub(crate) fn cells(&self) -> &BTreeMap<LinkCell, Measured> {
        &self.cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(metres: f64) -> Location {
        Location { position: geodesy::destination(Position::new(37.0, -121.0), 90.0, metres), altitude_m: 60.0 }
    }

    fn cells() -> Cells {
        Cells::new(Position::new(37.0, -121.0), 10.0)
    }

    #[test]
    fn the_good_place_lies_before_the_edge_of_the_signal() {
        let (mut learned, lost) = (Learned::default(), LostLink::default());
        for second in 0..60 {
            // 10 m/s eastwards; the signal ends at 400 m.
            let level = if second < 40 { 0.6 } else { 0.05 };
            let at_s = f64::from(second);
            learned.measure(&lost, &cells(), (at_s, place(10.0 * at_s)), level);
        }
        let good = learned.good_place.map(|good| geodesy::distance_m(place(0.0).position, good.position));
        // The place is at least 5 s before the edge; smoothing delays the detection by some seconds.
        assert!(good.is_some_and(|metres| (330.0..=390.0).contains(&metres)), "{good:?}");
    }

    #[test]
    fn a_signal_that_is_never_good_for_long_has_no_place() {
        let (mut learned, lost) = (Learned::default(), LostLink::default());
        for second in 0..120 {
            let at_s = f64::from(second);
            let level = if second % 20 < 8 { 0.8 } else { 0.0 };
            learned.measure(&lost, &cells(), (at_s, place(10.0 * at_s)), level);
        }
        assert_eq!(learned.good_place, None);
    }

    #[test]
    fn the_same_goal_is_not_tried_twice_and_losses_are_counted() {
        let (mut learned, lost) = (Learned::default(), LostLink::default());
        learned.lose(100.0, place(900.0), Some(place(2_000.0).position));
        assert_eq!(learned.default_of(&lost, &cells()), LostDefault::Resume);
        learned.lose(200.0, place(900.0), Some(place(9_000.0).position));
        assert_eq!(learned.default_of(&lost, &cells()), LostDefault::Resume);
        learned.lose(300.0, place(900.0), Some(place(2_050.0).position));
        assert_eq!(learned.default_of(&lost, &cells()), LostDefault::GoHome);
        for goal in [20e3, 30e3] {
            learned.lose(400.0, place(900.0), Some(place(goal).position));
        }
        assert_eq!((learned.default_of(&lost, &cells()), learned.losses_count), (LostDefault::GoHome, 5));
    }

    #[test]
    fn memory_is_bounded_and_drops_the_oldest() {
        let mut learned = Learned::default();
        for step in 0..=i32::try_from(CELLS_MAX).unwrap_or(0) {
            learned.remember((step, 0, 0), f64::from(step), 0.5);
        }
        assert_eq!((learned.cells.len(), learned.cells.contains_key(&(0, 0, 0))), (CELLS_MAX, false));
    }
}

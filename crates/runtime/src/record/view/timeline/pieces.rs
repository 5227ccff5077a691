//! The intervals of a task in a window: one by one where they may be bars, as sums for each pixel where all are shorter than a pixel.
//!
//! Bound: one step for each pixel and each block of changes; one step for each interval near one that is as long as a pixel, and for each
//! interval of a task with few changes for each pixel.

use super::super::index::{BLOCK_CHANGES, IndexedTask, Interval};
use super::window::Window;
use apex_model::task::TaskState;
use std::ops::RangeInclusive;

/// Number of changes for each pixel up to which intervals are taken one by one: that takes less time than the look-up of a pixel's sum.
const FEW_CHANGES: usize = 4;

/// The intervals of a task in a window.
#[derive(Default)]
pub(super) struct Pieces {
    /// Intervals one by one, in the order of time.
    pub(super) single: Vec<Interval>,
    /// Sums over the other intervals, all of which are shorter than a pixel, in the order of time.
    pub(super) sums: Vec<PixelSum>,
}

/// Short intervals that begin in a pixel, and the end of one that began in the pixel before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelSum {
    pub(super) pixel: usize,
    /// Number of intervals that begin in the pixel.
    pub(super) count: usize,
    /// Nanoseconds of ongoing work within the pixel.
    pub(super) ongoing_ns: i64,
}

impl Pieces {
    /// Returns every interval of the task one by one.
    pub(super) fn expanded(task: &IndexedTask, window: Window) -> Pieces {
        Pieces { single: task.drawn(window.from_ns, window.known_ns()).collect(), sums: Vec::new() }
    }

    /// Returns the intervals of a task.
    pub(super) fn of(task: &IndexedTask, window: Window) -> Pieces {
        let changed_ns = task.changed_ns();
        let known_ns = window.known_ns();
        // Intervals that begin in the window and end in it: the others are cut.
        let begin = changed_ns.partition_point(|at_ns| *at_ns < window.from_ns);
        let inside = changed_ns.partition_point(|at_ns| *at_ns <= known_ns).saturating_sub(1);
        if inside < begin + (FEW_CHANGES * window.pixels).max(2 * BLOCK_CHANGES) {
            return Pieces::expanded(task, window);
        }
        let mut pieces = Pieces::default();
        let single = |place: usize| {
            let change = task.change_at(place)?;
            let end_ns = changed_ns.get(place + 1).map_or(known_ns, |next_ns| known_ns.min(*next_ns));
            let interval = Interval { state: change.state, from_ns: change.at_ns.max(window.from_ns), to_ns: end_ns };
            let is_inside = change.state.is_alive() && interval.from_ns <= interval.to_ns;
            (is_inside && interval.is_drawn()).then_some(interval)
        };
        pieces.single.extend(begin.checked_sub(1).and_then(single));
        let mut place = begin;
        while place < inside {
            let is_short = |place: usize| task.longest_ns(place) < window.pixel_ns;
            let short = is_short(place);
            let mut end = place;
            while end < inside && is_short(end) == short {
                end = (end - end % BLOCK_CHANGES + BLOCK_CHANGES).min(inside);
            }
            if short {
                pieces.add_short(task, (place, end), window);
            } else {
                pieces.single.extend((place..end).filter_map(single));
            }
            place = end;
        }
        pieces.single.extend(single(inside));
        pieces
    }

    /// Adds the intervals that begin with the changes in `begin..end`; all end within the window.
    fn add_short(&mut self, task: &IndexedTask, (begin, end): (usize, usize), window: Window) {
        let at_ns = |place: usize| task.changed_ns().get(place).copied().unwrap_or(i64::MAX);
        let pixels = window.pixel(at_ns(begin))..=window.pixel(at_ns(end - 1));
        self.sums.reserve(pixels.end() - pixels.start() + 2);
        let mut place = begin;
        for (pixel, next) in pixels.clone().zip(ends_of(task, (begin, end), pixels, window)) {
            if next == place {
                continue;
            }
            let edge_ns = window.end_ns(pixel);
            let (before, after) = (task.sums_before(place), task.sums_before(next));
            let (count, ongoing_ns) = (after.drawn - before.drawn, after.ongoing_ns - before.ongoing_ns);
            // The last of them may end in the next pixel.
            let beyond_ns = at_ns(next).saturating_sub(edge_ns).max(0);
            let last = task.state_from(next - 1).filter(|last| beyond_ns > 0 && last.is_alive());
            let carried_ns = last.map_or(0, |last| if last.0 == TaskState::Ongoing { beyond_ns } else { 0 });
            if count > 0 {
                self.add_sum(PixelSum { pixel, count: count as usize, ongoing_ns: ongoing_ns - carried_ns });
            }
            if last.is_some() {
                self.add_sum(PixelSum { pixel: pixel + 1, count: 0, ongoing_ns: carried_ns });
            }
            place = next;
        }
    }

    /// Adds sums of a pixel, which is the last one that has any, or later.
    fn add_sum(&mut self, sum: PixelSum) {
        match self.sums.last_mut().filter(|last| last.pixel == sum.pixel) {
            Some(last) => {
                last.count += sum.count;
                last.ongoing_ns += sum.ongoing_ns;
            }
            None => self.sums.push(sum),
        }
    }
}

/// Returns for each pixel the first place in `begin..end` whose change is not before the end of the pixel; `end` if there is none.
///
/// The look-ups in the blocks do not depend on one another, so that the processor waits for their memory at the same time.
fn ends_of(
    task: &IndexedTask,
    (begin, end): (usize, usize),
    pixels: RangeInclusive<usize>,
    window: Window,
) -> Vec<usize> {
    let mut block = begin / BLOCK_CHANGES;
    let (blocks, changed_ns) = (task.block_ns(), task.changed_ns());
    let ends = pixels.map(|pixel| {
        let edge_ns = window.end_ns(pixel);
        while blocks.get(block + 1).is_some_and(|first_ns| *first_ns < edge_ns) {
            block += 1;
        }
        let first = block * BLOCK_CHANGES;
        let inside = changed_ns.get(first..(first + BLOCK_CHANGES).min(changed_ns.len())).unwrap_or_default();
        let before = inside.iter().filter(|at_ns| **at_ns < edge_ns).count();
        (first + before).clamp(begin, end)
    });
    ends.collect()
}

//! Shapes of a lane of the timeline: bars and bands.

use super::super::state::StateWord;
use serde::{Serialize, Serializer};

/// The tasks of one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Lane {
    /// The step's tag.
    pub tag: String,
    /// The goal of the first task in the window, as known at the instant asked for.
    pub goal: String,
    /// Nesting in the tree of all lanes; a root has 0.
    pub depth: usize,
    /// Number of tasks in the window.
    pub tasks: usize,
    /// Nanoseconds of the window in which its tasks were enabled, ongoing or interrupted.
    pub active_ns: i64,
    /// Bars that do not overlap, row by row.
    pub rows: Vec<Vec<Bar>>,
    /// Intervals that are too dense for bars, by time.
    pub bands: Vec<Band>,
}

/// A stretch of time that a task spent in one state.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Bar {
    /// The task's number.
    pub task: u64,
    /// Its state.
    pub state: StateWord,
    /// Start, nanoseconds of mission time.
    pub from_ns: i64,
    /// End, nanoseconds of mission time.
    pub to_ns: i64,
}

/// A stretch of pixels that look the same, with more intervals than can be drawn. As JSON: the list of its first pixel, its number of
/// pixels, its count, and its ongoing share in thousandths.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(test, derive(ts_rs::TS), ts(type = "[number, number, number, number]"))]
pub struct Band {
    /// Start, nanoseconds of mission time.
    pub from_ns: i64,
    /// End, nanoseconds of mission time.
    pub to_ns: i64,
    /// Its first pixel, from 0.
    pub pixel: usize,
    /// Its width in pixels.
    pub pixels: usize,
    /// Number of intervals that begin here; 0 where intervals that began earlier continue.
    pub count: usize,
    /// Share of the time in which a task was ongoing, 0 to 1; 1 also where several were at once.
    pub ongoing: f64,
}

impl Serialize for Band {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        (self.pixel, self.pixels, self.count, (self.ongoing * 1e3).round() as u32).serialize(out)
    }
}

//! Shapes of a lane of the timeline: bars and bands.

use super::super::state::StateWord;
use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

/// The tasks of one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Lane {
    /// The step's tag.
    pub tag: String,
    /// The goal of the first task in the window, as known at the requested instant.
    pub goal: String,
    /// Nesting in the tree of all lanes; a root has 0.
    pub depth: usize,
    /// Number of tasks in the window.
    pub tasks: usize,
    /// Nanoseconds of the window in which its tasks were enabled, ongoing or interrupted.
    pub active_ns: i64,
    /// Bars that do not overlap, row by row and by time. In JSON each row is a list of runs, which are bars of one task without a gap
    /// between them: `[task, from_ns, state, length, state, length, ..]`, lengths in nanoseconds. States are numbers: 0 pending,
    /// 1 enabled, 2 ongoing, 3 interrupted.
    #[serde(serialize_with = "as_runs")]
    #[cfg_attr(test, ts(type = "number[][][]"))]
    pub rows: Vec<Vec<Bar>>,
    /// Intervals that are too dense for bars, by time.
    pub bands: Vec<Band>,
}

/// A span of time that a task spent in one state.
#[derive(Clone, Debug, PartialEq)]
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

/// A row in its short form: a drawing may have tens of thousands of bars, whose times would be written twice with names.
struct PackedRow<'a>(&'a [Bar]);

/// Bars of one task without a gap between them.
struct PackedRun<'a>(&'a [Bar]);

fn as_runs<S: Serializer>(rows: &[Vec<Bar>], out: S) -> Result<S::Ok, S::Error> {
    out.collect_seq(rows.iter().map(|row| PackedRow(row)))
}

impl Serialize for PackedRow<'_> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let follows = |bar: &Bar, next: &Bar| bar.task == next.task && bar.to_ns == next.from_ns;
        out.collect_seq(self.0.chunk_by(follows).map(PackedRun))
    }
}

impl Serialize for PackedRun<'_> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let Some(first) = self.0.first() else { return out.collect_seq([0; 0]) };
        let mut run = out.serialize_seq(Some(2 + 2 * self.0.len()))?;
        run.serialize_element(&first.task)?;
        run.serialize_element(&first.from_ns)?;
        for bar in self.0 {
            run.serialize_element(&bar.state.number())?;
            run.serialize_element(&(bar.to_ns - bar.from_ns))?;
        }
        run.end()
    }
}

/// A span of time, about a pixel wide, with more intervals than can be drawn. Its JSON is the list of its first pixel, its number of
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

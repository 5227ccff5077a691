//! The timeline: lanes of task states over a window of time, as drawn with a number of pixels.
//!
//! A lane holds the tasks that one step of one procedure made (same parent lane, same tag), so that a step that
//! repeats for hours stays one lane. Tasks of a lane that overlap lie in rows below each other. Stretches too dense for
//! bars are bands (`bands.rs`). Every interval is in exactly one bar or counted in exactly one band: decision 0089.

mod bands;
mod lanes;
#[cfg(test)]
mod tests;

use super::RecordView;
use super::index::TaskIndex;
use super::state::StateWord;
use crate::error::RecordError;
use bands::Bands;
use lanes::{Group, gather, in_tree_order, lane};
use serde::Serialize;

/// Maximum number of lanes of an answer, unless the query states one.
const LANES_DEFAULT: usize = 40;
/// Maximum number of lanes of any answer.
const LANES_MAX: usize = 400;
/// Width of the drawing in pixels, unless the query states one.
const PIXELS_DEFAULT: usize = 1_000;
/// Largest width of a drawing in pixels.
const PIXELS_MAX: usize = 8_000;

/// A query of the timeline.
#[derive(Clone, Debug, Default)]
pub struct TimelineQuery {
    /// Start of the window in nanoseconds of mission time; default: the record's start.
    pub from_ns: Option<i64>,
    /// End of the window in nanoseconds of mission time; default: the record's end.
    pub to_ns: Option<i64>,
    /// Mission time in nanoseconds up to which the flight is known; default: the record's end.
    pub at_ns: Option<i64>,
    /// Maximum number of lanes; default 40, at most 400.
    pub lanes: Option<usize>,
    /// Width of the drawing in pixels; default 1,000, at most 8,000.
    pub pixels: Option<usize>,
    /// A task whose lane and the lanes above it are shown in any case.
    pub with: Option<u64>,
}

/// Lanes of task states over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Timeline {
    /// Start of the window, nanoseconds of mission time.
    pub from_ns: i64,
    /// End of the window, nanoseconds of mission time.
    pub to_ns: i64,
    /// Mission time in nanoseconds up to which the flight is known.
    pub at_ns: i64,
    /// In the order of the task tree: a lane comes before the lanes below it.
    pub lanes: Vec<Lane>,
    /// The lanes that the limit leaves out; their tasks were active for less time.
    pub more: More,
}

/// Lanes that have no place of their own, drawn as one.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct More {
    /// Number of lanes.
    pub lanes: usize,
    /// Number of their tasks.
    pub tasks: usize,
    /// Their intervals.
    pub bands: Vec<Band>,
}

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

/// A stretch of time, about a pixel wide, with more intervals than can be drawn.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Band {
    /// Start, nanoseconds of mission time.
    pub from_ns: i64,
    /// End, nanoseconds of mission time.
    pub to_ns: i64,
    /// Number of intervals that begin here; 0 where intervals that began earlier continue.
    pub count: usize,
    /// Share of the time in which a task was ongoing, 0 to 1; 1 also where several were at once.
    pub ongoing: f64,
}

impl RecordView {
    /// The timeline. If the limit applies, the lanes that were active longest are kept.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn timeline(&mut self, query: &TimelineQuery) -> Result<Timeline, RecordError> {
        let end_ns = self.growth()?.end_ns;
        let from_ns = query.from_ns.map_or_else(|| self.first_ns(), Ok)?;
        let window = Window {
            from_ns,
            to_ns: query.to_ns.unwrap_or(end_ns).max(from_ns),
            at_ns: query.at_ns.unwrap_or(end_ns),
            pixels: query.pixels.unwrap_or(PIXELS_DEFAULT).clamp(1, PIXELS_MAX),
        };
        let limit = query.lanes.unwrap_or(LANES_DEFAULT).clamp(1, LANES_MAX);
        Ok(draw(self.tasks_index()?, window, limit, query.with))
    }
}

/// A window of time on a number of pixels.
#[derive(Clone, Copy, Debug)]
struct Window {
    from_ns: i64,
    to_ns: i64,
    /// Nothing later is known.
    at_ns: i64,
    pixels: usize,
}

impl Window {
    /// The end of what is known of the window.
    fn known_ns(self) -> i64 {
        self.to_ns.min(self.at_ns)
    }

    /// Nanoseconds of a pixel, at least 1.
    fn pixel_ns(self) -> i64 {
        let pixels = i64::try_from(self.pixels).unwrap_or(i64::MAX);
        self.to_ns.saturating_sub(self.from_ns).saturating_add(pixels - 1).checked_div(pixels).unwrap_or(1).max(1)
    }

    /// The pixel of an instant in the window.
    fn pixel(self, at_ns: i64) -> usize {
        let pixel = at_ns.saturating_sub(self.from_ns).checked_div(self.pixel_ns()).unwrap_or(0);
        usize::try_from(pixel).unwrap_or(0).min(self.pixels - 1)
    }

    /// Start of a pixel, nanoseconds of mission time.
    fn start_ns(self, pixel: usize) -> i64 {
        let pixel = i64::try_from(pixel).unwrap_or(i64::MAX);
        self.from_ns.saturating_add(self.pixel_ns().saturating_mul(pixel))
    }
}

fn draw(index: &TaskIndex, window: Window, limit: usize, with: Option<u64>) -> Timeline {
    let gathered = gather(index, window);
    let chosen = with.map(|task| gathered.lanes_above(task)).unwrap_or_default();
    let groups = &gathered.groups;
    let mut ranked: Vec<usize> =
        (0..groups.len()).filter(|&at| groups.get(at).is_some_and(|group| !group.tasks.is_empty())).collect();
    ranked.sort_by_key(|&at| (!chosen.contains(&at), groups.get(at).map_or(0, |group| -group.active_ns), at));
    let rest = ranked.split_off(limit.min(ranked.len()));
    ranked.sort_unstable();
    let lanes = in_tree_order(groups, &gathered.roots)
        .into_iter()
        .filter(|at| ranked.binary_search(at).is_ok())
        .filter_map(|at| groups.get(at).and_then(|group| lane(index, group, window)))
        .collect();
    let rest = rest.into_iter().filter_map(|at| groups.get(at));
    Timeline {
        from_ns: window.from_ns,
        to_ns: window.to_ns,
        at_ns: window.at_ns,
        lanes,
        more: merge(index, rest, window),
    }
}

/// The lanes without a place of their own as one band.
fn merge<'a>(index: &TaskIndex, groups: impl Iterator<Item = &'a Group>, window: Window) -> More {
    let mut bands = Bands::new(window);
    let mut more = More::default();
    for group in groups {
        more.lanes += 1;
        more.tasks += group.tasks.len();
        for task in group.tasks.iter().filter_map(|&id| index.get(id)) {
            task.drawn(window.from_ns, window.known_ns()).for_each(|interval| bands.add(interval));
        }
    }
    more.bands = bands.finish();
    more
}

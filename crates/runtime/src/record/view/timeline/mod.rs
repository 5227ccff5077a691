//! The timeline: lanes of task states over a window of time, for a drawing with a given number of pixels.
//!
//! A lane contains the tasks that one step of one procedure made (same parent lane, same tag), so that a step that repeats for hours
//! remains one lane. Overlapping tasks of a lane are in rows below each other. Spans too dense for bars are bands (`bands.rs`). Every
//! interval is exactly one bar or counted in exactly one band: decision 0089.

mod bands;
mod lanes;
mod pieces;
mod shapes;
#[cfg(test)]
mod tests;
mod window;

use super::RecordView;
use super::index::TaskIndex;
use crate::error::RecordError;
use bands::Bands;
use lanes::{LaneTasks, gather, in_tree_order, lane};
use pieces::Pieces;
use serde::Serialize;
pub use shapes::{Band, Bar, Lane};
use window::Window;

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
    /// A task whose lane, with the lanes above it, is always shown.
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
    /// Nanoseconds of a pixel, in which bands are measured.
    pub pixel_ns: i64,
    /// In the order of the task tree: a lane comes before the lanes below it.
    pub lanes: Vec<Lane>,
    /// The lanes that the limit leaves out; their tasks were active for less time.
    pub more: More,
}

/// The lanes beyond the limit, combined.
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

impl RecordView {
    /// Returns the timeline. If the limit applies, the lanes that were active longest are kept.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn timeline(&mut self, query: &TimelineQuery) -> Result<Timeline, RecordError> {
        let end_ns = self.growth()?.end_ns;
        let from_ns = query.from_ns.map_or_else(|| self.first_ns(), Ok)?;
        let to_ns = query.to_ns.unwrap_or(end_ns).max(from_ns);
        let pixels = query.pixels.unwrap_or(PIXELS_DEFAULT).clamp(1, PIXELS_MAX);
        let window = Window::new((from_ns, to_ns), query.at_ns.unwrap_or(end_ns), pixels);
        let limit = query.lanes.unwrap_or(LANES_DEFAULT).clamp(1, LANES_MAX);
        Ok(draw(&*self.tasks_index()?, window, limit, query.with))
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
        pixel_ns: window.pixel_ns,
        lanes,
        more: merge(index, rest, window),
    }
}

/// Returns the lanes beyond the limit as one band.
fn merge<'a>(index: &TaskIndex, groups: impl Iterator<Item = &'a LaneTasks>, window: Window) -> More {
    let mut bands = Bands::new(window);
    let mut more = More::default();
    for group in groups {
        more.lanes += 1;
        more.tasks += group.tasks.len();
        for task in group.tasks.iter().filter_map(|&id| index.get(id)) {
            bands.add_all(Pieces::of(task, window));
        }
    }
    more.bands = bands.finish();
    more
}

//! Lanes: assigns tasks to lanes, and divides each lane into bars and bands.

use super::super::index::{Interval, TaskIndex};
use super::bands::Bands;
use super::pieces::Pieces;
use super::shapes::{Bar, Lane};
use super::window::Window;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of rows of a lane: more tasks at once than this cannot be distinguished in a picture.
pub(super) const ROWS_MAX: usize = 8;
/// Number of intervals shorter than a pixel, within one pixel, from which on they form a band.
pub(super) const DENSE_MIN: usize = 3;

/// The tasks of one lane while lanes are collected.
pub(super) struct LaneTasks {
    parent: Option<usize>,
    depth: usize,
    children: Vec<usize>,
    /// Tasks with an interval in the window.
    pub(super) tasks: Vec<u64>,
    pub(super) active_ns: i64,
}

/// All lanes of a window.
pub(super) struct Gathered {
    pub(super) groups: Vec<LaneTasks>,
    pub(super) roots: Vec<usize>,
    lane_of_task: BTreeMap<u64, usize>,
}

impl Gathered {
    /// Returns the lane of a task and the lanes above it.
    pub(super) fn lanes_above(&self, task: u64) -> BTreeSet<usize> {
        let mut next = self.lane_of_task.get(&task).copied();
        let mut lanes = BTreeSet::new();
        while let Some(at) = next.filter(|&at| lanes.insert(at)) {
            next = self.groups.get(at).and_then(|group| group.parent);
        }
        lanes
    }
}

/// Groups the tasks that exist by then into lanes; tasks outside the window shape the tree but do not show.
pub(super) fn gather(index: &TaskIndex, window: Window) -> Gathered {
    let mut groups: Vec<LaneTasks> = Vec::new();
    let mut roots = Vec::new();
    let mut lane_of_task: BTreeMap<u64, usize> = BTreeMap::new();
    let mut lane_of_key: BTreeMap<(Option<usize>, &str), usize> = BTreeMap::new();
    for (&id, task) in index.tasks().iter().filter(|(_, task)| task.created_ns <= window.at_ns) {
        let parent = task.parent.and_then(|parent| lane_of_task.get(&parent).copied());
        let at = *lane_of_key.entry((parent, task.tag.as_str())).or_insert(groups.len());
        if at == groups.len() {
            let above = parent.and_then(|parent| groups.get_mut(parent));
            let depth = above.as_ref().map_or(0, |above| above.depth + 1);
            above.map_or(&mut roots, |above| &mut above.children).push(at);
            groups.push(LaneTasks { parent, depth, children: Vec::new(), tasks: Vec::new(), active_ns: 0 });
        }
        lane_of_task.insert(id, at);
        let Some(group) = groups.get_mut(at) else { continue };
        if task.drawn(window.from_ns, window.known_ns()).next().is_some() {
            group.tasks.push(id);
            group.active_ns += task.active_ns(window.from_ns, window.known_ns());
        }
    }
    Gathered { groups, roots, lane_of_task }
}

pub(super) fn in_tree_order(groups: &[LaneTasks], roots: &[usize]) -> Vec<usize> {
    let mut order = Vec::with_capacity(groups.len());
    let mut open: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(at) = open.pop() {
        order.push(at);
        open.extend(groups.get(at).into_iter().flat_map(|group| group.children.iter().rev()));
    }
    order
}

/// Returns one lane: intervals of at least a pixel, and shorter ones that are not dense, are bars; the others form bands.
pub(super) fn lane(index: &TaskIndex, group: &LaneTasks, window: Window) -> Option<Lane> {
    let first = index.get(*group.tasks.first()?)?;
    let mut drawn: Vec<(u64, Pieces)> =
        group.tasks.iter().filter_map(|&id| Some((id, Pieces::of(index.get(id)?, window)))).collect();
    let dense = dense_pixels(&drawn, window);
    let is_dense = |pixel: usize| dense.get(pixel) == Some(&true);
    let mut rows: Vec<(i64, Vec<Bar>)> = Vec::new();
    let mut bands = Bands::new(window);
    for (id, pieces) in &mut drawn {
        // Short intervals are bars where there are few of them.
        if pieces.sums.iter().any(|sum| sum.count > 0 && !is_dense(sum.pixel)) {
            *pieces = Pieces::expanded(index.get(*id)?, window);
        }
        let is_band = |interval: &Interval| is_small(*interval, window) && is_dense(window.pixel(interval.from_ns));
        let pieces = std::mem::take(pieces);
        let Some((start, end)) = index.get(*id)?.drawn_span(window.from_ns, window.known_ns()) else { continue };
        if pieces.single.iter().all(is_band) {
            bands.add_all(pieces);
            continue;
        }
        let free = rows.iter().position(|(busy_until, _)| *busy_until <= start);
        if free.is_none() && rows.len() == ROWS_MAX {
            bands.add_all(pieces);
            continue;
        }
        let at = free.unwrap_or_else(|| {
            rows.push((end, Vec::new()));
            rows.len() - 1
        });
        let Some((busy_until, row)) = rows.get_mut(at) else { continue };
        *busy_until = end;
        pieces.sums.into_iter().for_each(|sum| bands.add_sum(sum));
        for interval in pieces.single {
            if is_band(&interval) {
                bands.add(interval);
            } else {
                let Interval { state, from_ns, to_ns } = interval;
                row.push(Bar { task: *id, state, from_ns, to_ns });
            }
        }
    }
    Some(Lane {
        tag: first.tag.clone(),
        goal: first.goal_at(window.at_ns).to_owned(),
        depth: group.depth,
        tasks: group.tasks.len(),
        active_ns: group.active_ns,
        rows: rows.into_iter().map(|(_, row)| row).collect(),
        bands: bands.finish(),
    })
}

fn is_small(interval: Interval, window: Window) -> bool {
    interval.length_ns() < window.pixel_ns
}

/// Returns for each pixel true if it has too many small intervals for bars.
fn dense_pixels(drawn: &[(u64, Pieces)], window: Window) -> Vec<bool> {
    let mut counts = vec![0; window.pixels];
    for (_, pieces) in drawn {
        let small = pieces.single.iter().filter(|interval| is_small(**interval, window));
        let single = small.map(|interval| (window.pixel(interval.from_ns), 1));
        for (pixel, count) in single.chain(pieces.sums.iter().map(|sum| (sum.pixel, sum.count))) {
            if let Some(sum) = counts.get_mut(pixel) {
                *sum += count;
            }
        }
    }
    counts.into_iter().map(|count: usize| count >= DENSE_MIN).collect()
}

//! Growth of a target: the ground between two outlines as a separate target.

use crate::footprint::Ground;
use crate::grid::{GridSettings, TargetGrid};
use crate::target::{ObservedTarget, TargetArea, WantedLook};
use apex_geo::geodesy::Position;
use apex_geo::plane::{Plane, Point, inside};

/// Returns the target `name`, of which the ground of `area` outside of the outline `before` is wanted, with its grid. Its looks are those
/// of `target` with `share` of their values and without a cost of missing them. `None` if that ground cannot be divided into cells, or
/// if it is empty.
pub fn grown(
    target: &ObservedTarget,
    name: &str,
    (before, area): (&[Position], TargetArea),
    share: f64,
    (settings, ground): (GridSettings, &dyn Ground),
) -> Option<(ObservedTarget, TargetGrid)> {
    let looks = target.looks.iter().map(|look| WantedLook { value: share * look.value, must: None, ..look.clone() });
    let grown = ObservedTarget { name: name.to_string(), area, looks: looks.collect(), ..target.clone() };
    let grid = TargetGrid::new(&grown, settings).ok()?.with_elevations(ground);
    let plane = Plane::around(before);
    let corners: Vec<Point> = before.iter().filter_map(|corner| plane.project(*corner)).collect();
    let is_new = |position| plane.project(position).is_none_or(|point| !inside(point, &corners));
    let cells: Vec<bool> = grid.positions().map(is_new).collect();
    let grid = grid.only(|cell| cells.get(cell).copied().unwrap_or(false));
    (grid.total() > 0.0).then_some((grown, grid))
}

//! Building grids: areas, bands along perimeters, lines and points.

use super::cells::{CellRow, TargetGrid};
use super::clip::add_areas;
use crate::plane::{EqualAreaPlane, Point};
use crate::target::{ObservedTarget, Polygon, TargetArea};
use apex_geo::geodesy::{self, Position, RAD_PER_DEG};
use apex_geo::plane::{doubled_area, edges, point_to_segment};
use std::fmt;
use std::ops::Range;

/// Number of cells aimed at in a grid on which flights are scored.
pub const SCORING_CELLS: usize = 20_000;
/// Number of cells aimed at in a grid on which planners predict.
pub const PLANNING_CELLS: usize = 4_000;
/// Maximum number of cells of any grid.
pub const CELLS_MAX: usize = 60_000;

/// An area of a target that cannot be divided into cells.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaError {
    /// Name of the target.
    pub target: String,
    /// Defect and requirement.
    pub reason: String,
}

impl fmt::Display for AreaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the area of target `{}` cannot be observed: {}", self.target, self.reason)
    }
}

impl std::error::Error for AreaError {}

/// Resolution of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridSettings {
    /// Useful width of a swath, infinite if not known.
    pub useful_swath_m: f64,
    /// Number of cells aimed at: [`SCORING_CELLS`] or [`PLANNING_CELLS`].
    pub cells: usize,
}

impl Default for GridSettings {
    fn default() -> GridSettings {
        GridSettings { useful_swath_m: f64::INFINITY, cells: SCORING_CELLS }
    }
}

impl TargetGrid {
    /// Returns the grid of a target.
    ///
    /// # Errors
    /// [`AreaError`] if the area has too few corners, no extent, figures that are not finite, or spans more than 1,000 km.
    pub fn new(target: &ObservedTarget, settings: GridSettings) -> Result<TargetGrid, AreaError> {
        build(target, settings).map_err(|reason| AreaError { target: target.name.clone(), reason })
    }
}

/// Number of corners of the polygon that represents a circle and has its area.
const CIRCLE_CORNERS: usize = 96;
/// Greatest extent of one target.
const EXTENT_M_MAX: f64 = 1.0e6;
/// Maximum number of cells of the box around a perimeter's band.
const BAND_BOX_CELLS_MAX: f64 = 4.0e6;

fn build(target: &ObservedTarget, settings: GridSettings) -> Result<TargetGrid, String> {
    match &target.area {
        TargetArea::Point(position) => points(target, &[(*position, 1.0)], 1.0),
        TargetArea::Line(positions) => line(target, positions, settings),
        TargetArea::Circle { centre, radius_m } => {
            if !(radius_m.is_finite() && *radius_m > 0.0) {
                return Err(format!("its radius is {radius_m} m, expected a positive number"));
            }
            area(target, &[circle(*centre, *radius_m)], settings, None)
        }
        TargetArea::Polygons(polygons) => area(target, polygons, settings, None),
        TargetArea::Perimeter { polygons, half_width_m, interior_weight } => {
            if !(half_width_m.is_finite() && *half_width_m > 0.0) {
                return Err(format!("the half width of its perimeter is {half_width_m} m, expected a positive number"));
            }
            area(target, polygons, settings, Some((*half_width_m, interior_weight.clamp(0.0, 1.0))))
        }
    }
}

fn circle(centre: Position, radius_m: f64) -> Polygon {
    let turn_rad = 2.0 * std::f64::consts::PI / CIRCLE_CORNERS as f64;
    // The regular polygon with the area of the circle.
    let reach_m = radius_m * libm::sqrt(turn_rad / libm::sin(turn_rad));
    let corner = |index: usize| geodesy::destination(centre, 360.0 * index as f64 / CIRCLE_CORNERS as f64, reach_m);
    Polygon { outer: (0..CIRCLE_CORNERS).map(corner).collect(), holes: Vec::new() }
}

fn check(positions: &[Position]) -> Result<EqualAreaPlane, String> {
    let on_map = |position: &Position| position.latitude_deg.abs() <= 90.0 && position.longitude_deg.is_finite();
    if let Some(wrong) = positions.iter().find(|position| !on_map(position)) {
        return Err(format!("a corner is at latitude {}, longitude {}", wrong.latitude_deg, wrong.longitude_deg));
    }
    let bounds = geodesy::bounding_area(positions).ok_or("it has no corners")?;
    let mut width_deg = bounds.east_deg - bounds.west_deg;
    if width_deg < 0.0 {
        width_deg += 360.0;
    }
    let centre = Position {
        latitude_deg: 0.5 * (bounds.south_deg + bounds.north_deg),
        longitude_deg: geodesy::wrap_180(bounds.west_deg + 0.5 * width_deg),
    };
    let plane = EqualAreaPlane::new(centre);
    let reach_m = positions.iter().fold(0.0, |most: f64, position| most.max(plane.project(*position).length()));
    // Near a pole, a target that is wide in longitude is narrow on the plane, so its extent is measured there.
    if reach_m > 0.5 * EXTENT_M_MAX {
        return Err(format!("it spans {:.0} km; split it into targets of at most 1,000 km", 2e-3 * reach_m));
    }
    Ok(plane)
}

struct Rings {
    outer: Vec<Vec<Point>>,
    holes: Vec<Vec<Point>>,
}

impl Rings {
    fn all(&self) -> impl Iterator<Item = &Vec<Point>> {
        self.outer.iter().chain(&self.holes)
    }

    fn area_m2(&self) -> f64 {
        let area = |ring: &Vec<Point>| 0.5 * doubled_area(ring).abs();
        self.outer.iter().map(area).sum::<f64>() - self.holes.iter().map(area).sum::<f64>()
    }

    fn length_m(&self) -> f64 {
        self.all().flat_map(|ring| edges(ring)).map(|(a, b)| b.minus(a).length()).sum()
    }
}

fn area(
    target: &ObservedTarget,
    polygons: &[Polygon],
    settings: GridSettings,
    band: Option<(f64, f64)>,
) -> Result<TargetGrid, String> {
    let corners: Vec<Position> = polygons.iter().flat_map(|polygon| polygon.outer.iter().copied()).collect();
    let plane = check(&corners)?;
    let holes = || polygons.iter().flat_map(|polygon| &polygon.holes);
    if let Some(ring) = polygons.iter().map(|polygon| &polygon.outer).chain(holes()).find(|ring| ring.len() < 3) {
        return Err(format!("a ring has {} corners, expected at least 3", ring.len()));
    }
    let ring = |ring: &Vec<Position>| -> Vec<Point> { ring.iter().map(|corner| plane.project(*corner)).collect() };
    let rings = Rings { outer: polygons.iter().map(|p| ring(&p.outer)).collect(), holes: holes().map(ring).collect() };
    let polygon_m2 = rings.area_m2();
    let wanted_m2 = match band {
        None => polygon_m2,
        Some((half_m, interior)) => 2.0 * half_m * rings.length_m() + interior * polygon_m2,
    };
    if !(wanted_m2.is_finite() && wanted_m2 > 0.0 && polygon_m2 > 0.0) {
        return Err("its corners enclose no area".to_string());
    }
    let margin_m = band.map_or(0.0, |(half_m, _)| half_m);
    let (low, high) = bounds(rings.all().flatten(), margin_m);
    let box_m2 = (high.x - low.x) * (high.y - low.y);
    let limit_m2 = if band.is_some() {
        (box_m2 / BAND_BOX_CELLS_MAX).max(wanted_m2 / CELLS_MAX as f64)
    } else {
        wanted_m2 / CELLS_MAX as f64
    };
    let cell_m = cell_size_m(target, wanted_m2, settings).max(libm::sqrt(limit_m2));
    let columns = (libm::ceil((high.x - low.x) / cell_m) as usize).max(1);
    let rows = (libm::ceil((high.y - low.y) / cell_m) as usize).max(1);
    // The grid is centred on the box.
    let origin = Point {
        x: 0.5 * (low.x + high.x) - 0.5 * columns as f64 * cell_m,
        y: 0.5 * (low.y + high.y) - 0.5 * rows as f64 * cell_m,
    };
    let lattice = Lattice { origin, cell_m, rows, columns };
    let mut kept = KeptCells::default();
    match band {
        None => {
            let mut areas_m2 = areas_m2(&rings, &lattice);
            gather_inside(&middles_inside(&rings, &lattice), columns, &mut areas_m2);
            for (row, weights) in areas_m2.chunks(columns).enumerate() {
                kept.push_row(&lattice, row, weights);
            }
        }
        Some(band) => keep_band(&rings, &lattice, band, &mut kept),
    }
    Ok(finish(target, plane, cell_m, kept.rows, kept.cells))
}

/// Square cells in rows from the south-west corner.
struct Lattice {
    origin: Point,
    cell_m: f64,
    rows: usize,
    columns: usize,
}

impl Lattice {
    fn middle(&self, row: usize, column: usize) -> Point {
        let middle = |from: f64, index: usize| from + (index as f64 + 0.5) * self.cell_m;
        Point { x: middle(self.origin.x, column), y: middle(self.origin.y, row) }
    }
}

/// Cells of a lattice with a weight above 0.
#[derive(Default)]
struct KeptCells {
    rows: Vec<CellRow>,
    cells: Vec<(Point, f64)>,
}

impl KeptCells {
    /// Adds a row; rows come from south to north, each once.
    fn push_row(&mut self, lattice: &Lattice, row: usize, weights: &[f64]) {
        let first = self.cells.len();
        let wanted = weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0);
        self.cells.extend(wanted.map(|(column, weight)| (lattice.middle(row, column), *weight)));
        if let Some((Point { x: west, y }, _)) = self.cells.get(first) {
            self.rows.push(CellRow { y: *y, first, count: self.cells.len() - first, west: *west });
        }
    }
}

/// Returns the area of the rings in each cell, row by row.
fn areas_m2(rings: &Rings, lattice: &Lattice) -> Vec<f64> {
    let mut areas = vec![0.0; lattice.rows * lattice.columns];
    for outer in &rings.outer {
        add_areas(outer, lattice.origin, lattice.cell_m, lattice.columns, &mut areas, 1.0);
    }
    for hole in &rings.holes {
        add_areas(hole, lattice.origin, lattice.cell_m, lattice.columns, &mut areas, -1.0);
    }
    let cell_m2 = lattice.cell_m * lattice.cell_m;
    areas.iter_mut().for_each(|area_m2| *area_m2 = area_m2.clamp(0.0, cell_m2));
    areas
}

/// Returns the cell size `min(W_use / 30, max(g_want, sqrt(area / cells)))`, with the finest wanted resolution.
fn cell_size_m(target: &ObservedTarget, area_m2: f64, settings: GridSettings) -> f64 {
    let finest_m = target.looks.iter().fold(f64::INFINITY, |finest, look| finest.min(look.resolution.wanted_m));
    let finest_m = if finest_m.is_finite() { finest_m } else { 0.0 };
    let by_area_m = libm::sqrt(area_m2 / settings.cells.clamp(1, CELLS_MAX) as f64);
    let by_swath_m = if settings.useful_swath_m > 0.0 { settings.useful_swath_m / 30.0 } else { f64::INFINITY };
    by_swath_m.min(by_area_m.max(finest_m))
}

fn bounds<'a>(points: impl Iterator<Item = &'a Point>, margin_m: f64) -> (Point, Point) {
    let (mut low, mut high) =
        (Point { x: f64::INFINITY, y: f64::INFINITY }, Point { x: f64::NEG_INFINITY, y: f64::NEG_INFINITY });
    for point in points {
        low = Point { x: low.x.min(point.x - margin_m), y: low.y.min(point.y - margin_m) };
        high = Point { x: high.x.max(point.x + margin_m), y: high.y.max(point.y + margin_m) };
    }
    (low, high)
}

/// Returns for each cell true if its middle is inside the rings (even-odd rule).
fn middles_inside(rings: &Rings, lattice: &Lattice) -> Vec<bool> {
    let mut inside = vec![false; lattice.rows * lattice.columns];
    for (row, cells) in inside.chunks_mut(lattice.columns).enumerate() {
        let y = lattice.middle(row, 0).y;
        let crossing = |(a, b): (Point, Point)| {
            let spans = (a.y > y) != (b.y > y);
            spans.then(|| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
        };
        let mut crossings: Vec<f64> = rings.all().flat_map(|ring| edges(ring)).filter_map(crossing).collect();
        crossings.sort_by(f64::total_cmp);
        for (column, cell) in cells.iter_mut().enumerate() {
            let x = lattice.middle(row, column).x;
            *cell = crossings.partition_point(|crossing| *crossing < x) % 2 == 1;
        }
    }
    inside
}

/// Moves the area of a border cell whose centre is outside to its largest neighbour whose centre is inside, so that only wanted ground is
/// evaluated. A cell without such a neighbour keeps its area.
fn gather_inside(inside: &[bool], columns: usize, areas: &mut [f64]) {
    let is_inside = |index: usize| inside.get(index).copied().unwrap_or(false);
    let outside: Vec<usize> = (0..areas.len()).filter(|index| !is_inside(*index)).collect();
    for index in outside {
        let area_m2 = areas.get(index).copied().unwrap_or(0.0);
        if area_m2 <= 0.0 {
            continue;
        }
        let column = index % columns;
        let mut best: Option<(usize, f64)> = None;
        for (up, right) in [(1, 1), (0, 1), (2, 1), (1, 0), (1, 2), (0, 0), (0, 2), (2, 0), (2, 2)] {
            // Offsets are shifted by one, so that they are not negative.
            let is_in_row = (1..=columns).contains(&(column + right));
            let Some(neighbour) = (index + up * columns + right).checked_sub(columns + 1).filter(|_| is_in_row) else {
                continue;
            };
            let neighbour_m2 = areas.get(neighbour).copied().unwrap_or(0.0);
            if is_inside(neighbour) && best.is_none_or(|(_, most_m2)| neighbour_m2 > most_m2) {
                best = Some((neighbour, neighbour_m2));
            }
        }
        if let Some((neighbour, _)) = best {
            if let Some(sum_m2) = areas.get_mut(neighbour) {
                *sum_m2 += area_m2;
            }
            if let Some(own_m2) = areas.get_mut(index) {
                *own_m2 = 0.0;
            }
        }
    }
}

/// An edge of a ring, with the rows and columns whose centres may be in the band around it.
struct BandEdge {
    ends: (Point, Point),
    rows: Range<usize>,
    columns: Range<usize>,
}

impl BandEdge {
    fn new((a, b): (Point, Point), lattice: &Lattice, reach_m: f64) -> BandEdge {
        let (low, high) = bounds([a, b].iter(), reach_m);
        let index = |metres: f64, most: usize| (libm::floor(metres / lattice.cell_m).max(0.0) as usize).min(most);
        let range =
            |low_m: f64, high_m: f64, count: usize| index(low_m, count)..index(high_m, count.saturating_sub(1)) + 1;
        BandEdge {
            ends: (a, b),
            rows: range(low.y - lattice.origin.y, high.y - lattice.origin.y, lattice.rows),
            columns: range(low.x - lattice.origin.x, high.x - lattice.origin.x, lattice.columns),
        }
    }

    /// Lowers the distances of a row's centres from the nearest edge to those from this edge.
    fn lower(&self, lattice: &Lattice, row: usize, distances_m: &mut [f64]) {
        let (a, b) = self.ends;
        for (column, distance_m) in distances_m.iter_mut().enumerate().take(self.columns.end).skip(self.columns.start) {
            *distance_m = distance_m.min(point_to_segment(lattice.middle(row, column), a, b));
        }
    }
}

/// Keeps the cells of the band along the rings' edges, and those of their interior if it has a weight. Row by row: the box around a thin
/// band has many more cells than the band. Bound: O(cells of the box + cells near edges).
fn keep_band(rings: &Rings, lattice: &Lattice, (half_m, interior): (f64, f64), kept: &mut KeptCells) {
    let (columns, cell_m, cell_m2) = (lattice.columns, lattice.cell_m, lattice.cell_m * lattice.cell_m);
    let areas_m2 = if interior > 0.0 { areas_m2(rings, lattice) } else { Vec::new() };
    let all = rings.all().flat_map(|ring| edges(ring));
    let mut waiting: Vec<BandEdge> = all.map(|ends| BandEdge::new(ends, lattice, half_m + cell_m)).collect();
    // The edge whose rows begin first is the last one.
    waiting.sort_by_key(|edge| std::cmp::Reverse(edge.rows.start));
    let mut near: Vec<BandEdge> = Vec::new();
    let (mut distances_m, mut weights) = (vec![f64::INFINITY; columns], vec![0.0; columns]);
    for row in 0..lattice.rows {
        near.retain(|edge| edge.rows.end > row);
        while let Some(edge) = waiting.pop_if(|edge| edge.rows.start <= row) {
            near.push(edge);
        }
        distances_m.fill(f64::INFINITY);
        for edge in near.iter().filter(|edge| edge.rows.contains(&row)) {
            edge.lower(lattice, row, &mut distances_m);
        }
        let inside = areas_m2.iter().skip(row * columns).copied().chain(std::iter::repeat(0.0));
        for ((weight, distance_m), area_m2) in weights.iter_mut().zip(&distances_m).zip(inside) {
            let share = ((half_m - distance_m) / cell_m + 0.5).clamp(0.0, 1.0);
            *weight = share * cell_m2 + (1.0 - share) * interior * area_m2;
        }
        kept.push_row(lattice, row, &weights);
    }
}

fn line(target: &ObservedTarget, positions: &[Position], settings: GridSettings) -> Result<TargetGrid, String> {
    if positions.len() < 2 {
        return Err(format!("its line has {} points, expected at least 2", positions.len()));
    }
    check(positions)?;
    let legs = || positions.iter().zip(positions.iter().skip(1));
    let length_m: f64 = legs().map(|(from, to)| geodesy::distance_m(*from, *to)).sum();
    if !(length_m.is_finite() && length_m > 0.0) {
        return Err("its line has no length".to_string());
    }
    let by_count_m = length_m / (settings.cells as f64).min(2_000.0);
    let cell_m = (settings.useful_swath_m / 30.0).min(by_count_m.max(1.0)).max(length_m / CELLS_MAX as f64);
    let mut cells = Vec::new();
    for (from, to) in legs() {
        let (leg_m, azimuth_deg) = geodesy::inverse(*from, *to);
        let count = (libm::ceil(leg_m / cell_m) as usize).max(1);
        let step_m = leg_m / count as f64;
        let middle = |index: usize| geodesy::destination(*from, azimuth_deg, (index as f64 + 0.5) * step_m);
        cells.extend((0..count).filter(|_| step_m > 0.0).map(|index| (middle(index), step_m)));
    }
    points(target, &cells, cell_m)
}

/// Returns a grid of single points, one per row.
fn points(target: &ObservedTarget, cells: &[(Position, f64)], cell_m: f64) -> Result<TargetGrid, String> {
    let positions: Vec<Position> = cells.iter().map(|(position, _)| *position).collect();
    let plane = check(&positions)?;
    let mut placed: Vec<(Point, f64)> =
        cells.iter().map(|(position, weight)| (plane.project(*position), *weight)).collect();
    placed.sort_by(|(a, _), (b, _)| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    let rows = placed
        .iter()
        .enumerate()
        .map(|(first, (point, _))| CellRow { y: point.y, first, count: 1, west: point.x })
        .collect();
    let grid = placed.iter().map(|(point, weight)| (*point, *weight)).collect();
    Ok(finish(target, plane, cell_m, rows, grid))
}

/// Returns the unit normal of the ellipsoid at a position, in Earth-fixed axes: towards (0, 0), towards (0, 90 E), to the north pole.
fn normal_of(position: Position) -> [f64; 3] {
    let (latitude_rad, longitude_rad) = (position.latitude_deg * RAD_PER_DEG, position.longitude_deg * RAD_PER_DEG);
    let cosine = libm::cos(latitude_rad);
    [cosine * libm::cos(longitude_rad), cosine * libm::sin(longitude_rad), libm::sin(latitude_rad)]
}

fn finish(
    target: &ObservedTarget,
    plane: EqualAreaPlane,
    cell_m: f64,
    rows: Vec<CellRow>,
    cells: Vec<(Point, f64)>,
) -> TargetGrid {
    let (low, high) = bounds(cells.iter().map(|(point, _)| point), 0.5 * cell_m);
    let mut normals = Vec::with_capacity(cells.len());
    for row in &rows {
        let in_row: Vec<f64> = cells.iter().skip(row.first).take(row.count).map(|(point, _)| point.x).collect();
        normals.extend(plane.row_positions(row.y, &in_row).map(normal_of));
    }
    TargetGrid {
        plane,
        cell_m,
        rows,
        normals,
        x: cells.iter().map(|(point, _)| point.x).collect(),
        total: cells.iter().map(|(_, weight)| weight).sum(),
        weights: cells.into_iter().map(|(_, weight)| weight).collect(),
        elevations_m: Vec::new(),
        elevation_m: target.elevation_m,
        is_terrain_missing: false,
        slope_max: 0.0,
        low,
        high,
    }
}

#[cfg(test)]
#[path = "band_tests.rs"]
mod band_tests;

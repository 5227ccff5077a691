//! Bands along perimeters against their definition: every cell of the box, and its distance from every edge.

use super::*;
use crate::target::WantedLook;

/// Returns a grid of the band of an outline with a hole, and its rings on the plane.
fn banded(half_width_m: f64, interior_weight: f64) -> (TargetGrid, Rings) {
    let ring = |corners: &[(f64, f64)]| -> Vec<Position> {
        corners.iter().map(|(latitude, longitude)| Position::new(*latitude, *longitude)).collect()
    };
    let outer = ring(&[(40.0, -120.0), (40.09, -120.03), (40.12, -119.93), (40.05, -119.95), (40.01, -119.88)]);
    let hole = ring(&[(40.04, -119.99), (40.06, -119.99), (40.05, -119.97)]);
    let polygons = vec![Polygon { outer: outer.clone(), holes: vec![hole.clone()] }];
    let target = ObservedTarget {
        name: "fire".into(),
        area: TargetArea::Perimeter { polygons, half_width_m, interior_weight },
        elevation_m: 0.0,
        is_water: false,
        looks: vec![WantedLook::new("any", 1.0, 10.0)],
        after: Vec::new(),
    };
    let grid = TargetGrid::new(&target, GridSettings { cells: 2_000, ..GridSettings::default() }).unwrap();
    let on_plane = |ring: &[Position]| ring.iter().map(|corner| grid.plane.project(*corner)).collect::<Vec<Point>>();
    let rings = Rings { outer: vec![on_plane(&outer)], holes: vec![on_plane(&hole)] };
    (grid, rings)
}

fn distance_m(rings: &Rings, middle: Point) -> f64 {
    let each = rings.all().flat_map(|ring| edges(ring)).map(|(a, b)| point_to_segment(middle, a, b));
    each.fold(f64::INFINITY, f64::min)
}

/// The weight of a cell is the share of it in the band, and every cell with a share is in the grid.
#[test]
fn cells_of_a_band_are_those_near_an_edge() {
    for half_m in [40.0, 250.0, 900.0] {
        let (grid, rings) = banded(half_m, 0.0);
        let cell_m = grid.cell_m;
        let share = |middle: Point| ((half_m - distance_m(&rings, middle)) / cell_m + 0.5).clamp(0.0, 1.0);
        let cells: Vec<(f64, f64)> = grid.centres().collect();
        for ((x, y), weight) in cells.iter().zip(&grid.weights) {
            let wanted = share(Point { x: *x, y: *y }) * cell_m * cell_m;
            assert!((weight - wanted).abs() <= 1e-6 * cell_m * cell_m, "{half_m}: {weight}, not {wanted}");
        }
        let (first_x, first_y) = cells[0];
        let (low, high) = bounds(rings.all().flatten(), half_m + cell_m);
        let from = |first: f64, low: f64| libm::floor((low - first) / cell_m) as i64;
        let columns = from(first_x, low.x)..=from(first_x, high.x) + 1;
        let rows = from(first_y, low.y)..=from(first_y, high.y) + 1;
        let at = |index: i64, first: f64| first + index as f64 * cell_m;
        let near = rows.flat_map(|row| columns.clone().map(move |column| (row, column)));
        let count = near.filter(|(row, column)| share(Point { x: at(*column, first_x), y: at(*row, first_y) }) > 1e-9);
        assert_eq!(cells.len(), count.count(), "{half_m}");
    }
}

/// With a weight of the interior, the whole weighs as much as the band and the weighted rest of the area.
#[test]
fn the_interior_of_a_band_has_its_weight() {
    let (half_m, weight) = (250.0, 0.3);
    let ((plain, rings), (weighted, _)) = (banded(half_m, 0.0), banded(half_m, weight));
    // About half of the band is inside.
    let wanted = plain.total + weight * (rings.area_m2() - 0.5 * plain.total);
    assert!((weighted.total / wanted - 1.0).abs() < 0.01, "{}, about {wanted}", weighted.total);
}

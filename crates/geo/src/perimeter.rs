//! Lines along the outline of a target, for targets of which only the perimeter is wanted.
//!
//! The outline is simplified (Douglas and Peucker), for fewer turns; every point of the true outline is still well inside the swath.
//! Bound: O(corners^2), lines at most [`PERIMETER_LINES_MAX`].

use crate::geodesy::{self, Position};
use crate::plane::{self, Plane, Point};

/// Maximum number of lines of one outline; above it the outline must be simpler.
pub const PERIMETER_LINES_MAX: usize = 1_000;
/// Greatest deviation of the simplified outline from the true one, as a share of the swath: half of the visible ground on either side
/// remains for the vehicle's own deviations.
pub const OUTLINE_SHARE_OF_SWATH: f64 = 0.25;

/// Returns lines along the outline given by `corners` (in order, not closed), once around, from the corner nearest to
/// `approach` back to it. Every point of the outline lies within a quarter of `swath_m` of a line.
///
/// # Errors
/// An error message if the outline or the swath is invalid, or too many lines would be needed.
pub fn perimeter_lines(
    corners: &[Position],
    swath_m: f64,
    approach: Position,
) -> Result<Vec<(Position, Position)>, String> {
    let finite = |position: &Position| position.latitude_deg.is_finite() && position.longitude_deg.is_finite();
    if corners.len() < 3 || !corners.iter().all(finite) {
        return Err("the outline to fly along needs at least three corners on the map".to_string());
    }
    if !swath_m.is_finite() || swath_m <= 0.0 {
        return Err(format!("a swath of {swath_m} m cannot follow an outline; it must be positive"));
    }
    let plane = Plane::around(corners);
    let points: Option<Vec<Point>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    let mut points = points.ok_or("the outline is larger than half a continent; split it")?;
    points.dedup();
    while points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    // Distances on the plane are never shorter than on the ground, so that the tolerance holds there too.
    let mut turns: Vec<Position> =
        simplified(&points, OUTLINE_SHARE_OF_SWATH * swath_m).into_iter().map(|point| plane.position(point)).collect();
    if turns.len() < 2 {
        return Err("the outline to fly along is a single point; it needs at least three corners".to_string());
    }
    if turns.len() > PERIMETER_LINES_MAX {
        return Err(format!("the outline would need {} lines; fly higher or split it", turns.len()));
    }
    let distances = turns.iter().map(|turn| geodesy::distance_m(approach, *turn)).enumerate();
    let nearest = distances.min_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(index, _)| index);
    turns.rotate_left(nearest);
    let next = turns.iter().skip(1).chain(turns.first());
    Ok(turns.iter().zip(next).map(|(from, to)| (*from, *to)).collect())
}

/// Returns the corners of a closed outline that suffice to stay within `tolerance_m` of all of it.
fn simplified(points: &[Point], tolerance_m: f64) -> Vec<Point> {
    // Cut at the two corners that are far apart: each half is an open line with ends that stay.
    let far_from = |from: Point| {
        let distances = points.iter().map(|point| point.minus(from).length()).enumerate();
        distances.max_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(index, _)| index)
    };
    let start = points.first().map_or(0, |first| far_from(*first));
    let mut ring: Vec<Point> = points.to_vec();
    ring.rotate_left(start);
    let middle = ring.first().map_or(0, |first| {
        let distances = ring.iter().map(|point| point.minus(*first).length()).enumerate();
        distances.max_by(|(_, a), (_, b)| a.total_cmp(b)).map_or(0, |(index, _)| index)
    });
    ring.extend(ring.first().copied());
    let end = ring.len().saturating_sub(1);
    let mut kept = vec![false; ring.len()];
    let mut open = vec![(0, middle), (middle, end)];
    while let Some((from, to)) = open.pop() {
        for index in [from, to] {
            if let Some(slot) = kept.get_mut(index) {
                *slot = true;
            }
        }
        let (Some(a), Some(b)) = (ring.get(from), ring.get(to)) else { continue };
        let between = ring.iter().enumerate().take(to).skip(from + 1);
        let away = between.map(|(index, point)| (index, plane::point_to_segment(*point, *a, *b)));
        let farthest = away.max_by(|(_, a), (_, b)| a.total_cmp(b));
        if let Some((index, _)) = farthest.filter(|(_, away_m)| *away_m > tolerance_m) {
            open.extend([(from, index), (index, to)]);
        }
    }
    // The last corner closes the ring: it equals the first.
    ring.iter().zip(&kept).take(end).filter(|(_, kept)| **kept).map(|(point, _)| *point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CENTRE: Position = Position::new(40.0, -120.0);

    fn around(count: usize, reach_m: impl Fn(usize) -> f64) -> Vec<Position> {
        let corner = |index| geodesy::destination(CENTRE, 360.0 * index as f64 / count as f64, reach_m(index));
        (0..count).map(corner).collect()
    }

    #[test]
    fn a_square_is_flown_around_from_the_nearest_corner_and_back_to_it() {
        let mut square = around(4, |_| 10_000.0);
        // Corners in the middle of sides and a dent within the tolerance are left out; a last corner that equals the first changes nothing.
        square.insert(1, geodesy::midpoint(square[0], square[1]));
        square.insert(1, geodesy::destination(square[1], 225.0, 300.0));
        square.push(square[0]);
        let approach = Position::new(39.0, -120.0);
        let lines = perimeter_lines(&square, 4_000.0, approach).unwrap();
        assert_eq!(lines.len(), 4, "{lines:?}");
        assert!(geodesy::distance_m(lines[0].0, geodesy::destination(CENTRE, 180.0, 10_000.0)) < 1.0);
        assert_eq!(lines[3].1, lines[0].0);
        assert!(lines.windows(2).all(|pair| pair[0].1 == pair[1].0));
        assert_eq!(perimeter_lines(&square, 100.0, approach).unwrap().len(), 6, "the dent with a narrow swath");
    }

    #[test]
    fn what_is_not_an_outline_is_refused() {
        let square = around(4, |_| 1_000.0);
        assert!(perimeter_lines(&square[..2], 100.0, CENTRE).unwrap_err().contains("three corners"));
        assert!(perimeter_lines(&square, 0.0, CENTRE).unwrap_err().contains("must be positive"));
        assert!(perimeter_lines(&[CENTRE; 5], 100.0, CENTRE).unwrap_err().contains("single point"));
        let jagged = around(3_000, |index| if index % 2 == 0 { 90_000.0 } else { 80_000.0 });
        assert!(perimeter_lines(&jagged, 100.0, CENTRE).unwrap_err().contains("3000 lines"));
        let thin = [CENTRE, geodesy::destination(CENTRE, 90.0, 5_000.0), geodesy::destination(CENTRE, 90.0, 2_500.0)];
        assert_eq!(perimeter_lines(&thin, 1_000.0, CENTRE).unwrap().len(), 2, "there and back");
    }

    proptest! {
        #[test]
        fn the_whole_outline_stays_inside_the_swath(
            corners in prop::collection::vec((0.0..360.0f64, 2_000.0..40_000.0f64), 3..40),
            swath_m in 1_000.0..20_000.0f64, probe in any::<prop::sample::Index>(), share in 0.0..1.0f64,
        ) {
            let mut corners = corners;
            corners.sort_by(|a, b| a.0.total_cmp(&b.0));
            let outline: Vec<Position> =
                corners.iter().map(|(azimuth, reach)| geodesy::destination(CENTRE, *azimuth, *reach)).collect();
            let lines = perimeter_lines(&outline, swath_m, CENTRE).unwrap();
            prop_assert!(lines.len() <= outline.len());
            let side = probe.index(outline.len());
            let point = geodesy::interpolate(outline[side], outline[(side + 1) % outline.len()], share);
            let plane = Plane::new(CENTRE);
            let flat = |position: Position| plane.project(position).unwrap();
            let least = lines.iter().map(|(from, to)| plane::point_to_segment(flat(point), flat(*from), flat(*to)));
            let least = least.fold(f64::INFINITY, f64::min);
            prop_assert!(least <= OUTLINE_SHARE_OF_SWATH * swath_m + 5.0, "{least} of {swath_m}");
            let nearest = lines.iter().map(|(from, _)| geodesy::distance_m(CENTRE, *from)).fold(f64::INFINITY, f64::min);
            prop_assert!(geodesy::distance_m(CENTRE, lines[0].0) <= nearest);
        }
    }
}

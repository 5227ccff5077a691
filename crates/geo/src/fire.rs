//! Growth of a fire as an ellipse in wind.
//!
//! Head rate: a tenth of the open wind at 10 m (Cruz and Alexander 2019, forests and shrubs, dry and windy; error up to 50 %). Shape:
//! length to breadth by the wind at mid-flame height (Finney 1998, FARSITE), which is assumed to be 0.4 of the open wind. The fire starts
//! at a focus: it spreads ahead at the head rate, and back at the head rate over the ratio of both (Finney 1998).

use crate::plane::{Point, edges};
use libm::{cos, exp, sin, sqrt};

/// Share of the open wind at 10 m that blows at mid-flame height.
pub const MID_FLAME_SHARE: f64 = 0.4;
/// Head rate for each m/s of open wind.
pub const HEAD_SHARE: f64 = 0.10;
/// Head rate in still air: a fire spreads without wind, too.
pub const HEAD_MPS_MIN: f64 = 0.01;

/// Rates of an elliptical fire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FireSpread {
    /// Advance of the head with the wind.
    pub head_mps: f64,
    /// Advance of the back against the wind.
    pub back_mps: f64,
    /// Growth of half the breadth.
    pub half_breadth_mps: f64,
    /// Length over breadth.
    pub length_to_breadth: f64,
}

impl FireSpread {
    /// Returns the spread in an open wind of `wind_mps` at 10 m.
    pub fn in_wind(wind_mps: f64) -> FireSpread {
        let head_mps = (HEAD_SHARE * wind_mps).max(HEAD_MPS_MIN);
        let length_to_breadth = length_to_breadth(MID_FLAME_SHARE * wind_mps);
        let root = sqrt((length_to_breadth * length_to_breadth - 1.0).max(0.0));
        let head_to_back = (length_to_breadth + root) / (length_to_breadth - root);
        let back_mps = head_mps / head_to_back;
        let half_length_mps = 0.5 * (head_mps + back_mps);
        FireSpread { head_mps, back_mps, half_breadth_mps: half_length_mps / length_to_breadth, length_to_breadth }
    }

    /// Returns the length and breadth, m, `age_s` after the fire broke out at a point.
    pub fn size_m(&self, age_s: f64) -> (f64, f64) {
        let age_s = age_s.max(0.0);
        ((self.head_mps + self.back_mps) * age_s, 2.0 * self.half_breadth_mps * age_s)
    }

    /// Returns area, m2, `age_s` after the fire broke out at a point.
    pub fn area_m2(&self, age_s: f64) -> f64 {
        let (length_m, breadth_m) = self.size_m(age_s);
        0.25 * std::f64::consts::PI * length_m * breadth_m
    }
}

/// Corners of a grown outline.
pub const OUTLINE_CORNERS: usize = 72;
/// Points per side of the outline's box from which the fire is assumed to spread.
const SPREADING_PARTS: f64 = 64.0;

/// Returns the outline of a burning area after `age_s`: every point of it burns on as an ellipse (Huygens' principle with the ellipses of
/// Richards 1990), with wind along `towards`, a unit vector. The outline is seen from `middle`, which is inside: bays of the true outline
/// that are not visible from `middle` are closed. Bound: O(points of the outline * [`OUTLINE_CORNERS`]).
pub fn grown(outline: &[Point], middle: Point, spread: &FireSpread, towards: Point, age_s: f64) -> Vec<Point> {
    let age_s = age_s.max(0.0);
    let along_m = 0.5 * (spread.head_mps + spread.back_mps) * age_s;
    let across_m = spread.half_breadth_mps * age_s;
    let shift_m = 0.5 * (spread.head_mps - spread.back_mps) * age_s;
    let sources = sources(outline);
    let corner = |number: usize| {
        let angle_rad = 2.0 * std::f64::consts::PI * number as f64 / OUTLINE_CORNERS as f64;
        let ray = Point { x: sin(angle_rad), y: cos(angle_rad) };
        let reach_m = sources.iter().fold(0.0, |most: f64, source| {
            let centre = source.plus(shift_m, towards).minus(middle);
            most.max(ellipse_reach_m(centre, ray, towards, (along_m, across_m)).unwrap_or(0.0))
        });
        middle.plus(reach_m, ray)
    };
    (0..OUTLINE_CORNERS).map(corner).collect()
}

/// Returns points along the outline, its corners included.
fn sources(outline: &[Point]) -> Vec<Point> {
    let extent = |side: fn(&Point) -> f64| {
        let low = outline.iter().map(side).fold(f64::INFINITY, f64::min);
        outline.iter().map(side).fold(f64::NEG_INFINITY, f64::max) - low
    };
    let step_m = (extent(|point| point.x).max(extent(|point| point.y)) / SPREADING_PARTS).max(1.0);
    let along = |(from, to): (Point, Point)| {
        let parts = libm::ceil(to.minus(from).length() / step_m).clamp(1.0, SPREADING_PARTS) as usize;
        (0..parts).map(move |part| from.plus(part as f64 / parts as f64, to.minus(from)))
    };
    edges(outline).flat_map(along).collect()
}

/// Returns the farthest point of an ellipse on a ray from the origin; `None` if the ray misses it.
fn ellipse_reach_m(centre: Point, ray: Point, towards: Point, (along_m, across_m): (f64, f64)) -> Option<f64> {
    // In units of the half axes the ellipse is a circle of radius one.
    let scaled = |vector: Point| {
        let aside = towards.cross(vector);
        Point { x: vector.dot(towards) / along_m.max(1e-3), y: aside / across_m.max(1e-3) }
    };
    let (ray, centre) = (scaled(ray), scaled(centre));
    let (square, product) = (ray.dot(ray), ray.dot(centre));
    let discriminant = product * product - square * (centre.dot(centre) - 1.0);
    let reach = (product + sqrt(discriminant.max(0.0))) / square;
    (discriminant >= 0.0 && reach > 0.0).then_some(reach)
}

/// Returns length over breadth at a mid-flame wind in m/s; at least 1.
fn length_to_breadth(mid_flame_mps: f64) -> f64 {
    let ratio = 0.936 * exp(0.2566 * mid_flame_mps) + 0.461 * exp(-0.1548 * mid_flame_mps) - 0.397;
    ratio.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, wanted: f64, within: f64) {
        assert!((value - wanted).abs() <= within, "{value} for {wanted}");
    }

    /// The ratios that FARSITE's formula gives for mid-flame winds of 1, 2, 4 and 8 m/s.
    #[test]
    fn length_to_breadth_follows_the_wind() {
        for (wind_mps, wanted) in [(1.0, 1.208), (2.0, 1.505), (4.0, 2.464), (8.0, 7.028)] {
            near(length_to_breadth(wind_mps), wanted, 0.001);
        }
        assert_eq!(length_to_breadth(0.0), 1.0);
    }

    /// In an open wind of 5 m/s: head 0.5, back 0.072, half breadth 0.190 m/s; after an hour 2,060 m by 1,369 m, 2.22 km2.
    #[test]
    fn an_hour_in_five_metres_a_second() {
        let spread = FireSpread::in_wind(5.0);
        near(spread.head_mps, 0.5, 1e-12);
        near(spread.back_mps, 0.072, 0.0005);
        near(spread.half_breadth_mps, 0.190, 0.0005);
        let (length_m, breadth_m) = spread.size_m(3_600.0);
        near(length_m, 2_060.0, 5.0);
        near(breadth_m, 1_369.0, 5.0);
        near(spread.area_m2(3_600.0) / 1e6, 2.22, 0.01);
        near(0.5 * (spread.head_mps - spread.back_mps) * 3_600.0, 770.0, 2.0);
    }

    /// A point burns to the ellipse of the formula; a square grows by the head rate ahead, the back rate behind, half the breadth aside.
    #[test]
    fn outlines_grow_by_the_rates_of_the_ellipse() {
        let spread = FireSpread::in_wind(5.0);
        let east = Point { x: 1.0, y: 0.0 };
        let side = |x: f64, y: f64| Point { x, y };
        let square = [side(-500.0, -500.0), side(-500.0, 500.0), side(500.0, 500.0), side(500.0, -500.0)];
        let outline = grown(&square, Point::default(), &spread, east, 3_600.0);
        let most = |of: fn(&Point) -> f64| outline.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        near(most(|point| point.x), 500.0 + 0.5 * 3_600.0, 3.0);
        near(most(|point| -point.x), 500.0 + spread.back_mps * 3_600.0, 3.0);
        near(most(|point| point.y), 500.0 + spread.half_breadth_mps * 3_600.0, 3.0);
        // All burned ground stays burned, and a further hour burns more.
        let later = grown(&square, Point::default(), &spread, east, 7_200.0);
        assert!(square.iter().all(|corner| crate::plane::inside(*corner, &outline)));
        assert!(outline.iter().all(|corner| crate::plane::inside(*corner, &later)));
        let turned = grown(&square, Point::default(), &spread, Point { x: 0.0, y: -1.0 }, 3_600.0);
        near(turned.iter().map(|point| -point.y).fold(0.0, f64::max), 500.0 + 0.5 * 3_600.0, 3.0);
    }

    /// The area of a grown square against Steiner's formula for the sum with an ellipse: A + sides + pi a b.
    #[test]
    fn the_area_that_burns_is_the_minkowski_sum() {
        let spread = FireSpread::in_wind(4.0);
        let side_m = 2_000.0;
        let corner = |x: f64, y: f64| Point { x: side_m * x, y: side_m * y };
        let square = [corner(-0.5, -0.5), corner(-0.5, 0.5), corner(0.5, 0.5), corner(0.5, -0.5)];
        let outline = grown(&square, Point::default(), &spread, Point { x: 1.0, y: 0.0 }, 1_800.0);
        let (along_m, across_m) =
            (0.5 * (spread.head_mps + spread.back_mps) * 1_800.0, spread.half_breadth_mps * 1_800.0);
        let wanted = side_m * side_m + 2.0 * side_m * (along_m + across_m) + std::f64::consts::PI * along_m * across_m;
        near(0.5 * crate::plane::doubled_area(&outline).abs() / wanted, 1.0, 0.01);
    }
}

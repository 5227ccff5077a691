//! A local plane: the gnomonic projection, in which great circles are straight lines, and plane geometry on it.
//!
//! Legs and edges of airspace are straight lines here, so that crossing tests are topologically exact. The plane covers an area of up to
//! [`REACH_DEG_MAX`] around its centre. Away from the centre distances are stretched, never shrunk; [`Plane::stretch`] returns the
//! factor. Great circle and geodesic differ by less than 200 m on a leg of 1,000 km.

use crate::geodesy::{EARTH_RADIUS_M_MEAN, Position, RAD_PER_DEG, wrap_180};

/// Farthest angle from the centre that is projected: the stretch there is 12 along a radius, enough to be of no use beyond.
pub const REACH_DEG_MAX: f64 = 73.0;

/// A point of the plane in metres, east and north of the centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
}

impl Point {
    /// Returns `self - other`.
    pub fn minus(self, other: Point) -> Point {
        Point { x: self.x - other.x, y: self.y - other.y }
    }

    /// Returns `self + scale * other`.
    pub fn plus(self, scale: f64, other: Point) -> Point {
        Point { x: self.x + scale * other.x, y: self.y + scale * other.y }
    }

    /// Returns the scalar product.
    pub fn dot(self, other: Point) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Returns the vector product: positive if `other` is to the left.
    pub fn cross(self, other: Point) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Returns the length.
    pub fn length(self) -> f64 {
        libm::hypot(self.x, self.y)
    }

    /// Returns the unit vector in the same direction; `None` for a vector of length zero.
    pub fn unit(self) -> Option<Point> {
        let length = self.length();
        (length > 0.0 && length.is_finite()).then(|| Point { x: self.x / length, y: self.y / length })
    }
}

/// The projection around a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    centre: Position,
    sine: f64,
    cosine: f64,
}

impl Plane {
    /// Returns the plane that touches the Earth at `centre`.
    pub fn new(centre: Position) -> Plane {
        let latitude_rad = centre.latitude_deg * RAD_PER_DEG;
        Plane { centre, sine: libm::sin(latitude_rad), cosine: libm::cos(latitude_rad) }
    }

    /// Returns the plane that touches the Earth in the middle of `positions`; at (0, 0) for none.
    pub fn around(positions: &[Position]) -> Plane {
        let centre = crate::geodesy::bounding_area(positions).map_or(Position::default(), |area| {
            let mut width_deg = area.east_deg - area.west_deg;
            if width_deg < 0.0 {
                width_deg += 360.0;
            }
            let longitude_deg = wrap_180(area.west_deg + 0.5 * width_deg);
            Position { latitude_deg: 0.5 * (area.south_deg + area.north_deg), longitude_deg }
        });
        Plane::new(centre)
    }

    /// Returns the point of the plane for `position`; `None` beyond [`REACH_DEG_MAX`] and for positions that are not finite.
    pub fn project(&self, position: Position) -> Option<Point> {
        let latitude_rad = position.latitude_deg * RAD_PER_DEG;
        let turn_rad = (position.longitude_deg - self.centre.longitude_deg) * RAD_PER_DEG;
        let (sine, cosine) = (libm::sin(latitude_rad), libm::cos(latitude_rad));
        let turn_cosine = libm::cos(turn_rad);
        let height = self.sine * sine + self.cosine * cosine * turn_cosine;
        if height.is_nan() || height <= libm::cos(REACH_DEG_MAX * RAD_PER_DEG) {
            return None;
        }
        let scale = EARTH_RADIUS_M_MEAN / height;
        let y = self.cosine * sine - self.sine * cosine * turn_cosine;
        Some(Point { x: scale * cosine * libm::sin(turn_rad), y: scale * y })
    }

    /// Returns the position of a point: undoes [`Plane::project`].
    pub fn position(&self, point: Point) -> Position {
        let (x, y) = (point.x / EARTH_RADIUS_M_MEAN, point.y / EARTH_RADIUS_M_MEAN);
        let length = libm::sqrt(1.0 + x * x + y * y);
        let latitude_rad = libm::asin(((self.sine + y * self.cosine) / length).clamp(-1.0, 1.0));
        let turn_rad = libm::atan2(x, self.cosine - y * self.sine);
        Position {
            latitude_deg: latitude_rad / RAD_PER_DEG,
            longitude_deg: wrap_180(self.centre.longitude_deg + turn_rad / RAD_PER_DEG),
        }
    }

    /// Returns the largest factor by which lengths near `point` are stretched in the plane.
    pub fn stretch(&self, point: Point) -> f64 {
        let (x, y) = (point.x / EARTH_RADIUS_M_MEAN, point.y / EARTH_RADIUS_M_MEAN);
        1.0 + x * x + y * y
    }
}

/// Returns the distance from `point` to the segment `a`-`b`.
pub fn point_to_segment(point: Point, a: Point, b: Point) -> f64 {
    let along = b.minus(a);
    let squared = along.dot(along);
    let share = if squared > 0.0 { (point.minus(a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    point.minus(a.plus(share, along)).length()
}

/// Returns true if the segments `a`-`b` and `c`-`d` share a point.
pub fn segments_meet(a: Point, b: Point, c: Point, d: Point) -> bool {
    let side = |from: Point, to: Point, point: Point| to.minus(from).cross(point.minus(from));
    let (c_side, d_side) = (side(a, b, c), side(a, b, d));
    let (a_side, b_side) = (side(c, d, a), side(c, d, b));
    if ((c_side > 0.0) != (d_side > 0.0)) && ((a_side > 0.0) != (b_side > 0.0)) && c_side != d_side && a_side != b_side
    {
        return true;
    }
    let on = |zero: f64, point: Point, from: Point, to: Point| zero == 0.0 && point_to_segment(point, from, to) == 0.0;
    on(c_side, c, a, b) || on(d_side, d, a, b) || on(a_side, a, c, d) || on(b_side, b, c, d)
}

/// Returns the distance between two segments; 0 where they meet.
pub fn segment_to_segment(a: Point, b: Point, c: Point, d: Point) -> f64 {
    if segments_meet(a, b, c, d) {
        return 0.0;
    }
    let ends = point_to_segment(a, c, d).min(point_to_segment(b, c, d));
    ends.min(point_to_segment(c, a, b)).min(point_to_segment(d, a, b))
}

/// Returns the edges of a closed polygon given by its corners.
pub fn edges(corners: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    let next = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(next).map(|(a, b)| (*a, *b))
}

/// Returns true if `point` is inside the polygon. Points on the edge may be either. Fewer than three corners contain nothing.
pub fn inside(point: Point, corners: &[Point]) -> bool {
    if corners.len() < 3 {
        return false;
    }
    let crossings = edges(corners).filter(|(a, b)| {
        let spans = (a.y > point.y) != (b.y > point.y);
        spans && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
    });
    crossings.count() % 2 == 1
}

/// Returns the distance from the segment `a`-`b` to the nearest edge of the polygon; infinite for no corners.
pub fn segment_to_edges(a: Point, b: Point, corners: &[Point]) -> f64 {
    edges(corners).fold(f64::INFINITY, |least, (c, d)| least.min(segment_to_segment(a, b, c, d)))
}

/// Returns twice the signed area: positive where the corners run counter-clockwise.
pub fn doubled_area(corners: &[Point]) -> f64 {
    edges(corners).map(|(a, b)| a.cross(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square() -> Vec<Point> {
        [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)].map(|(x, y)| Point { x, y }).to_vec()
    }

    #[test]
    fn a_square_holds_its_middle() {
        assert!(inside(Point { x: 5.0, y: 5.0 }, &square()));
        assert!(!inside(Point { x: 15.0, y: 5.0 }, &square()));
        assert_eq!(doubled_area(&square()), 200.0);
    }

    #[test]
    fn segments_that_touch_meet() {
        let p = |x, y| Point { x, y };
        assert!(segments_meet(p(0.0, 0.0), p(10.0, 0.0), p(5.0, 0.0), p(5.0, 5.0)));
        assert!(segments_meet(p(0.0, 0.0), p(10.0, 10.0), p(0.0, 10.0), p(10.0, 0.0)));
        assert!(!segments_meet(p(0.0, 0.0), p(10.0, 0.0), p(11.0, 0.0), p(20.0, 0.0)), "in one line, apart");
        assert!(segments_meet(p(0.0, 0.0), p(10.0, 0.0), p(9.0, 0.0), p(20.0, 0.0)), "in one line, overlapping");
        assert_eq!(segment_to_segment(p(0.0, 0.0), p(10.0, 0.0), p(0.0, 3.0), p(10.0, 4.0)), 3.0);
    }

    proptest! {
        #[test]
        fn projection_is_undone(latitude in -80.0..80.0, longitude in -180.0..180.0, dx in -3e6..3e6, dy in -3e6..3e6) {
            let plane = Plane::new(Position::new(latitude, longitude));
            let position = plane.position(Point { x: dx, y: dy });
            let again = plane.project(position).unwrap();
            prop_assert!((again.x - dx).abs() < 1e-3 && (again.y - dy).abs() < 1e-3);
        }

        #[test]
        fn great_circles_are_nearly_straight(lat in 20.0..60.0f64, d in 1.0..9.0f64, turn in 0.0..360.0f64) {
            let (from, plane) = (Position::new(lat, 0.0), Plane::new(Position::new(lat, 3.0)));
            let to = crate::geodesy::destination(from, turn, d * 100_000.0);
            let middle = plane.project(crate::geodesy::midpoint(from, to)).unwrap();
            let (a, b) = (plane.project(from).unwrap(), plane.project(to).unwrap());
            prop_assert!(point_to_segment(middle, a, b) < 200.0, "{}", point_to_segment(middle, a, b));
        }
    }
}

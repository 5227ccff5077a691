//! A local equal-area plane: the sinusoidal projection of the ellipsoid around a centre, rotated.
//!
//! North is the length of the meridian from the centre's latitude, east the length along the parallel from the centre's meridian. Areas
//! are exact; directions are sheared by the convergence of meridians, 0.4 degrees at 50 km in middle latitudes. The axes are rotated by
//! an angle of irrational slope: no row of a grid is parallel to a track flown east to west or north to south, so that the edge of a
//! swath never crosses a whole row of cell centres at once.

use apex_geo::geodesy::{Position, RAD_PER_DEG, wrap_180};
pub use apex_geo::plane::Point;

const EQUATOR_RADIUS_M: f64 = 6_378_137.0;
/// Square of the first eccentricity of WGS84.
const E2: f64 = 6.694_379_990_141_316e-3;

/// Sine of the rotation: its slope is 1 / golden ratio squared, which spreads the rows most evenly.
const TURN_SINE: f64 = 0.356_822_089_773_090;
const TURN_COSINE: f64 = 0.934_172_358_962_715_7;

/// The projection around a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualAreaPlane {
    centre: Position,
    arc_m: f64,
}

impl EqualAreaPlane {
    /// Returns the plane around `centre`.
    pub fn new(centre: Position) -> EqualAreaPlane {
        EqualAreaPlane { centre, arc_m: meridian_arc_m(centre.latitude_deg * RAD_PER_DEG) }
    }

    /// Returns the centre.
    pub fn centre(&self) -> Position {
        self.centre
    }

    /// Returns the point at this distance east and north of the centre.
    pub fn point(&self, east_m: f64, north_m: f64) -> Point {
        Point { x: TURN_COSINE * east_m + TURN_SINE * north_m, y: TURN_COSINE * north_m - TURN_SINE * east_m }
    }

    /// Returns the east and north parts of a vector of the plane.
    pub fn east_north(&self, vector: Point) -> (f64, f64) {
        (TURN_COSINE * vector.x - TURN_SINE * vector.y, TURN_COSINE * vector.y + TURN_SINE * vector.x)
    }

    /// Returns the point of a position; not finite where the position is not.
    pub fn project(&self, position: Position) -> Point {
        let latitude_rad = position.latitude_deg * RAD_PER_DEG;
        let (sine, cosine) = (libm::sin(latitude_rad), libm::cos(latitude_rad));
        let normal_m = EQUATOR_RADIUS_M / libm::sqrt(1.0 - E2 * sine * sine);
        let turn_rad = wrap_180(position.longitude_deg - self.centre.longitude_deg) * RAD_PER_DEG;
        self.point(normal_m * cosine * turn_rad, arc_of(latitude_rad, sine, cosine) - self.arc_m)
    }

    /// Returns the position of a point: undoes [`EqualAreaPlane::project`].
    pub fn position(&self, point: Point) -> Position {
        let (east_m, north_m) = self.east_north(point);
        let wanted_m = self.arc_m + north_m;
        let mut latitude_rad = self.centre.latitude_deg * RAD_PER_DEG + north_m / EQUATOR_RADIUS_M;
        // Newton's method on the arc; each step squares an error of about 0.5 %.
        for _ in 0..3 {
            let sine = libm::sin(latitude_rad);
            let shape = 1.0 - E2 * sine * sine;
            let radius_m = EQUATOR_RADIUS_M * (1.0 - E2) / (shape * libm::sqrt(shape));
            latitude_rad += (wanted_m - meridian_arc_m(latitude_rad)) / radius_m;
        }
        let sine = libm::sin(latitude_rad);
        let parallel_m = EQUATOR_RADIUS_M / libm::sqrt(1.0 - E2 * sine * sine) * libm::cos(latitude_rad);
        Position {
            latitude_deg: latitude_rad / RAD_PER_DEG,
            longitude_deg: wrap_180(self.centre.longitude_deg + east_m / parallel_m / RAD_PER_DEG),
        }
    }

    /// Returns the positions of points with the same y, interpolated between the first and the last: exact within 25 m over 50 km.
    pub fn row_positions(&self, y: f64, x: &[f64]) -> impl Iterator<Item = Position> {
        let (first, last) = (x.first().copied().unwrap_or(0.0), x.last().copied().unwrap_or(0.0));
        let (from, to) = (self.position(Point { x: first, y }), self.position(Point { x: last, y }));
        let turn_deg = wrap_180(to.longitude_deg - from.longitude_deg);
        let span_m = last - first;
        x.iter().map(move |x| {
            let share = if span_m > 0.0 { (x - first) / span_m } else { 0.0 };
            Position {
                latitude_deg: from.latitude_deg + share * (to.latitude_deg - from.latitude_deg),
                longitude_deg: wrap_180(from.longitude_deg + share * turn_deg),
            }
        })
    }
}

fn meridian_arc_m(latitude_rad: f64) -> f64 {
    arc_of(latitude_rad, libm::sin(latitude_rad), libm::cos(latitude_rad))
}

/// Returns the length of the meridian from the equator (series in the eccentricity to its sixth power: 0.03 m).
fn arc_of(latitude_rad: f64, sine: f64, cosine: f64) -> f64 {
    const E4: f64 = E2 * E2;
    const E6: f64 = E4 * E2;
    let (sine2, cosine2) = (2.0 * sine * cosine, 1.0 - 2.0 * sine * sine);
    let sine4 = 2.0 * sine2 * cosine2;
    let sine6 = sine4 * cosine2 + (1.0 - 2.0 * sine2 * sine2) * sine2;
    EQUATOR_RADIUS_M
        * ((1.0 - E2 / 4.0 - 3.0 * E4 / 64.0 - 5.0 * E6 / 256.0) * latitude_rad
            - (3.0 * E2 / 8.0 + 3.0 * E4 / 32.0 + 45.0 * E6 / 1024.0) * sine2
            + (15.0 * E4 / 256.0 + 45.0 * E6 / 1024.0) * sine4
            - 35.0 * E6 / 3072.0 * sine6)
}

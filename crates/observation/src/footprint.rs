//! Intersection of sight lines with the ground: pixels, edges of scan lines, footprints of pictures, on flat ground and terrain.
//!
//! Flat ground is intersected directly. On terrain the ray is marched from the height of the highest ground in steps of a terrain cell,
//! and the crossing is bisected to less than 1 m. Lines of sight beyond an angle off the vertical are cut, so that no footprint becomes
//! infinite. Bound: [`MARCH_STEPS_MAX`] steps per ray.

use crate::attitude::{Attitude, Vector};
use apex_geo::geodesy::{Position, RAD_PER_DEG};
use std::sync::LazyLock;

/// Greatest angle off the vertical of a line of sight that counts.
pub const OFF_NADIR_DEG_MAX: f64 = 75.0;
/// Maximum number of steps of one ray: 30 m cells over 150 km.
pub const MARCH_STEPS_MAX: usize = 5_000;
/// Corners of the circle to which footprints near the horizon are cut.
const LIMIT_CORNERS: usize = 64;
const EQUATOR_RADIUS_M: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_141_316e-3;

/// The ground below a flight.
pub trait Ground {
    /// Returns the elevation above mean sea level; `None` if it is unknown.
    fn elevation_m_at(&self, position: Position) -> Option<f64>;
    /// Returns the least and greatest elevation anywhere; equal for flat ground.
    fn elevation_range_m(&self) -> (f64, f64);
    /// Returns the size of a terrain cell: the step of marching rays.
    fn cell_m(&self) -> f64;
}

/// Ground of one elevation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlatGround {
    /// Elevation above mean sea level.
    pub elevation_m: f64,
}

impl Ground for FlatGround {
    fn elevation_m_at(&self, _position: Position) -> Option<f64> {
        Some(self.elevation_m)
    }

    fn elevation_range_m(&self) -> (f64, f64) {
        (self.elevation_m, self.elevation_m)
    }

    fn cell_m(&self) -> f64 {
        f64::INFINITY
    }
}

/// The point where a line of sight meets the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundHit {
    /// Offset north of the vehicle.
    pub north_m: f64,
    /// Offset east of the vehicle.
    pub east_m: f64,
    /// Height of the vehicle above the point.
    pub height_m: f64,
    /// Length of the line of sight.
    pub slant_m: f64,
    /// Angle off the vertical at the vehicle.
    pub off_nadir_rad: f64,
}

impl GroundHit {
    fn along(ray: Vector, height_m: f64) -> GroundHit {
        let scale = height_m / ray.z;
        let level = libm::hypot(ray.x, ray.y);
        GroundHit {
            north_m: scale * ray.x,
            east_m: scale * ray.y,
            height_m,
            slant_m: scale * ray.length(),
            off_nadir_rad: libm::atan2(level, ray.z),
        }
    }
}

/// Returns the position at an offset from another; good to metres at 20 km.
pub fn offset_position(from: Position, north_m: f64, east_m: f64) -> Position {
    let latitude_rad = from.latitude_deg * RAD_PER_DEG;
    let sine = libm::sin(latitude_rad);
    let shape = 1.0 - ECCENTRICITY_SQUARED * sine * sine;
    let normal_m = EQUATOR_RADIUS_M / libm::sqrt(shape);
    let meridian_m = normal_m * (1.0 - ECCENTRICITY_SQUARED) / shape;
    let ahead_rad = latitude_rad + north_m / meridian_m;
    let drop_rad = 0.5 * east_m * east_m * libm::tan(latitude_rad) / (normal_m * meridian_m);
    Position {
        latitude_deg: (ahead_rad - drop_rad) / RAD_PER_DEG,
        longitude_deg: from.longitude_deg + east_m / (normal_m * libm::cos(ahead_rad)) / RAD_PER_DEG,
    }
}

/// Returns the point at which a ray (north, east, down) from a vehicle meets level ground `height_m` below it; `None` if the ray does not
/// descend or the vehicle is not above the ground.
pub fn hit_flat(ray: Vector, height_m: f64) -> Option<GroundHit> {
    (ray.z > 0.0 && height_m > 0.0).then(|| GroundHit::along(ray, height_m))
}

/// Returns the point at which a ray (north, east, down) from `position` at `altitude_m` first meets the ground. `fallback_m` is the
/// elevation where the terrain is unknown. `None` if the ray does not reach the ground within the limits of the march.
pub fn hit_terrain(
    ray: Vector,
    position: Position,
    altitude_m: f64,
    ground: &dyn Ground,
    fallback_m: f64,
) -> Option<GroundHit> {
    if ray.z.is_nan() || ray.z <= 0.0 {
        return None;
    }
    let (lowest_m, highest_m) = ground.elevation_range_m();
    if lowest_m == highest_m {
        return hit_flat(ray, altitude_m - lowest_m);
    }
    let elevation_m = |depth_m: f64| {
        let hit = GroundHit::along(ray, depth_m);
        ground.elevation_m_at(offset_position(position, hit.north_m, hit.east_m)).unwrap_or(fallback_m)
    };
    let is_below = |depth_m: f64| altitude_m - depth_m <= elevation_m(depth_m);
    // Depth below the vehicle per step: one terrain cell over ground, or a tenth of it straight down.
    let level = libm::hypot(ray.x, ray.y);
    let step_m = (ground.cell_m() * ray.z / level.max(0.1 * ray.z)).max(0.1);
    let mut above_m = (altitude_m - highest_m.max(fallback_m)).max(0.0);
    if is_below(above_m) {
        return (above_m > 0.0).then(|| GroundHit::along(ray, above_m));
    }
    for _ in 0..MARCH_STEPS_MAX {
        let mut below_m = above_m + step_m;
        if is_below(below_m) {
            while (below_m - above_m) * ray.length() / ray.z > 0.5 {
                let middle_m = 0.5 * (above_m + below_m);
                if is_below(middle_m) { below_m = middle_m } else { above_m = middle_m }
            }
            return Some(GroundHit::along(ray, 0.5 * (above_m + below_m)));
        }
        above_m = below_m;
    }
    None
}

/// Returns the ray of a scanner's pixel at a scan angle (positive to the right), in north-east-down axes.
pub fn scan_ray(attitude: &Attitude, scan_rad: f64) -> Vector {
    attitude.rotation().to_ground(scan_axis(scan_rad))
}

/// Returns the ray at a scan angle in body axes.
fn scan_axis(scan_rad: f64) -> Vector {
    Vector::new(0.0, libm::sin(scan_rad), libm::cos(scan_rad))
}

/// Bounds of scan lines in every attitude: computed once, because a flight has hundreds of thousands of lines.
#[derive(Clone, Copy)]
struct ScanLimits {
    /// Least down component of a ray of length 1.
    least_down: f64,
    /// Rays at right angles to the nadir and along it, in body axes.
    sideways: Vector,
    straight: Vector,
}

static SCAN_LIMITS: LazyLock<ScanLimits> = LazyLock::new(|| ScanLimits {
    least_down: libm::cos(OFF_NADIR_DEG_MAX * RAD_PER_DEG),
    sideways: scan_axis(0.5 * std::f64::consts::PI),
    straight: scan_axis(0.0),
});

/// Returns the left and right edge rays of a scan line, cut at [`OFF_NADIR_DEG_MAX`]; `None` if the whole line is beyond it.
pub fn scan_edges(attitude: &Attitude, half_field_rad: f64) -> Option<[Vector; 2]> {
    let rotation = attitude.rotation();
    let ray = |scan_rad: f64| rotation.to_ground(scan_axis(scan_rad));
    let ScanLimits { least_down, sideways, straight } = *SCAN_LIMITS;
    // Along the scan the down component is a cosine with its greatest value at the roll angle's opposite.
    let (across, down) = (rotation.to_ground(sideways).z, rotation.to_ground(straight).z);
    let (amplitude, middle_rad) = (libm::hypot(across, down), libm::atan2(across, down));
    if amplitude.is_nan() || amplitude <= least_down {
        return None;
    }
    let reach_rad = libm::acos((least_down / amplitude).min(1.0));
    let left_rad = (-half_field_rad).max(middle_rad - reach_rad);
    let right_rad = half_field_rad.min(middle_rad + reach_rad);
    (left_rad < right_rad).then(|| [ray(left_rad), ray(right_rad)])
}

/// Returns the corner rays of a picture, in order around it, cut at [`OFF_NADIR_DEG_MAX`]; empty if all of it is beyond.
///
/// `sight` turns the camera's axes (x along the view, y right, z down in the picture) into north-east-down.
/// The rays are scaled to a down component of 1: their x and y are offsets north and east at a height of 1.
pub fn picture_rays(
    sight: impl Fn(Vector) -> Vector,
    horizontal_field_rad: f64,
    vertical_field_rad: f64,
) -> Vec<Vector> {
    let (wide, high) = (libm::tan(0.5 * horizontal_field_rad), libm::tan(0.5 * vertical_field_rad));
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let rays: Vec<Vector> = corners.iter().map(|(u, v)| sight(Vector::new(1.0, u * wide, -v * high))).collect();
    // Below the horizon first, with a margin that keeps the projection finite; then the circle of the limit.
    let below = clip(&rays, |ray| ray.z - 1e-3 * ray.length());
    let flat: Vec<Vector> = below.iter().map(|ray| Vector::new(ray.x / ray.z, ray.y / ray.z, 1.0)).collect();
    let radius = libm::tan(OFF_NADIR_DEG_MAX * RAD_PER_DEG);
    let mut cut = flat;
    if cut.iter().all(|ray| libm::hypot(ray.x, ray.y) <= radius) {
        return cut;
    }
    for side in 0..LIMIT_CORNERS {
        let angle_rad = 2.0 * std::f64::consts::PI * side as f64 / LIMIT_CORNERS as f64;
        let (sine, cosine) = (libm::sin(angle_rad), libm::cos(angle_rad));
        cut = clip(&cut, |ray| radius - (ray.x * cosine + ray.y * sine));
    }
    cut
}

/// Returns the part of a polygon of rays where `side` is not negative (Sutherland and Hodgman).
fn clip(rays: &[Vector], side: impl Fn(&Vector) -> f64) -> Vec<Vector> {
    let mut kept = Vec::with_capacity(rays.len() + 1);
    let before = rays.iter().cycle().skip(rays.len().saturating_sub(1));
    for (from, to) in before.zip(rays) {
        let (from_side, to_side) = (side(from), side(to));
        if (from_side >= 0.0) != (to_side >= 0.0) {
            let share = from_side / (from_side - to_side);
            let along = to.plus(-1.0, *from);
            kept.push(from.plus(share, along));
        }
        if to_side >= 0.0 {
            kept.push(*to);
        }
    }
    kept
}

/// Returns the distance over the curved Earth to the point seen at a look angle from `height_m` above a sphere; `None` beyond the
/// horizon. `sin i = (Re + h) / Re sin o`, `ground arc = Re (i - o)`.
pub fn curved_ground_offset_m(height_m: f64, look_angle_rad: f64) -> Option<f64> {
    const RADIUS_M: f64 = apex_geo::geodesy::EARTH_RADIUS_M_MEAN;
    let sine = (RADIUS_M + height_m) / RADIUS_M * libm::sin(look_angle_rad);
    (sine.abs() <= 1.0).then(|| RADIUS_M * (libm::asin(sine) - look_angle_rad))
}

/// Returns true if higher ground hides a ground point from a vehicle. The line from the point to the vehicle is marched in steps
/// of a terrain cell up to the height of the highest ground; ground less than 1 m above the line does not hide it.
pub fn is_occluded(
    point: Position,
    point_elevation_m: f64,
    vehicle_north_m: f64,
    vehicle_east_m: f64,
    vehicle_altitude_m: f64,
    ground: &dyn Ground,
) -> bool {
    let (_, highest_m) = ground.elevation_range_m();
    let (rise_m, level_m) = (vehicle_altitude_m - point_elevation_m, libm::hypot(vehicle_north_m, vehicle_east_m));
    if rise_m.is_nan() || rise_m <= 0.0 || highest_m <= point_elevation_m || level_m <= ground.cell_m() {
        return false;
    }
    let steps = libm::ceil(level_m / ground.cell_m()).min(MARCH_STEPS_MAX as f64) as usize;
    let last = (highest_m - point_elevation_m) / rise_m;
    (1..steps).map(|step| step as f64 / steps as f64).take_while(|share| *share <= last).any(|share| {
        let there = offset_position(point, share * vehicle_north_m, share * vehicle_east_m);
        let line_m = point_elevation_m + share * rise_m;
        ground.elevation_m_at(there).is_some_and(|elevation_m| elevation_m > line_m + 1.0)
    })
}

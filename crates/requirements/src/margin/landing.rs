//! Distance to a landing place: within a fixed distance, by gliding, or under power.

/// Returns the margin in metres: the nearest landing place is within `distance_m_max`.
pub fn disc_m(distance_m: f64, distance_m_max: f64) -> f64 {
    distance_m_max - distance_m
}

/// Glide performance of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glide {
    /// Metres forward per metre of height in still air (lift over drag).
    pub ratio: f64,
    /// Airspeed along the glide path.
    pub airspeed_mps: f64,
}

/// Returns the distance over ground that a glide over `height_m` gives with `tail_wind_mps` (negative: head wind): with the sink
/// `V / sqrt(1 + ratio^2)` it lasts `height / sink`, at the speed `V ratio / sqrt(1 + ratio^2) + wind`. 0 if the wind is stronger.
pub fn glide_reach_m(glide: Glide, height_m: f64, tail_wind_mps: f64) -> f64 {
    let Glide { ratio, airspeed_mps } = glide;
    if !(ratio > 0.0 && airspeed_mps > 0.0) {
        return 0.0;
    }
    let slope = libm::sqrt(1.0 + ratio * ratio);
    let lasts_s = height_m.max(0.0) * slope / airspeed_mps;
    (lasts_s * (airspeed_mps * ratio / slope + tail_wind_mps)).max(0.0)
}

/// Returns the margin in metres: a glide from `height_m` above the landing place arrives `pattern_m` above it, `distance_m` away.
pub fn glide_m(glide: Glide, height_m: f64, pattern_m: f64, tail_wind_mps: f64, distance_m: f64) -> f64 {
    glide_reach_m(glide, height_m - pattern_m, tail_wind_mps) - distance_m
}

/// Returns the margin in metres: under power the landing place is reached within `allowed_s`.
pub fn powered_m(ground_speed_mps: f64, allowed_s: f64, distance_m: f64) -> f64 {
    ground_speed_mps.max(0.0) * allowed_s.max(0.0) - distance_m
}

//! Energy to the nearest usable landing place, with a reserve.

/// Returns the margin in the unit of `left` (kg of fuel, Wh, or seconds of endurance): the energy beyond the reserve after the flight of
/// `distance_m` home at `ground_speed_mps`, which consumes `per_s`. Negative infinity if the vehicle cannot approach home.
pub fn energy(left: f64, reserve: f64, per_s: f64, distance_m: f64, ground_speed_mps: f64) -> f64 {
    if distance_m <= 0.0 {
        return left - reserve;
    }
    if ground_speed_mps <= 0.0 {
        return f64::NEG_INFINITY;
    }
    left - reserve - per_s * distance_m / ground_speed_mps
}

/// Like [`energy`], in seconds of flight that consumes `per_s`.
pub fn energy_s(left: f64, reserve: f64, per_s: f64, distance_m: f64, ground_speed_mps: f64) -> f64 {
    energy(left / per_s, reserve / per_s, 1.0, distance_m, ground_speed_mps)
}

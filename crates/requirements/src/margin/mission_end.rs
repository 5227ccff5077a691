//! Time that is left at the end of the mission after the landing.

/// Returns the margin in seconds: the time that is left after the way home and the descent. Negative infinity without a way home.
pub fn mission_end(left_s: f64, way_home_s: Option<f64>, descent_s: f64) -> f64 {
    way_home_s.map_or(f64::NEG_INFINITY, |way_home_s| left_s - way_home_s - descent_s)
}

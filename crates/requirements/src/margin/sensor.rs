//! Sensors: the sun on an optic, and the temperature of a detector.

/// Sun lower than this, in degrees above the horizon, harms no sensor.
pub const SUN_INACTIVE_BELOW_DEG: f64 = -1.0;

/// A direction in degrees: azimuth clockwise from north, elevation above the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewDirection {
    /// Clockwise from north.
    pub azimuth_deg: f64,
    /// Above the horizon.
    pub elevation_deg: f64,
}

/// Returns the angle between two directions, in degrees, from 0 to 180.
pub fn angle_deg(a: ViewDirection, b: ViewDirection) -> f64 {
    let (low, high) = (a.elevation_deg.to_radians(), b.elevation_deg.to_radians());
    let turn_rad = (a.azimuth_deg - b.azimuth_deg).to_radians();
    // The haversine form is exact for small angles, where the cosine rule is not.
    let half = |angle_rad: f64| {
        let sine = libm::sin(0.5 * angle_rad);
        sine * sine
    };
    let share = half(high - low) + libm::cos(low) * libm::cos(high) * half(turn_rad);
    (2.0 * libm::asin(libm::sqrt(share.clamp(0.0, 1.0)))).to_degrees()
}

/// Returns the margin in degrees between the boresight and the sun: half of the field of view and `margin_deg` must stay free. Infinite
/// while the sun is below [`SUN_INACTIVE_BELOW_DEG`].
pub fn sun_deg(boresight: ViewDirection, sun: ViewDirection, field_of_view_deg: f64, margin_deg: f64) -> f64 {
    if sun.elevation_deg < SUN_INACTIVE_BELOW_DEG {
        return f64::INFINITY;
    }
    angle_deg(boresight, sun) - 0.5 * field_of_view_deg - margin_deg
}

/// Heat balance of a detector: a lumped capacity that loses heat to the air in proportion to the difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detector {
    /// Heat that it makes.
    pub power_w: f64,
    /// Conductance to the air.
    pub conductance_w_k: f64,
    /// Heat capacity.
    pub capacity_j_k: f64,
    /// Highest permitted temperature, degrees Celsius.
    pub limit_c: f64,
}

impl Detector {
    /// Returns the margin in kelvin.
    pub fn temperature_k(&self, temperature_c: f64) -> f64 {
        self.limit_c - temperature_c
    }

    /// Returns the seconds until the limit is reached in air of `air_c`, by `C dT/dt = P - G (T - air)`: 0 if it is reached, `None` if
    /// the equilibrium is at or below the limit.
    pub fn time_to_limit_s(&self, temperature_c: f64, air_c: f64) -> Option<f64> {
        if temperature_c >= self.limit_c {
            return Some(0.0);
        }
        let balance_c = air_c + self.power_w / self.conductance_w_k;
        if balance_c <= self.limit_c {
            return None;
        }
        let share = (balance_c - self.limit_c) / (balance_c - temperature_c);
        Some(-self.capacity_j_k / self.conductance_w_k * libm::log(share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sight(azimuth_deg: f64, elevation_deg: f64) -> ViewDirection {
        ViewDirection { azimuth_deg, elevation_deg }
    }

    #[test]
    fn angles_between_directions_are_those_of_the_sphere() {
        assert!((angle_deg(sight(0.0, 0.0), sight(90.0, 0.0)) - 90.0).abs() < 1e-9);
        assert!((angle_deg(sight(10.0, 0.0), sight(350.0, 0.0)) - 20.0).abs() < 1e-9);
        assert!((angle_deg(sight(0.0, -90.0), sight(123.0, 30.0)) - 120.0).abs() < 1e-9, "straight down");
        // Cosine rule: cos a = sin 40 sin 20 + cos 40 cos 20 cos 60 = 0.57979.
        assert!((angle_deg(sight(0.0, 40.0), sight(60.0, 20.0)) - 54.5655).abs() < 1e-3);
    }

    #[test]
    fn a_scanner_that_looks_down_meets_the_sun_in_a_steep_bank_only() {
        // Half a field of 43 degrees and 5 degrees of margin: the edge of the field is 47 degrees below the horizon in level flight.
        let level = sun_deg(sight(0.0, -90.0), sight(180.0, 0.0), 86.0, 5.0);
        assert!((level - 42.0).abs() < 1e-9, "{level}");
        assert!((sun_deg(sight(0.0, -90.0), sight(180.0, 25.0), 86.0, 5.0) - 67.0).abs() < 1e-9);
        assert_eq!(sun_deg(sight(0.0, 0.0), sight(0.0, -1.5), 20.0, 5.0), f64::INFINITY, "the sun has set");
    }

    #[test]
    fn a_detector_that_stays_cool_never_reaches_its_limit() {
        let detector = Detector { power_w: 40.0, conductance_w_k: 2.0, capacity_j_k: 3_000.0, limit_c: 45.0 };
        assert_eq!(detector.time_to_limit_s(30.0, 20.0), None, "it settles at 40 C");
        assert_eq!(detector.time_to_limit_s(46.0, 20.0), Some(0.0));
    }
}

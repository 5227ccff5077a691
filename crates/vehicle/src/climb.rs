//! Climbs: the rate falls with the altitude.

/// Share of the climb rate at sea level that is lost on the way to the ceiling.
const LOSS: f64 = 0.9;

/// The fastest climb of a vehicle: it falls linearly from that at sea level to a tenth at the ceiling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Climb {
    /// Rate at sea level and below it, m/s.
    pub rate_m_s_max: f64,
    /// Ceiling, m.
    pub ceiling_m: f64,
}

impl Climb {
    /// Returns the fastest climb at an altitude, m/s.
    pub fn rate_m_s(self, altitude_m: f64) -> f64 {
        self.rate_m_s_max * (1.0 - LOSS * (altitude_m / self.ceiling_m).clamp(0.0, 1.0))
    }

    /// Returns the shortest time of a climb between two altitudes, s; 0 for a descent.
    pub fn time_s(self, from_m: f64, to_m: f64) -> f64 {
        if to_m <= from_m {
            return 0.0;
        }
        let below_m = to_m.min(0.0) - from_m.min(0.0);
        let above_m = to_m.max(self.ceiling_m) - from_m.max(self.ceiling_m);
        let slower = libm::log(self.rate_m_s(from_m) / self.rate_m_s(to_m)) / LOSS;
        (below_m + self.ceiling_m * slower) / self.rate_m_s_max + above_m / self.rate_m_s(self.ceiling_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_climb_takes_the_time_of_its_steps() {
        let climb = Climb { rate_m_s_max: 8.0, ceiling_m: 15_240.0 };
        for (from_m, to_m) in [(-100.0, 0.0), (-50.0, 3_000.0), (10_000.0, 14_478.0), (14_000.0, 16_000.0)] {
            let count = 100_000;
            let step_m = (to_m - from_m) / f64::from(count);
            let steps_s = (0..count).map(|number| step_m / climb.rate_m_s(from_m + (f64::from(number) + 0.5) * step_m));
            let summed_s: f64 = steps_s.sum();
            let found_s = climb.time_s(from_m, to_m);
            assert!((found_s / summed_s - 1.0).abs() < 1e-6, "{from_m} to {to_m} m: {found_s} instead of {summed_s} s");
        }
        // By hand: 15,240 / 7.2 * ln(3.2756 / 1.1600).
        assert!((climb.time_s(10_000.0, 14_478.0) - 2_197.3).abs() < 1.0);
        assert_eq!(climb.time_s(5_000.0, 4_000.0), 0.0);
    }
}

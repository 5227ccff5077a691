//! Distances between two points as benchmark files define them.

/// The radius of the Earth and the value of pi that TSPLIB prescribes.
const EARTH_RADIUS_KM: f64 = 6378.388;
#[expect(clippy::approx_constant, reason = "with another the distances would be others")]
const PI: f64 = 3.141592;

/// A rule for the distance between two points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Metric {
    /// Straight-line distance, rounded to the nearest whole number.
    Euclidean,
    /// Straight-line distance, rounded up.
    EuclideanUp,
    /// The Euclidean distance truncated to this number of decimals: Solomon 1, Cordeau 2.
    EuclideanCut(u8),
    /// Along the axes.
    Manhattan,
    /// The longer of the two axes.
    Maximum,
    /// TSPLIB's pseudo-Euclidean distance of the ATT problems.
    Att,
    /// On the sphere, from degrees and minutes written as DDD.MM.
    Geographical,
}

impl Metric {
    /// Returns the metric that TSPLIB calls `name`.
    pub(super) fn of(name: &str) -> Option<Metric> {
        Some(match name {
            "EUC_2D" => Metric::Euclidean,
            "CEIL_2D" => Metric::EuclideanUp,
            "MAN_2D" => Metric::Manhattan,
            "MAX_2D" => Metric::Maximum,
            "ATT" => Metric::Att,
            "GEO" => Metric::Geographical,
            _ => return None,
        })
    }

    /// Returns the distance of two points.
    pub(super) fn between(self, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> f64 {
        let (dx, dy) = ((x1 - x0).abs(), (y1 - y0).abs());
        let straight = || libm::sqrt(dx * dx + dy * dy);
        match self {
            Metric::Euclidean => nearest(straight()),
            Metric::EuclideanUp => libm::ceil(straight()),
            Metric::EuclideanCut(decimals) => cut(straight(), decimals),
            Metric::Manhattan => nearest(dx + dy),
            Metric::Maximum => nearest(dx).max(nearest(dy)),
            Metric::Att => {
                let real = libm::sqrt((dx * dx + dy * dy) / 10.0);
                let whole = nearest(real);
                if whole < real { whole + 1.0 } else { whole }
            }
            Metric::Geographical => geographical((x0, y0), (x1, y1)),
        }
    }
}

fn nearest(number: f64) -> f64 {
    libm::floor(number + 0.5)
}

/// Returns the length truncated to `decimals` decimals. A length that is below a whole number of units only by rounding errors counts as
/// that number.
fn cut(length: f64, decimals: u8) -> f64 {
    let scale = (0..decimals).fold(1.0, |scale, _| 10.0 * scale);
    libm::floor(length * scale + 1e-9) / scale
}

/// Returns TSPLIB's geographical distance: the whole part of a coordinate is degrees, the rest minutes.
fn geographical((x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> f64 {
    let radians = |coordinate: f64| {
        let degrees = libm::trunc(coordinate);
        PI * (degrees + 5.0 * (coordinate - degrees) / 3.0) / 180.0
    };
    let q1 = libm::cos(radians(y0) - radians(y1));
    let q2 = libm::cos(radians(x0) - radians(x1));
    let q3 = libm::cos(radians(x0) + radians(x1));
    let cosine = (0.5 * ((1.0 + q1) * q2 - (1.0 - q1) * q3)).clamp(-1.0, 1.0);
    libm::floor(EARTH_RADIUS_KM * libm::acos(cosine) + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_metric_rounds_as_its_library_says() {
        let (a, b) = ((0.0, 0.0), (3.0, 3.0));
        let all = ["EUC_2D", "CEIL_2D", "MAN_2D", "MAX_2D", "ATT"].map(|name| Metric::of(name).unwrap().between(a, b));
        assert_eq!(all, [4.0, 5.0, 6.0, 3.0, 2.0], "the straight line is 4.2426");
        assert_eq!(Metric::EuclideanCut(1).between(a, b), 4.2);
        assert_eq!(Metric::EuclideanCut(2).between(a, b), 4.24);
        assert_eq!(Metric::EuclideanCut(1).between((0.0, 0.0), (0.3, 0.4)), 0.5, "a whole unit is not cut");
        assert_eq!(Metric::of("XRAY1"), None);
    }

    #[test]
    fn geographical_distances_are_minutes_of_a_sphere() {
        // A degree of latitude on the prescribed sphere is 111.32 km; the rule adds 1 and cuts.
        assert_eq!(Metric::Geographical.between((10.0, 20.0), (11.0, 20.0)), 112.0);
        // Half a degree is written as .30.
        assert_eq!(Metric::Geographical.between((10.0, 20.0), (10.30, 20.0)), 56.0);
        assert_eq!(Metric::Geographical.between((10.0, 20.0), (10.0, 20.0)), 1.0, "so says the rule");
    }
}

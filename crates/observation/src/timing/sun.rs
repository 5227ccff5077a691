//! Position of the sun, and glint.
//!
//! Low-precision formulas of the NOAA solar calculator after J. Meeus, "Astronomical Algorithms", chapter 25: within 0.01
//! degrees for 1950 to 2050.

use apex_geo::geodesy::{Position, RAD_PER_DEG, wrap_180, wrap_360};

const J2000_UNIX_S: f64 = 946_728_000.0;
const DAYS_PER_CENTURY: f64 = 36_525.0;

/// Position of the sun in the sky of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolarPosition {
    /// Elevation of the sun's centre without refraction, by which light needs are evaluated.
    pub elevation_deg: f64,
    /// Elevation as seen through the standard atmosphere.
    pub apparent_elevation_deg: f64,
    /// Azimuth clockwise from north, 0..360.
    pub azimuth_deg: f64,
}

/// Direction of the sun from the centre of the Earth, in Earth-fixed axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunDirection {
    sine_declination: f64,
    cosine_declination: f64,
    /// Longitude at which the sun culminates.
    subsolar_longitude_deg: f64,
}

impl SunDirection {
    /// Returns the direction at an instant.
    pub fn at(unix_s: f64) -> SunDirection {
        let century = (unix_s - J2000_UNIX_S) / 86_400.0 / DAYS_PER_CENTURY;
        let mean_longitude_deg = wrap_360(280.466_46 + century * (36_000.769_83 + century * 0.000_303_2));
        let anomaly_rad = wrap_360(357.529_11 + century * (35_999.050_29 - 0.000_153_7 * century)) * RAD_PER_DEG;
        let eccentricity = 0.016_708_634 - century * (0.000_042_037 + 0.000_000_126_7 * century);
        let centre_deg = libm::sin(anomaly_rad) * (1.914_602 - century * (0.004_817 + 0.000_014 * century))
            + libm::sin(2.0 * anomaly_rad) * (0.019_993 - 0.000_101 * century)
            + libm::sin(3.0 * anomaly_rad) * 0.000_289;
        let node_rad = (125.04 - 1_934.136 * century) * RAD_PER_DEG;
        let longitude_rad = (mean_longitude_deg + centre_deg - 0.005_69 - 0.004_78 * libm::sin(node_rad)) * RAD_PER_DEG;
        let seconds = 21.448 - century * (46.815 + century * (0.000_59 - century * 0.001_813));
        let obliquity_rad = (23.0 + (26.0 + seconds / 60.0) / 60.0 + 0.002_56 * libm::cos(node_rad)) * RAD_PER_DEG;
        let sine_declination = libm::sin(obliquity_rad) * libm::sin(longitude_rad);
        let tangent = libm::tan(0.5 * obliquity_rad);
        let (half, mean_rad) = (tangent * tangent, mean_longitude_deg * RAD_PER_DEG);
        let equation_rad = half * libm::sin(2.0 * mean_rad) - 2.0 * eccentricity * libm::sin(anomaly_rad)
            + 4.0 * eccentricity * half * libm::sin(anomaly_rad) * libm::cos(2.0 * mean_rad)
            - 0.5 * half * half * libm::sin(4.0 * mean_rad)
            - 1.25 * eccentricity * eccentricity * libm::sin(2.0 * anomaly_rad);
        let solar_deg = libm::fmod(unix_s, 86_400.0) / 240.0 + equation_rad / RAD_PER_DEG;
        SunDirection {
            sine_declination,
            cosine_declination: libm::sqrt((1.0 - sine_declination * sine_declination).max(0.0)),
            subsolar_longitude_deg: wrap_180(180.0 - solar_deg),
        }
    }

    /// Returns the direction as a function of time between two instants less than a day apart, interpolating declination and subsolar
    /// longitude linearly: over 6 hours the error is below 0.001 degrees.
    pub fn track(from_unix_s: f64, until_unix_s: f64) -> impl Fn(f64) -> SunDirection {
        let (first, last) = (SunDirection::at(from_unix_s), SunDirection::at(until_unix_s));
        let span_s = until_unix_s - from_unix_s;
        // The Earth turns west to east: the subsolar longitude falls by about 15 degrees an hour.
        let turned_deg = last.subsolar_longitude_deg - first.subsolar_longitude_deg;
        let turn_deg = wrap_180(turned_deg + span_s / 240.0) - span_s / 240.0;
        move |unix_s: f64| {
            let share = if span_s > 0.0 { (unix_s - from_unix_s) / span_s } else { 0.0 };
            let between = |a: f64, b: f64| a + share * (b - a);
            SunDirection {
                sine_declination: between(first.sine_declination, last.sine_declination),
                cosine_declination: between(first.cosine_declination, last.cosine_declination),
                subsolar_longitude_deg: first.subsolar_longitude_deg + share * turn_deg,
            }
        }
    }

    /// Returns the unit vector in Earth-fixed axes: towards (0, 0), towards (0, 90 E), to the north pole.
    pub fn unit(&self) -> [f64; 3] {
        let longitude_rad = self.subsolar_longitude_deg * RAD_PER_DEG;
        [
            self.cosine_declination * libm::cos(longitude_rad),
            self.cosine_declination * libm::sin(longitude_rad),
            self.sine_declination,
        ]
    }

    /// Returns the sine of the elevation at a place.
    pub fn sine_elevation(&self, position: Position) -> f64 {
        let hour_rad = (position.longitude_deg - self.subsolar_longitude_deg) * RAD_PER_DEG;
        let latitude_rad = position.latitude_deg * RAD_PER_DEG;
        libm::sin(latitude_rad) * self.sine_declination
            + libm::cos(latitude_rad) * self.cosine_declination * libm::cos(hour_rad)
    }

    /// Returns the elevation without refraction at a place.
    pub fn elevation_deg(&self, position: Position) -> f64 {
        libm::asin(self.sine_elevation(position).clamp(-1.0, 1.0)) / RAD_PER_DEG
    }

    /// Returns the azimuth clockwise from north at a place.
    pub fn azimuth_deg(&self, position: Position) -> f64 {
        let hour_rad = (position.longitude_deg - self.subsolar_longitude_deg) * RAD_PER_DEG;
        let latitude_rad = position.latitude_deg * RAD_PER_DEG;
        let east = -self.cosine_declination * libm::sin(hour_rad);
        let north = libm::cos(latitude_rad) * self.sine_declination
            - libm::sin(latitude_rad) * self.cosine_declination * libm::cos(hour_rad);
        wrap_360(libm::atan2(east, north) / RAD_PER_DEG)
    }
}

/// Returns the position of the sun in the sky of a place at an instant (seconds of Unix time).
pub fn solar_position(position: Position, unix_s: f64) -> SolarPosition {
    let sun = SunDirection::at(unix_s);
    let elevation_deg = sun.elevation_deg(position);
    SolarPosition {
        elevation_deg,
        apparent_elevation_deg: elevation_deg + refraction_deg(elevation_deg),
        azimuth_deg: sun.azimuth_deg(position),
    }
}

/// Returns the refraction of the standard atmosphere at an elevation, as in the NOAA solar calculator.
pub fn refraction_deg(elevation_deg: f64) -> f64 {
    let tangent = libm::tan(elevation_deg * RAD_PER_DEG);
    let seconds = if elevation_deg > 85.0 {
        0.0
    } else if elevation_deg > 5.0 {
        let cubed = tangent * tangent * tangent;
        58.1 / tangent - 0.07 / cubed + 0.000_086 / (cubed * tangent * tangent)
    } else if elevation_deg > -0.575 {
        let e = elevation_deg;
        1_735.0 + e * (-518.2 + e * (103.4 + e * (-12.79 + e * 0.711)))
    } else {
        -20.772 / tangent
    };
    seconds / 3_600.0
}

/// Returns the angle between a line of sight to flat water and the mirrored ray of the sun, in degrees: 0 sees the mirror image.
///
/// `sun_zenith_deg` and `view_zenith_deg` are off the vertical at the point; `azimuth_difference_deg` is the azimuth of the
/// vehicle as seen from the point minus that of the sun.
pub fn glint_angle_deg(sun_zenith_deg: f64, view_zenith_deg: f64, azimuth_difference_deg: f64) -> f64 {
    let (sun_rad, view_rad) = (sun_zenith_deg * RAD_PER_DEG, view_zenith_deg * RAD_PER_DEG);
    let cosine = libm::cos(sun_rad) * libm::cos(view_rad)
        - libm::sin(sun_rad) * libm::sin(view_rad) * libm::cos(azimuth_difference_deg * RAD_PER_DEG);
    libm::acos(cosine.clamp(-1.0, 1.0)) / RAD_PER_DEG
}

/// Returns the weight of a look over water by its glint angle: 0 below 20 degrees, rising to 1 at 30 (assumption).
pub fn glint_weight(glint_angle_deg: f64) -> f64 {
    ((glint_angle_deg - 20.0) / 10.0).clamp(0.0, 1.0)
}

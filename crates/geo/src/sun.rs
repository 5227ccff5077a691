//! The sun: elevation above the horizon and windows of day and night.
//!
//! Low-precision solar position (mean longitude and anomaly with the equation of the centre): within 0.05 degrees for
//! 1950..2050. Bound: windows scan in steps of [`SCAN_STEP_S`], at most [`SCAN_STEPS_MAX`] of them.

use crate::geodesy::{Position, RAD_PER_DEG, wrap_180, wrap_360};
use apex_model::problem::{Light, TimeWindow};

/// Elevation of the sun's middle at sunrise: refraction and half a disc.
pub const SUNRISE_ELEVATION_DEG: f64 = -0.833;
/// Elevation at the beginning of civil night.
pub const NIGHT_ELEVATION_DEG: f64 = -6.0;
/// Step of the search for changes of light.
pub const SCAN_STEP_S: f64 = 600.0;
/// Maximum number of steps of one search: thirty days.
pub const SCAN_STEPS_MAX: usize = 4_320;

const J2000_UNIX_S: f64 = 946_728_000.0;

/// Returns the hour angle of the sun at a place, its declination, and the latitude, rad.
fn hour_declination_latitude_rad(position: Position, unix_s: f64) -> (f64, f64, f64) {
    let days = (unix_s - J2000_UNIX_S) / 86_400.0;
    let anomaly_rad = wrap_360(357.529 + 0.985_600_28 * days) * RAD_PER_DEG;
    let mean_deg = wrap_360(280.459 + 0.985_647_36 * days);
    let longitude_rad =
        (mean_deg + 1.915 * libm::sin(anomaly_rad) + 0.020 * libm::sin(2.0 * anomaly_rad)) * RAD_PER_DEG;
    let tilt_rad = (23.439 - 0.000_000_36 * days) * RAD_PER_DEG;
    let ascension_rad = libm::atan2(libm::cos(tilt_rad) * libm::sin(longitude_rad), libm::cos(longitude_rad));
    let declination_rad = libm::asin(libm::sin(tilt_rad) * libm::sin(longitude_rad));
    let sidereal_deg = wrap_360(280.460_618_37 + 360.985_647_366_29 * days);
    let hour_rad = wrap_180(sidereal_deg + position.longitude_deg - ascension_rad / RAD_PER_DEG) * RAD_PER_DEG;
    (hour_rad, declination_rad, position.latitude_deg * RAD_PER_DEG)
}

/// Returns the elevation of the middle of the sun above the horizon, without refraction.
pub fn solar_elevation_deg(position: Position, unix_s: f64) -> f64 {
    let (hour_rad, declination_rad, latitude_rad) = hour_declination_latitude_rad(position, unix_s);
    let sine = libm::sin(latitude_rad) * libm::sin(declination_rad)
        + libm::cos(latitude_rad) * libm::cos(declination_rad) * libm::cos(hour_rad);
    libm::asin(sine.clamp(-1.0, 1.0)) / RAD_PER_DEG
}

/// Returns the azimuth of the sun, clockwise from true north, 0..360.
pub fn solar_azimuth_deg(position: Position, unix_s: f64) -> f64 {
    let (hour_rad, declination_rad, latitude_rad) = hour_declination_latitude_rad(position, unix_s);
    let east = -libm::cos(declination_rad) * libm::sin(hour_rad);
    let north = libm::cos(latitude_rad) * libm::sin(declination_rad)
        - libm::sin(latitude_rad) * libm::cos(declination_rad) * libm::cos(hour_rad);
    wrap_360(libm::atan2(east, north) / RAD_PER_DEG)
}

/// Returns true if the light is as required.
pub fn is_light(light: Light, position: Position, unix_s: f64) -> bool {
    match light {
        Light::Any => true,
        Light::Day => solar_elevation_deg(position, unix_s) >= SUNRISE_ELEVATION_DEG,
        Light::Night => solar_elevation_deg(position, unix_s) <= NIGHT_ELEVATION_DEG,
    }
}

/// Returns the intervals within `[from_s, until_s]` with `light` at `position`, to the second. Times are seconds since `zero_unix_s`.
/// Intervals shorter than [`SCAN_STEP_S`] may be missed.
pub fn light_windows(light: Light, position: Position, zero_unix_s: f64, from_s: f64, until_s: f64) -> Vec<TimeWindow> {
    if light == Light::Any {
        return vec![TimeWindow { from_s, until_s }];
    }
    let lit = |time_s: f64| is_light(light, position, zero_unix_s + time_s);
    let mut windows = Vec::new();
    let mut open_since_s = lit(from_s).then_some(from_s);
    let mut time_s = from_s;
    for _ in 0..SCAN_STEPS_MAX {
        if time_s.is_nan() || time_s >= until_s {
            break;
        }
        let next_s = (time_s + SCAN_STEP_S).min(until_s);
        if lit(next_s) != open_since_s.is_some() {
            let change_s = change_between(&lit, time_s, next_s);
            match open_since_s.take() {
                // The change is the first second of the new light; the window ends before it.
                Some(since_s) => windows.push(TimeWindow { from_s: since_s, until_s: change_s - 1.0 }),
                None => open_since_s = Some(change_s),
            }
        }
        time_s = next_s;
    }
    if let Some(since_s) = open_since_s {
        windows.push(TimeWindow { from_s: since_s, until_s: time_s });
    }
    windows
}

/// Returns the instant in `(low_s, high_s]` at which `lit` has just changed, to a second.
fn change_between(lit: &impl Fn(f64) -> bool, mut low_s: f64, mut high_s: f64) -> f64 {
    let before = lit(low_s);
    while high_s - low_s > 1.0 {
        let middle_s = 0.5 * (low_s + high_s);
        if lit(middle_s) == before { low_s = middle_s } else { high_s = middle_s }
    }
    high_s
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDWARDS: Position = Position::new(34.905, -117.884);
    /// 2007-09-08T00:00:00Z.
    const SEPTEMBER_UNIX_S: f64 = 1_189_209_600.0;

    #[test]
    fn noon_at_the_equinox_is_overhead_at_the_equator() {
        // 2026-03-20T12:07:30Z: local apparent noon at longitude 0 near the equinox.
        let elevation = solar_elevation_deg(Position::new(0.0, 0.0), 1_774_008_450.0);
        assert!(elevation > 89.5, "{elevation}");
        let pole = solar_elevation_deg(Position::new(90.0, 0.0), 1_774_008_450.0);
        assert!(pole.abs() < 0.3, "{pole}");
    }

    /// By hand: at sunset the cosine of the azimuth is the sine of the declination over the cosine of the latitude.
    #[test]
    fn the_sun_sets_a_little_north_of_west_in_early_september() {
        let sunset = solar_azimuth_deg(EDWARDS, SEPTEMBER_UNIX_S + 7_794.0);
        assert!((sunset - 277.2).abs() < 0.8, "{sunset}");
        let noon = solar_azimuth_deg(EDWARDS, SEPTEMBER_UNIX_S - 15_000.0);
        assert!((noon - 180.0).abs() < 5.0, "{noon}");
    }

    #[test]
    fn edwards_has_sunset_at_the_computed_hour_angle() {
        // By hand: declination 5.9 deg, hour angle of sunset 95.16 deg, equation of time +2.2 min: sunset at 02:09.9 UTC,
        // sunrise at 13:29.
        let day = light_windows(Light::Day, EDWARDS, SEPTEMBER_UNIX_S, 0.0, 86_400.0);
        assert_eq!(day.len(), 2, "{day:?}");
        assert!((day[0].until_s - 7_794.0).abs() < 60.0, "{day:?}");
        assert!((day[1].from_s - 48_540.0).abs() < 60.0, "{day:?}");
        let night = light_windows(Light::Night, EDWARDS, SEPTEMBER_UNIX_S, 0.0, 86_400.0);
        assert_eq!(night.len(), 1, "{night:?}");
        assert!(night[0].from_s > day[0].until_s + 1200.0 && night[0].until_s < day[1].from_s - 1200.0);
    }

    #[test]
    fn windows_hold_what_they_promise() {
        for window in light_windows(Light::Day, EDWARDS, SEPTEMBER_UNIX_S, 0.0, 3.0 * 86_400.0) {
            assert!(is_light(Light::Day, EDWARDS, SEPTEMBER_UNIX_S + window.from_s));
            assert!(is_light(Light::Day, EDWARDS, SEPTEMBER_UNIX_S + window.until_s - 1.0));
        }
        assert!(light_windows(Light::Day, EDWARDS, f64::NAN, 0.0, 86_400.0).is_empty());
    }
}

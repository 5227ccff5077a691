//! Passes of satellites over a place, by SGP4.
//!
//! The element set gives the position in TEME; rotation by Greenwich mean sidereal time gives Earth-fixed axes. A pass is a minimum of
//! the slant range above the horizon. Source: D. Vallado et al., "Revisiting Spacetrack Report #3", AIAA 2006-6753; constants WGS72,
//! which element sets assume. Bound: O(span / 20 s) propagations, at most [`SCAN_STEPS_MAX`].

use apex_geo::geodesy::{Position, RAD_PER_DEG};
use std::fmt;

/// Step of the search for passes.
pub const SCAN_STEP_S: f64 = 20.0;
/// Maximum number of steps of one search: thirty days.
pub const SCAN_STEPS_MAX: usize = 129_600;
/// Half the scan angle of MODIS at the satellite.
pub const MODIS_HALF_SCAN_DEG: f64 = 55.0;
/// Half the scan angle of VIIRS at the satellite. The first VIIRS was launched on 28 October 2011.
pub const VIIRS_HALF_SCAN_DEG: f64 = 56.28;

const J2000_UNIX_S: f64 = 946_728_000.0;
const EQUATOR_RADIUS_KM: f64 = 6_378.137;
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_141_316e-3;

/// A satellite with its orbit.
pub struct Satellite {
    constants: sgp4::Constants,
    epoch_unix_s: f64,
}

impl fmt::Debug for Satellite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Satellite").field("epoch_unix_s", &self.epoch_unix_s).finish_non_exhaustive()
    }
}

/// Conditions for a pass to count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassLimits {
    /// Half the scan angle of the instrument, measured at the satellite from the nadir.
    pub half_scan_deg: f64,
    /// Greatest wanted angle from the nadir at the satellite, which limits the pixel size; 45 is usual.
    pub nadir_angle_deg_max: f64,
}

impl Default for PassLimits {
    fn default() -> PassLimits {
        PassLimits { half_scan_deg: MODIS_HALF_SCAN_DEG, nadir_angle_deg_max: 45.0 }
    }
}

/// A pass: the instant of the least slant range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// Instant, seconds since the start of the mission.
    pub time_s: f64,
    /// Angle at the satellite between the middle of the Earth and the place.
    pub nadir_angle_deg: f64,
    /// Elevation of the satellite at the place.
    pub elevation_deg: f64,
    /// Slant range between satellite and place.
    pub range_km: f64,
}

/// An element set that cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitError {
    /// Error message of the reader of element sets.
    pub reason: String,
}

impl fmt::Display for OrbitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot use the orbital elements: {}", self.reason)
    }
}

impl std::error::Error for OrbitError {}

impl Satellite {
    /// Returns the satellite of a two-line element set.
    ///
    /// # Errors
    /// [`OrbitError`] if a line cannot be read or describes no orbit.
    pub fn from_tle(line1: &str, line2: &str) -> Result<Satellite, OrbitError> {
        let wrong = |reason: String| OrbitError { reason };
        let elements = sgp4::Elements::from_tle(None, line1.trim_end().as_bytes(), line2.trim_end().as_bytes())
            .map_err(|error| wrong(error.to_string()))?;
        Satellite::of(&elements)
    }

    /// Returns the satellite of an orbit mean-elements message (CCSDS 502.0-B) as a JSON object, with the keywords as its members.
    ///
    /// # Errors
    /// [`OrbitError`] if a keyword is missing or wrong, or describes no orbit.
    pub fn from_omm(message: &serde_json::Value) -> Result<Satellite, OrbitError> {
        let elements: sgp4::Elements =
            serde_json::from_value(message.clone()).map_err(|error| OrbitError { reason: error.to_string() })?;
        Satellite::of(&elements)
    }

    fn of(elements: &sgp4::Elements) -> Result<Satellite, OrbitError> {
        let wrong = |reason: String| OrbitError { reason };
        let constants = sgp4::Constants::from_elements_afspc_compatibility_mode(elements)
            .map_err(|error| wrong(error.to_string()))?;
        let epoch = elements.datetime.and_utc();
        let epoch_unix_s = epoch.timestamp() as f64 + f64::from(epoch.timestamp_subsec_nanos()) * 1e-9;
        Ok(Satellite { constants, epoch_unix_s })
    }

    /// Returns the days from the epoch of the elements to an instant, negative before it. The error of a prediction grows by about a
    /// kilometre per day.
    pub fn age_days(&self, unix_s: f64) -> f64 {
        (unix_s - self.epoch_unix_s) / 86_400.0
    }

    /// Returns the position in true-equator, mean-equinox axes in km; `None` after the orbit has decayed.
    pub fn position_teme_km(&self, unix_s: f64) -> Option<[f64; 3]> {
        let minutes = sgp4::MinutesSinceEpoch((unix_s - self.epoch_unix_s) / 60.0);
        self.constants.propagate_afspc_compatibility_mode(minutes).ok().map(|prediction| prediction.position)
    }

    /// Returns the position in Earth-fixed axes in km.
    fn position_fixed_km(&self, unix_s: f64) -> Option<[f64; 3]> {
        let [x, y, z] = self.position_teme_km(unix_s)?;
        let angle_rad = sidereal_rad(unix_s);
        let (sine, cosine) = (libm::sin(angle_rad), libm::cos(angle_rad));
        Some([cosine * x + sine * y, cosine * y - sine * x, z])
    }
}

/// Returns Greenwich mean sidereal time (model of 1982). UTC replaces UT1, which differs by at most 0.9 s.
fn sidereal_rad(unix_s: f64) -> f64 {
    let century = (unix_s - J2000_UNIX_S) / 86_400.0 / 36_525.0;
    let seconds = 67_310.548_41 + (876_600.0 * 3_600.0 + 8_640_184.812_866) * century + 0.093_104 * century * century
        - 6.2e-6 * century * century * century;
    libm::fmod(seconds, 86_400.0) / 240.0 * RAD_PER_DEG
}

/// A place in Earth-fixed axes with its vertical.
struct Site {
    at_km: [f64; 3],
    up: [f64; 3],
}

impl Site {
    fn new(position: Position) -> Site {
        let (latitude_rad, longitude_rad) = (position.latitude_deg * RAD_PER_DEG, position.longitude_deg * RAD_PER_DEG);
        let (sine, cosine) = (libm::sin(latitude_rad), libm::cos(latitude_rad));
        let up = [cosine * libm::cos(longitude_rad), cosine * libm::sin(longitude_rad), sine];
        let normal_km = EQUATOR_RADIUS_KM / libm::sqrt(1.0 - ECCENTRICITY_SQUARED * sine * sine);
        let [x, y, z] = up;
        Site { at_km: [normal_km * x, normal_km * y, normal_km * (1.0 - ECCENTRICITY_SQUARED) * z], up }
    }

    /// Returns range, elevation, and the angle at the satellite between the centre of the Earth and the site.
    fn look(&self, satellite: &Satellite, unix_s: f64) -> Option<Pass> {
        let from_km = satellite.position_fixed_km(unix_s)?;
        let ([sx, sy, sz], [px, py, pz]) = (self.at_km, from_km);
        let down_km = [sx - px, sy - py, sz - pz];
        let range_km = libm::sqrt(dot(down_km, down_km));
        let radius_km = libm::sqrt(dot(from_km, from_km));
        let nadir = -dot(from_km, down_km) / (radius_km * range_km);
        let elevation = -dot(self.up, down_km) / range_km;
        Some(Pass {
            time_s: unix_s,
            nadir_angle_deg: libm::acos(nadir.clamp(-1.0, 1.0)) / RAD_PER_DEG,
            elevation_deg: libm::asin(elevation.clamp(-1.0, 1.0)) / RAD_PER_DEG,
            range_km,
        })
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Returns all passes above the horizon between `from_s` and `until_s`, by a scan in steps of 20 s and a golden-section search to 0.1 s.
/// Passes outside the instrument's swath are included; [`PassLimits::sees`] distinguishes them. A search ends after thirty days, or when
/// the orbit has decayed.
pub fn passes(satellite: &Satellite, place: Position, zero_unix_s: f64, from_s: f64, until_s: f64) -> Vec<Pass> {
    let site = Site::new(place);
    let look = |time_s: f64| site.look(satellite, zero_unix_s + time_s);
    let mut found = Vec::new();
    let (mut before, mut here): (Option<Pass>, Option<Pass>) = (None, None);
    for step in 0..SCAN_STEPS_MAX {
        let time_s = from_s + step as f64 * SCAN_STEP_S;
        // One step beyond the end, so that a least range just before the end is found.
        if time_s.is_nan() || time_s > until_s + SCAN_STEP_S {
            break;
        }
        let Some(next) = look(time_s) else { break };
        if let (Some(first), Some(middle)) = (before, here)
            && first.range_km >= middle.range_km
            && middle.range_km < next.range_km
            && middle.elevation_deg > 0.0
            && let Some(pass) = nearest(&look, time_s - 2.0 * SCAN_STEP_S, time_s)
            && pass.time_s <= until_s
        {
            found.push(pass);
        }
        (before, here) = (here, Some(next));
    }
    found
}

/// Returns the least range between two instants by golden-section search to 0.1 s.
fn nearest(look: &impl Fn(f64) -> Option<Pass>, low_s: f64, high_s: f64) -> Option<Pass> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let range_km = |time_s: f64| look(time_s).map_or(f64::INFINITY, |pass| pass.range_km);
    let (mut low_s, mut high_s) = (low_s, high_s);
    let mut left_s = high_s - GOLDEN * (high_s - low_s);
    let mut right_s = low_s + GOLDEN * (high_s - low_s);
    let (mut left_km, mut right_km) = (range_km(left_s), range_km(right_s));
    while high_s - low_s > 0.1 {
        if left_km < right_km {
            (high_s, right_s, right_km) = (right_s, left_s, left_km);
            left_s = high_s - GOLDEN * (high_s - low_s);
            left_km = range_km(left_s);
        } else {
            (low_s, left_s, left_km) = (left_s, right_s, right_km);
            right_s = low_s + GOLDEN * (high_s - low_s);
            right_km = range_km(right_s);
        }
    }
    let time_s = 0.5 * (low_s + high_s);
    look(time_s).map(|pass| Pass { time_s, ..pass })
}

impl PassLimits {
    /// Returns true if the instrument sees the place in this pass within the limit of the nadir angle.
    pub fn sees(&self, pass: &Pass) -> bool {
        pass.nadir_angle_deg <= self.half_scan_deg.min(self.nadir_angle_deg_max)
    }
}

/// Returns half the width of the swath on the ground in km, and the incidence at its edge in degrees, for a satellite at `height_km`
/// that scans `half_scan_deg` to either side; `None` if the edge misses the Earth.
pub fn half_swath_km(height_km: f64, half_scan_deg: f64) -> Option<(f64, f64)> {
    const MEAN_RADIUS_KM: f64 = 6_371.0;
    let scan_rad = half_scan_deg * RAD_PER_DEG;
    let sine = (MEAN_RADIUS_KM + height_km) / MEAN_RADIUS_KM * libm::sin(scan_rad);
    if !(0.0..=1.0).contains(&sine) {
        return None;
    }
    let incidence_rad = libm::asin(sine);
    Some((MEAN_RADIUS_KM * (incidence_rad - scan_rad), incidence_rad / RAD_PER_DEG))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: (&str, &str) = (
        "1 99902U 07001B   07250.00000000  .00000000  00000-0  20000-4 0    11",
        "2 99902  98.2000 188.2001 0001000  90.0000 120.0000 14.57100000    12",
    );

    /// Both formats describe the same orbit, so the passes are equal.
    #[test]
    fn orbit_messages_are_the_same_orbits() {
        let message = serde_json::json!({
            "OBJECT_NAME": "AQUA", "OBJECT_ID": "2007-001B", "CENTER_NAME": "EARTH", "REF_FRAME": "TEME", "TIME_SYSTEM": "UTC",
            "MEAN_ELEMENT_THEORY": "SGP4", "EPOCH": "2007-09-07T00:00:00", "MEAN_MOTION": 14.571, "ECCENTRICITY": 0.0001,
            "INCLINATION": 98.2, "RA_OF_ASC_NODE": 188.2001, "ARG_OF_PERICENTER": 90.0, "MEAN_ANOMALY": 120.0,
            "EPHEMERIS_TYPE": 0, "CLASSIFICATION_TYPE": "U", "NORAD_CAT_ID": 99902, "ELEMENT_SET_NO": 1, "REV_AT_EPOCH": 1,
            "BSTAR": 0.00002, "MEAN_MOTION_DOT": 0.0, "MEAN_MOTION_DDOT": 0.0
        });
        let from_message = Satellite::from_omm(&message).unwrap();
        let from_lines = Satellite::from_tle(LINES.0, LINES.1).unwrap();
        let zaca = Position::new(34.716, -119.783);
        let passes_of = |satellite: &Satellite| passes(satellite, zaca, 1_189_209_600.0, 3_600.0, 75_600.0);
        let (some, others) = (passes_of(&from_message), passes_of(&from_lines));
        assert_eq!(some.len(), others.len());
        for (one, other) in some.iter().zip(&others) {
            assert!(
                (one.time_s - other.time_s).abs() < 0.01 && (one.nadir_angle_deg - other.nadir_angle_deg).abs() < 0.001
            );
        }
        assert!((from_message.age_days(1_189_209_600.0) - 1.0).abs() < 1e-9);
        let mut short = message.clone();
        short.as_object_mut().unwrap().remove("INCLINATION");
        assert!(Satellite::from_omm(&short).unwrap_err().reason.contains("INCLINATION"));
    }
}

//! The needs of a target by which looks of one cell in one pass differ, other than pixels and clarity: angle off the vertical and time.

use crate::target::{ObservedTarget, WantedLook};
use crate::timing::sun::solar_position;
use crate::timing::{LightNeed, windows_factor};
use apex_geo::geodesy::{Position, RAD_PER_DEG};

/// Two looks within this time, s, count as simultaneous: neighbouring strips of a scanner.
const AT_ONCE_S: f64 = 1.0;
/// Looks further apart than this, s, are both kept, whatever their factors: other targets may depend on their instants.
const APART_S: f64 = 60.0;

/// The needs of one target.
#[derive(Clone, Copy, Debug)]
pub struct LookNeeds<'a> {
    /// The target.
    pub target: &'a ObservedTarget,
    /// Its middle, where the sun is computed.
    pub centre: Position,
    /// Start of the mission, seconds of Unix time.
    pub zero_unix_s: f64,
}

impl LookNeeds<'_> {
    /// Returns true if a look of a cell is worth at least as much as another one for every wanted look, judged by angle and, as flown, by
    /// time. A look is the cosine of its angle off the vertical, and its instant in seconds. Predicted looks of one pass succeed or fail
    /// together, so only their angles differ.
    pub fn covers(&self, kept: (f32, f64), other: (f32, f64), is_flown: bool) -> bool {
        let apart_s = (kept.1 - other.1).abs();
        let wanted = &self.target.looks;
        if is_flown && apart_s > AT_ONCE_S {
            if apart_s > APART_S || wanted.iter().any(|look| look.latency.is_some()) {
                return false;
            }
            return wanted.iter().all(|look| {
                angle(look, kept.0) * self.timing(look, kept.1) >= angle(look, other.0) * self.timing(look, other.1)
            });
        }
        wanted.iter().all(|look| angle(look, kept.0) >= angle(look, other.0))
    }

    /// Returns the factor of an instant, except for order, interval and latency.
    fn timing(&self, look: &WantedLook, time_s: f64) -> f64 {
        let light = match look.light {
            LightNeed::Any => 1.0,
            need => need.factor(solar_position(self.centre, self.zero_unix_s + time_s).elevation_deg),
        };
        let slope = look.slope.as_ref().map_or(1.0, |slope| slope.factor(time_s));
        let overpass = look.overpass.as_ref().map_or(1.0, |need| need.factor(time_s));
        windows_factor(&look.windows, time_s) * light * slope * overpass
    }
}

/// Returns the factor of the angle off the vertical with this cosine.
fn angle(wanted: &WantedLook, cosine: f32) -> f64 {
    let off_nadir_deg = || libm::acos(f64::from(cosine).min(1.0)) / RAD_PER_DEG;
    wanted.look_angles.map_or(1.0, |angles| angles.factor(off_nadir_deg()))
}

//! Wind: queries of a wind field, the wind triangle, and leg times through wind.
//!
//! Bound: a query is O(layers); a leg is O(sub-steps x layers) with at most [`LEG_STEPS_MAX`] sub-steps.

use crate::direction::{ARC_RAD_MAX, Direction};
use crate::geodesy::{self, Position, RAD_PER_DEG, wrap_360};
use apex_model::problem::TimeWindow;
pub use apex_model::problem::{WindField, WindLayer};

/// Wind at one place, altitude and time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wind {
    /// Air moves east at this speed.
    pub east_mps: f64,
    /// Air moves north at this speed.
    pub north_mps: f64,
    /// Turbulence: cube root of the eddy dissipation rate (EDR), m^(2/3)/s.
    pub edr: f64,
}

/// Ground speed and heading of a flight along a track through wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindTriangle {
    /// Speed over ground along the track.
    pub ground_speed_mps: f64,
    /// Direction of the nose, clockwise from north, 0..360.
    pub heading_deg: f64,
}

/// Maximum number of sub-steps of one leg: with [`LEG_STEP_M`], legs up to 5,000 km are divided finely and longer ones more coarsely.
pub const LEG_STEPS_MAX: usize = 200;
/// Length of a sub-step: wind layers are far wider.
pub const LEG_STEP_M: f64 = 25_000.0;
/// Slower progress over ground than this counts as not flyable.
pub const GROUND_SPEED_MPS_MIN: f64 = 1.0;

/// Returns the strongest wind of a field.
pub fn speed_mps_max(field: &WindField) -> f64 {
    let speeds = field.layers.iter().map(|layer| libm::hypot(layer.wind_east_mps, layer.wind_north_mps));
    speeds.fold(0.0, f64::max)
}

/// Returns the wind at a place, altitude (above mean sea level) and time. Later layers have precedence over earlier ones; the air is
/// still where no layer applies. With `blend`, wind is interpolated between the centres of the applicable layers.
pub fn at(field: &WindField, position: Position, altitude_m: f64, time_s: f64) -> Wind {
    let here = |layer: &&WindLayer| {
        let window = TimeWindow { from_s: layer.from_s, until_s: layer.until_s };
        window.contains(time_s) && layer.area.is_none_or(|area| area.contains(position))
    };
    if field.blend {
        return blended(field.layers.iter().filter(here), altitude_m);
    }
    let holds = |layer: &&WindLayer| layer.altitude_m_min <= altitude_m && altitude_m < layer.altitude_m_max;
    field.layers.iter().rev().filter(here).find(holds).map(wind_of).unwrap_or_default()
}

fn wind_of(layer: &WindLayer) -> Wind {
    Wind { east_mps: layer.wind_east_mps, north_mps: layer.wind_north_mps, edr: layer.edr }
}

/// Interpolates between the middles of the nearest layers below and above; the outermost layers apply beyond their middles.
fn blended<'a>(layers: impl Iterator<Item = &'a WindLayer>, altitude_m: f64) -> Wind {
    let middle_m = |layer: &WindLayer| 0.5 * (layer.altitude_m_min + layer.altitude_m_max);
    let (mut below, mut above): (Option<&WindLayer>, Option<&WindLayer>) = (None, None);
    for layer in layers {
        let middle = middle_m(layer);
        if middle <= altitude_m {
            if below.is_none_or(|best| middle_m(best) <= middle) {
                below = Some(layer);
            }
        } else if above.is_none_or(|best| middle <= middle_m(best)) {
            above = Some(layer);
        }
    }
    match (below, above) {
        (Some(low), Some(high)) => {
            let share = (altitude_m - middle_m(low)) / (middle_m(high) - middle_m(low));
            let (low, high) = (wind_of(low), wind_of(high));
            Wind {
                east_mps: low.east_mps + share * (high.east_mps - low.east_mps),
                north_mps: low.north_mps + share * (high.north_mps - low.north_mps),
                edr: low.edr + share * (high.edr - low.edr),
            }
        }
        (Some(only), None) | (None, Some(only)) => wind_of(only),
        (None, None) => Wind::default(),
    }
}

/// Returns the ground speed and heading for flying `track_deg` at `true_airspeed_mps`; `None` if the wind is too strong to hold the track
/// or to make progress along it.
pub fn triangle(track_deg: f64, true_airspeed_mps: f64, wind: Wind) -> Option<WindTriangle> {
    let track_rad = track_deg * RAD_PER_DEG;
    let (sine, cosine) = (libm::sin(track_rad), libm::cos(track_rad));
    let ground_speed_mps = ground_speed_mps((sine, cosine), true_airspeed_mps, wind)?;
    let from_left_mps = wind.east_mps * cosine - wind.north_mps * sine;
    let forward_mps = libm::sqrt(true_airspeed_mps * true_airspeed_mps - from_left_mps * from_left_mps);
    let heading_deg = wrap_360(track_deg - libm::atan2(from_left_mps, forward_mps) / RAD_PER_DEG);
    Some(WindTriangle { ground_speed_mps, heading_deg })
}

/// Returns the ground speed along a track of unit length; `None` as for [`triangle`].
pub(crate) fn ground_speed_mps((east, north): (f64, f64), true_airspeed_mps: f64, wind: Wind) -> Option<f64> {
    let tail_mps = wind.east_mps * east + wind.north_mps * north;
    let from_left_mps = wind.east_mps * north - wind.north_mps * east;
    let squared = true_airspeed_mps * true_airspeed_mps - from_left_mps * from_left_mps;
    if !(true_airspeed_mps > 0.0 && squared > 0.0) {
        return None;
    }
    let speed_mps = libm::sqrt(squared) + tail_mps;
    (speed_mps >= GROUND_SPEED_MPS_MIN).then_some(speed_mps)
}

/// A leg divided into sub-steps.
#[derive(Clone, Debug, PartialEq)]
struct LegProfile {
    step_m: f64,
    steps: Vec<LegStep>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct LegStep {
    middle: Direction,
    /// East and north parts of the track.
    track: (f64, f64),
}

impl LegProfile {
    /// Returns the geodesic from `from` to `to`; `None` if a position is not finite.
    fn new(from: Position, to: Position) -> Option<LegProfile> {
        let (distance_m, azimuth_deg) = geodesy::inverse(from, to);
        if !distance_m.is_finite() {
            return None;
        }
        let count = if distance_m == 0.0 { 0 } else { ((distance_m / LEG_STEP_M) as usize + 1).min(LEG_STEPS_MAX) };
        let step_m = distance_m / count.max(1) as f64;
        let (start, end) = (Direction::of(from), Direction::of(to));
        let angle_rad = start.angle_rad(end);
        let quarter = start.quarter_turn_to(end).filter(|_| angle_rad <= ARC_RAD_MAX);
        let step = |index: usize| {
            let share = (index as f64 + 0.5) / count as f64;
            if let Some(quarter) = quarter {
                // The arc is close enough to the geodesic for the wind, at a tenth of the work.
                let (sine, cosine) = (libm::sin(share * angle_rad), libm::cos(share * angle_rad));
                let middle = start.blended(cosine, quarter, sine);
                let (east, north) = middle.east_north(start.blended(-sine, quarter, cosine));
                let length = libm::hypot(east, north);
                return LegStep { middle, track: (east / length, north / length) };
            }
            let middle = geodesy::destination(from, azimuth_deg, share * distance_m);
            let track_rad = geodesy::azimuth_deg(middle, to) * RAD_PER_DEG;
            LegStep { middle: Direction::of(middle), track: (libm::sin(track_rad), libm::cos(track_rad)) }
        };
        Some(LegProfile { step_m, steps: (0..count).map(step).collect() })
    }

    /// Returns the distance over ground.
    fn length_m(&self) -> f64 {
        self.step_m * self.steps.len() as f64
    }

    /// Returns the time to fly the leg, leaving at `start_s`, by the midpoint rule; `None` if some part cannot be flown.
    fn time_s(&self, altitude_m: f64, true_airspeed_mps: f64, field: &WindField, start_s: f64) -> Option<f64> {
        if true_airspeed_mps.is_nan() || true_airspeed_mps <= 0.0 {
            return None;
        }
        if field.layers.is_empty() {
            return Some(self.length_m() / true_airspeed_mps);
        }
        self.time_through_s(self.middles(), true_airspeed_mps, start_s, |position, at_s| {
            at(field, position, altitude_m, at_s)
        })
    }

    /// Returns the middle of each sub-step.
    fn middles(&self) -> impl Iterator<Item = Position> {
        self.steps.iter().map(|step| step.middle.position())
    }

    /// Like [`LegProfile::time_s`], through the wind that a function of place and time states; `middles` as of [`LegProfile::middles`].
    fn time_through_s(
        &self,
        middles: impl Iterator<Item = Position>,
        true_airspeed_mps: f64,
        start_s: f64,
        wind: impl Fn(Position, f64) -> Wind,
    ) -> Option<f64> {
        let still_s = self.step_m / true_airspeed_mps;
        self.steps.iter().zip(middles).try_fold(0.0, |elapsed_s, (step, middle)| {
            let wind = wind(middle, start_s + elapsed_s + 0.5 * still_s);
            let speed_mps = ground_speed_mps(step.track, true_airspeed_mps, wind)?;
            Some(elapsed_s + self.step_m / speed_mps)
        })
    }
}

/// Returns the time to fly the geodesic from `from` to `to` through the field, leaving at `start_s`: integrated in sub-steps by the
/// midpoint rule. `None` if some part cannot be flown (or an argument is not finite).
pub fn leg_time_s(
    from: Position,
    to: Position,
    altitude_m: f64,
    true_airspeed_mps: f64,
    field: &WindField,
    start_s: f64,
) -> Option<f64> {
    LegProfile::new(from, to)?.time_s(altitude_m, true_airspeed_mps, field, start_s)
}

/// Wind as a function of the place and the time in seconds.
pub type WindAt<'a> = &'a dyn Fn(Position, f64) -> Wind;

/// Like [`leg_time_s`], through each of several winds.
pub fn leg_times_s<const N: usize>(
    from: Position,
    to: Position,
    true_airspeed_mps: f64,
    start_s: f64,
    winds: [WindAt<'_>; N],
) -> [Option<f64>; N] {
    let profile = LegProfile::new(from, to).filter(|_| true_airspeed_mps > 0.0);
    let middles: Vec<Position> = profile.iter().flat_map(LegProfile::middles).collect();
    winds.map(|wind| profile.as_ref()?.time_through_s(middles.iter().copied(), true_airspeed_mps, start_s, wind))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::FOREVER_S;

    fn layer(low: f64, high: f64, east: f64, north: f64) -> WindLayer {
        WindLayer {
            area: None,
            altitude_m_min: low,
            altitude_m_max: high,
            from_s: 0.0,
            until_s: FOREVER_S,
            wind_east_mps: east,
            wind_north_mps: north,
            edr: 0.2,
        }
    }

    #[test]
    fn head_tail_and_cross_wind() {
        let west_wind = Wind { east_mps: 30.0, north_mps: 0.0, edr: 0.0 };
        let east = triangle(90.0, 50.0, west_wind).unwrap();
        assert!((east.ground_speed_mps - 80.0).abs() < 1e-9 && (east.heading_deg - 90.0).abs() < 1e-9);
        let north = triangle(0.0, 50.0, west_wind).unwrap();
        assert!((north.ground_speed_mps - 40.0).abs() < 1e-9);
        assert!((north.heading_deg - 323.130_102).abs() < 1e-5, "the nose points into the wind: {north:?}");
        assert_eq!(triangle(270.0, 30.5, west_wind), None);
        assert_eq!(triangle(0.0, 29.0, west_wind), None);
        assert_eq!(triangle(0.0, f64::NAN, west_wind), None);
    }

    #[test]
    fn later_layers_win_and_outside_is_still() {
        let field =
            WindField { layers: vec![layer(0.0, 9000.0, 5.0, 0.0), layer(6000.0, 8000.0, 20.0, 1.0)], blend: false };
        let here = Position::new(40.0, -120.0);
        assert_eq!(at(&field, here, 7000.0, 1.0).east_mps, 20.0);
        assert_eq!(at(&field, here, 1000.0, 1.0).east_mps, 5.0);
        assert_eq!(at(&field, here, 9000.0, 1.0), Wind::default());
        assert_eq!(at(&field, here, 1000.0, -1.0), Wind::default());
    }

    #[test]
    fn blending_is_linear_between_middles() {
        let field =
            WindField { layers: vec![layer(0.0, 2000.0, 0.0, 0.0), layer(2000.0, 4000.0, 10.0, 4.0)], blend: true };
        let here = Position::new(40.0, -120.0);
        assert_eq!(at(&field, here, 2000.0, 0.0).east_mps, 5.0);
        assert_eq!(at(&field, here, 500.0, 0.0).east_mps, 0.0);
        assert_eq!(at(&field, here, 9500.0, 0.0).east_mps, 10.0);
    }

    #[test]
    fn wind_makes_the_way_back_longer_than_the_way_out() {
        let field = WindField { layers: vec![layer(0.0, 9000.0, 25.0, 0.0)], blend: false };
        let (west, east) = (Position::new(40.0, -120.0), Position::new(40.0, -110.0));
        let out = leg_time_s(west, east, 7000.0, 95.0, &field, 0.0).unwrap();
        let back = leg_time_s(east, west, 7000.0, 95.0, &field, 0.0).unwrap();
        let still = leg_time_s(west, east, 7000.0, 95.0, &WindField::default(), 0.0).unwrap();
        assert!(out < still && still < back);
        assert!((still - geodesy::distance_m(west, east) / 95.0).abs() < 1e-9);
        assert_eq!(leg_time_s(east, west, 7000.0, 20.0, &field, 0.0), None);
    }

    #[test]
    fn wind_that_turns_off_is_noticed_on_the_way() {
        let mut gust = layer(0.0, 9000.0, -40.0, 0.0);
        gust.until_s = 3600.0;
        let field = WindField { layers: vec![gust], blend: false };
        let (west, east) = (Position::new(40.0, -120.0), Position::new(40.0, -110.0));
        let now = leg_time_s(west, east, 7000.0, 95.0, &field, 0.0).unwrap();
        let later = leg_time_s(west, east, 7000.0, 95.0, &field, 3600.0).unwrap();
        assert!(now > later + 1000.0);
    }
}

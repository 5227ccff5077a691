//! Altitudes at which the forecast keeps the requirements `turbulence` and `wind` over a target, as the flight judges them: on lines at
//! other altitudes it would climb or descend, and lose their resolution and coverage.
//!
//! Bound: O(altitudes x points x times x layers), with altitudes [`STEP_M`] apart and [`AZIMUTHS`] + 1 points.

use super::wish::Wish;
use apex_geo::{geodesy, wind};
use apex_model::problem::Position;

/// Distance of the altitudes that are examined, m.
const STEP_M: f64 = 50.0;
/// Height by which an aircraft may leave its altitude, m.
const LEVEL_M: f64 = 10.0;
/// Number of points around the target that are examined in addition to its middle.
const AZIMUTHS: u32 = 8;

/// Bands of altitudes that keep the limits.
pub(super) struct CalmBands {
    /// Lowest and highest altitude of each, rising, above mean sea level.
    bands: Vec<(f64, f64)>,
}

/// A limit that the forecast exceeds: name of the requirement, unit, forecast and limit.
type Exceeded = (&'static str, &'static str, f64, f64);

impl CalmBands {
    /// Returns the bands between two altitudes: those that keep the limits for the rest of the mission, or, if there is none, those that
    /// keep them at the time of the wish. `None` if the mission states no limit.
    ///
    /// # Errors
    /// If no altitude keeps the limits: the requirement, its limit, and the forecast at the best altitude.
    pub(super) fn between(wish: &Wish<'_>, (low_m, high_m): (f64, f64)) -> Result<Option<CalmBands>, String> {
        let requirements = &wish.mission.requirements;
        if requirements.edr_max.is_none() && requirements.wind_mps_max.is_none() {
            return Ok(None);
        }
        let points = points(wish);
        let bands = |times_s: &[f64]| bands((low_m, high_m), |altitude_m| worst(wish, &points, altitude_m, times_s));
        let always = bands(&times_s(wish));
        let found = if always.is_err() { bands(&[wish.from_s]) } else { always };
        found.map(|bands| Some(CalmBands { bands })).map_err(|(name, unit, forecast, limit)| {
            format!(
                "requirement {name} permits at most {limit} {unit}, and the forecast has at least {forecast:.2} {unit} at all altitudes \
                 from {low_m:.0} m to {high_m:.0} m"
            )
        })
    }

    /// Returns the altitudes where the limits begin and cease to be kept.
    pub(super) fn ends_m(&self) -> impl Iterator<Item = f64> + '_ {
        self.bands.iter().flat_map(|(low_m, high_m)| [*low_m, *high_m])
    }

    /// True if the limits are kept at the altitude.
    pub(super) fn contain(&self, altitude_m: f64) -> bool {
        self.bands.iter().any(|(low_m, high_m)| (*low_m..=*high_m).contains(&altitude_m))
    }
}

/// Returns the middle of the target and points around it.
fn points(wish: &Wish<'_>) -> Vec<Position> {
    let (middle, radius_m) = (wish.target.position, wish.fire.radius_m);
    let around = (0..AZIMUTHS)
        .map(|number| geodesy::destination(middle, 360.0 * f64::from(number) / f64::from(AZIMUTHS), radius_m));
    std::iter::once(middle).chain(around).collect()
}

/// Returns the instants at which the forecast changes, from the time of the wish until the end of the mission.
fn times_s(wish: &Wish<'_>) -> Vec<f64> {
    let end_s = wish.mission.settings.duration.seconds();
    let changes = wish.mission.forecast.layers.iter().flat_map(|layer| [layer.from_s, layer.until_s]);
    let mut times_s: Vec<f64> = changes.filter(|at_s| *at_s > wish.from_s && *at_s < end_s).collect();
    times_s.push(wish.from_s);
    times_s.sort_by(f64::total_cmp);
    times_s.dedup();
    times_s
}

/// Returns a limit that is exceeded at an altitude or [`LEVEL_M`] off it; `None` if both limits are kept.
fn worst(wish: &Wish<'_>, points: &[Position], altitude_m: f64, times_s: &[f64]) -> Option<Exceeded> {
    let (requirements, field) = (&wish.mission.requirements, &wish.mission.forecast);
    let all = times_s.iter().flat_map(|time_s| points.iter().map(move |point| (*point, *time_s)));
    let (mut edr, mut wind_mps) = (0.0_f64, 0.0_f64);
    for (point, time_s) in all {
        for off_m in [-LEVEL_M, LEVEL_M] {
            let there = wind::at(field, point, altitude_m + off_m, time_s);
            edr = edr.max(there.edr);
            wind_mps = wind_mps.max(libm::hypot(there.east_mps, there.north_mps));
        }
    }
    let exceeded = |forecast: f64, limit: Option<f64>| limit.filter(|limit| forecast > *limit);
    let rough = exceeded(edr, requirements.edr_max).map(|limit| ("turbulence", "m^(2/3)/s", edr, limit));
    rough.or_else(|| exceeded(wind_mps, requirements.wind_mps_max).map(|limit| ("wind", "m/s", wind_mps, limit)))
}

/// Returns the bands of altitudes for which `worst` returns `None`, without their edges.
///
/// # Errors
/// If there is none: the limit that is exceeded least.
fn bands((low_m, high_m): (f64, f64), worst: impl Fn(f64) -> Option<Exceeded>) -> Result<Vec<(f64, f64)>, Exceeded> {
    let count = libm::floor((high_m - low_m).max(0.0) / STEP_M) as usize;
    let altitudes = (0..=count).map(|step| low_m + STEP_M * step as f64).chain([high_m]);
    let mut bands = Vec::new();
    let (mut open, mut least): (Option<(f64, f64)>, Option<Exceeded>) = (None, None);
    for altitude_m in altitudes {
        match worst(altitude_m) {
            None => open = Some((open.map_or(altitude_m, |(from_m, _)| from_m), altitude_m)),
            Some(exceeded) => {
                bands.extend(open.take());
                let over = |(_, _, forecast, limit): &Exceeded| forecast / limit;
                if least.is_none_or(|least| over(&exceeded) < over(&least)) {
                    least = Some(exceeded);
                }
            }
        }
    }
    bands.extend(open);
    match least.filter(|_| bands.is_empty()) {
        Some(least) => Err(least),
        None => Ok(bands),
    }
}

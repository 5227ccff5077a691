//! Wanted looks of a fire: value, light, time, resolution and order (docs/reference/mission-data.md).

use crate::error::MissionResult;
use crate::features::NamedFeature;
use apex_geo::terrain::Terrain;
use apex_model::problem::Position;
use apex_observation::target::{
    IntervalNeed, LookAngles, MustTerm, OrderNeed, PixelMeasure, ResolutionNeed, WANTED_LOOKS_MAX, WantedLook,
};
use apex_observation::timing::passes::{PassLimits, Satellite, passes};
use apex_observation::timing::{LatencyNeed, LightNeed, OverpassNeed, ValueSlope, WindowNeed};
use std::sync::Arc;

const SECONDS_PER_HOUR: f64 = 3600.0;
const SECONDS_PER_MINUTE: f64 = 60.0;
/// Width of the ramp of look angles where the mission states none.
const LOOK_ANGLE_RAMP_DEG: f64 = 10.0;

/// Properties of an entry of `looks`; the fire's own properties are the defaults.
pub(crate) const LOOK_PROPERTIES: &[&str] = &[
    "id",
    "value",
    "resolution_m",
    "resolution_zero_multiple",
    "resolution_measure",
    "share",
    "windows_h",
    "window_ramp_min",
    "light",
    "sun_deg_min",
    "sun_deg_max",
    "light_ramp_deg",
    "falls",
    "falls_from_h",
    "falls_over_h",
    "overpass",
    "latency_min",
    "look_angle_deg",
    "look_angle_ramp_deg",
    "interval_h",
    "interval_ramp_min",
    "must",
    "must_factor_min",
    "must_cost",
    "may_share",
];

/// Data of a mission on which looks depend.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms<'t> {
    /// Its duration, s.
    pub(crate) duration_s: f64,
    /// Civil time of its beginning, s since 1970-01-01T00:00Z.
    pub(crate) epoch_unix_s: Option<f64>,
    /// Money that one point represents.
    pub(crate) money_per_point: f64,
    /// The terrain, if the mission has one.
    pub(crate) terrain: Option<&'t Arc<Terrain>>,
}

/// Returns the looks of a feature: those of `looks`, or the one that its own properties describe.
///
/// # Errors
/// Errors as listed in docs/reference/mission-data.md, each with file, feature and property.
pub(super) fn read(feature: &NamedFeature, place: Position, terms: Terms<'_>) -> MissionResult<Vec<WantedLook>> {
    let parts = feature.parts("looks", LOOK_PROPERTIES)?;
    if parts.len() > WANTED_LOOKS_MAX {
        return Err(feature
            .trouble(format!("`looks` holds {} looks; it may hold {WANTED_LOOKS_MAX}", parts.len()))
            .help("make a separate target of the further ones"));
    }
    if parts.is_empty() {
        return Ok(vec![look(feature, feature.number("value", 0.0, 1e9)?.unwrap_or(1.0), place, terms)?]);
    }
    if feature.has("value") {
        return Err(feature
            .trouble("`value` has no meaning together with `looks`")
            .because("each look has its own value")
            .help("give every look a `value`, and leave that of the fire out"));
    }
    let of_part = |part: &NamedFeature| match part.number("value", 0.0, 1e9)? {
        Some(value) => look(part, value, place, terms),
        None => Err(part.trouble("a look without `value`").help("state its worth in points")),
    };
    parts.iter().map(of_part).collect()
}

/// Returns the targets that must be seen before this one.
pub(super) fn after(feature: &NamedFeature) -> MissionResult<Vec<OrderNeed>> {
    let discount = feature.number("early_factor", 0.0, 1.0)?.unwrap_or(0.0);
    let targets = feature.texts("after")?;
    if targets.is_empty() && feature.has("early_factor") {
        return Err(feature
            .trouble("`early_factor` without `after`")
            .help("name the targets that come first in `after`"));
    }
    Ok(targets.into_iter().map(|target| OrderNeed { target, discount }).collect())
}

fn look(feature: &NamedFeature, value: f64, place: Position, terms: Terms<'_>) -> MissionResult<WantedLook> {
    let minutes = |key: &str| Ok(feature.number(key, 0.0, 1e6)?.unwrap_or(0.0) * SECONDS_PER_MINUTE);
    let measure = match feature.word("resolution_measure", &["worst-direction", "geometric-mean"])? {
        Some("geometric-mean") => PixelMeasure::GeometricMean,
        _ => PixelMeasure::WorstDirection,
    };
    let zero_multiple = feature.number("resolution_zero_multiple", 1.0, 100.0)?;
    let wanted_m = feature.number("resolution_m", f64::MIN_POSITIVE, 1e6)?;
    let look_angles = feature.pair("look_angle_deg", 0.0, 89.0)?;
    let ramp_deg = feature.number("look_angle_ramp_deg", 0.0, 90.0)?.unwrap_or(LOOK_ANGLE_RAMP_DEG);
    let latency = feature.pair("latency_min", 0.0, 1e6)?;
    let interval = feature.pair("interval_h", 0.0, 1e6)?;
    let interval_ramp_s = minutes("interval_ramp_min")?;
    let name = feature.id.split_once('/').map_or(feature.id.as_str(), |(_, name)| name);
    Ok(WantedLook {
        name: name.to_string(),
        value,
        resolution: ResolutionNeed {
            wanted_m: wanted_m.unwrap_or(f64::INFINITY),
            zero_multiple: zero_multiple.unwrap_or(ResolutionNeed::default().zero_multiple),
            measure,
        },
        coverage_share: feature.number("share", f64::MIN_POSITIVE, 1.0)?.unwrap_or(1.0),
        look_angles: look_angles.map(|(min_deg, max_deg)| LookAngles { min_deg, max_deg, ramp_deg }),
        light: light(feature)?,
        windows: windows(feature, minutes("window_ramp_min")?, terms)?,
        slope: slope(feature)?,
        overpass: overpass(feature, place, terms)?,
        latency: latency
            .map(|(full, zero)| LatencyNeed { full_s: full * SECONDS_PER_MINUTE, zero_s: zero * SECONDS_PER_MINUTE }),
        interval: interval.map(|(min, max)| IntervalNeed {
            min_s: min * SECONDS_PER_HOUR,
            max_s: max * SECONDS_PER_HOUR,
            ramp_s: interval_ramp_s,
        }),
        must: must(feature, terms)?,
        may_share: feature.flag("may_share")?.unwrap_or(false),
    })
}

fn must(feature: &NamedFeature, terms: Terms<'_>) -> MissionResult<Option<MustTerm>> {
    let factor_min = feature.number("must_factor_min", 0.0, 1.0)?;
    let cost = feature.number("must_cost", 0.0, 1e12)?;
    if feature.flag("must")?.unwrap_or(false) {
        let cost = cost.unwrap_or(0.0) / terms.money_per_point;
        return Ok(Some(MustTerm { factor_min: factor_min.unwrap_or(0.0), cost }));
    }
    match ["must_factor_min", "must_cost"].into_iter().find(|key| feature.has(key)) {
        Some(idle) => {
            let help = format!("write `\"must\": true`, or leave `{idle}` out");
            Err(feature.trouble(format!("`{idle}` without `must`")).help(help))
        }
        None => Ok(None),
    }
}

/// Returns the windows; at least one must overlap the mission.
fn windows(feature: &NamedFeature, ramp_s: f64, terms: Terms<'_>) -> MissionResult<Vec<WindowNeed>> {
    let windows: Vec<WindowNeed> = feature
        .spans_s("windows_h")?
        .into_iter()
        .map(|window| WindowNeed { from_s: window.from_s, until_s: window.until_s, ramp_s })
        .collect();
    let inside = |window: &WindowNeed| window.until_s + ramp_s > 0.0 && window.from_s - ramp_s < terms.duration_s;
    if windows.is_empty() || windows.iter().any(inside) {
        return Ok(windows);
    }
    let spans: Vec<String> = windows
        .iter()
        .map(|window| format!("[{}, {}]", window.from_s / SECONDS_PER_HOUR, window.until_s / SECONDS_PER_HOUR))
        .collect();
    Err(feature
        .trouble(format!("`windows_h` is [{}], which lies outside of the mission", spans.join(", ")))
        .because(format!("the mission lasts from 0 to {} h", terms.duration_s / SECONDS_PER_HOUR))
        .help("write hours of mission time (0 is `:start`), or set a longer `:duration`"))
}

fn light(feature: &NamedFeature) -> MissionResult<LightNeed> {
    let word = feature.word("light", &["any", "day", "night"])?;
    let (least, most) = (feature.number("sun_deg_min", -90.0, 90.0)?, feature.number("sun_deg_max", -90.0, 90.0)?);
    let ramp_deg = feature.number("light_ramp_deg", 0.0, 90.0)?;
    let idle = |key: &str, help: &str| {
        let light = word.unwrap_or("any");
        Err(feature.trouble(format!("`{key}` has no meaning where `light` is {light}")).help(help.to_string()))
    };
    let (day_deg, night_deg) = match (LightNeed::DAY, LightNeed::NIGHT) {
        (LightNeed::Day { elevation_deg_min, .. }, LightNeed::Night { elevation_deg_max, .. }) => {
            (elevation_deg_min, elevation_deg_max)
        }
        _ => (0.0, -6.0),
    };
    match (word, least, most) {
        (Some("day"), least, None) => {
            let elevation_deg_min = least.unwrap_or(day_deg);
            Ok(LightNeed::Day { elevation_deg_min, ramp_deg: ramp_deg.unwrap_or(0.0) })
        }
        (Some("night"), None, most) => {
            let elevation_deg_max = most.unwrap_or(night_deg);
            Ok(LightNeed::Night { elevation_deg_max, ramp_deg: ramp_deg.unwrap_or(0.0) })
        }
        (Some("day"), _, Some(_)) => idle("sun_deg_max", "day is from `sun_deg_min` upwards"),
        (Some("night"), Some(_), _) => idle("sun_deg_min", "night is from `sun_deg_max` downwards"),
        (_, Some(_), _) => idle("sun_deg_min", "write `\"light\": \"day\"`"),
        (_, _, Some(_)) => idle("sun_deg_max", "write `\"light\": \"night\"`"),
        (_, None, None) if ramp_deg.is_some() => idle("light_ramp_deg", "write `\"light\": \"day\"` or `\"night\"`"),
        (_, None, None) => Ok(LightNeed::Any),
    }
}

fn slope(feature: &NamedFeature) -> MissionResult<Option<ValueSlope>> {
    let word = feature.word("falls", &["linear", "exponential"])?;
    let since_s = feature.number("falls_from_h", -1e6, 1e6)?.unwrap_or(0.0) * SECONDS_PER_HOUR;
    let Some(over_h) = feature.number("falls_over_h", 1e-6, 1e6)? else {
        let idle = ["falls", "falls_from_h"].into_iter().find(|key| feature.has(key));
        return idle.map_or(Ok(None), |key| {
            let help = "state the number of hours over which the worth falls";
            Err(feature.trouble(format!("`{key}` without `falls_over_h`")).help(help))
        });
    };
    let over_s = over_h * SECONDS_PER_HOUR;
    Ok(Some(match word {
        Some("exponential") => ValueSlope::Exponential { since_s, decay_s: over_s },
        _ => ValueSlope::Linear { since_s, zero_after_s: over_s },
    }))
}

/// Greatest age in days of orbital elements during the mission: their error grows by about a kilometre a day.
const ELEMENTS_DAYS_MAX: f64 = 14.0;

/// Returns the satellite that `tle` or `omm` describes.
fn satellite(feature: &NamedFeature, part: &NamedFeature) -> MissionResult<Satellite> {
    let no_orbit = |key: &str, reason: String, help: &str| {
        feature.trouble(format!("`{key}` of `overpass` is not an orbit")).because(reason).help(help)
    };
    match (part.has("tle"), part.json("omm")) {
        (true, Some(_)) => Err(feature.trouble("`overpass` has both `tle` and `omm`").help("leave one of them out")),
        (_, Some(message)) => Satellite::from_omm(message).map_err(|error| {
            no_orbit("omm", error.reason, "copy the object as CelesTrak or Space-Track publish it in JSON")
        }),
        (_, None) => {
            let lines = part.texts("tle")?;
            let [first, second] = lines.as_slice() else {
                return Err(feature
                    .trouble(format!("`tle` of `overpass` has {} lines", lines.len()))
                    .help("give the two lines of the satellite's orbital elements, or `omm`"));
            };
            Satellite::from_tle(first, second)
                .map_err(|error| no_orbit("tle", error.reason, "copy both lines as they are published"))
        }
    }
}

fn check_age(feature: &NamedFeature, satellite: &Satellite, zero_unix_s: f64, duration_s: f64) -> MissionResult<()> {
    let (first, last) = (satellite.age_days(zero_unix_s), satellite.age_days(zero_unix_s + duration_s));
    let worst = if last.abs() > first.abs() { last } else { first };
    if worst.abs() <= ELEMENTS_DAYS_MAX {
        return Ok(());
    }
    let side = if worst > 0.0 { "older" } else { "newer" };
    Err(feature
        .trouble("the orbital elements of `overpass` are not of the time of the mission")
        .because(format!(
            "they are {:.0} days {side} than the mission, and at most {ELEMENTS_DAYS_MAX:.0} days are good for a pass",
            worst.abs()
        ))
        .help("take elements whose epoch is nearer to `:start`, or leave `overpass` out"))
}

fn overpass(feature: &NamedFeature, place: Position, terms: Terms<'_>) -> MissionResult<Option<OverpassNeed>> {
    if !feature.has("overpass") {
        return Ok(None);
    }
    let part = feature.object("overpass", &["tle", "omm", "half_scan_deg", "nadir_deg_max", "full_min", "zero_min"])?;
    let Some(zero_unix_s) = terms.epoch_unix_s else {
        return Err(feature
            .trouble("`overpass` in a mission without `:start`")
            .because("where a satellite is depends on the date")
            .help("add `:start` with a civil time to the application"));
    };
    let satellite = satellite(feature, &part)?;
    check_age(feature, &satellite, zero_unix_s, terms.duration_s)?;
    let degrees = |key: &str, default: f64| Ok(part.number(key, 1e-3, 89.0)?.unwrap_or(default));
    let usual = PassLimits::default();
    let limits = PassLimits {
        half_scan_deg: degrees("half_scan_deg", usual.half_scan_deg)?,
        nadir_angle_deg_max: degrees("nadir_deg_max", usual.nadir_angle_deg_max)?,
    };
    let minutes = |key: &str, default: f64| Ok(part.number(key, 0.0, 1e5)?.unwrap_or(default) * SECONDS_PER_MINUTE);
    let (full_s, zero_s) = (minutes("full_min", 30.0)?, minutes("zero_min", 60.0)?);
    if zero_s < full_s {
        return Err(feature
            .trouble("`overpass`: `zero_min` is less than `full_min`")
            .help("the worth falls from the first to the second"));
    }
    let found = passes(&satellite, place, zero_unix_s, -zero_s, terms.duration_s + zero_s);
    let passes_s: Vec<f64> = found.iter().filter(|pass| limits.sees(pass)).map(|pass| pass.time_s).collect();
    if passes_s.is_empty() {
        return Err(feature
            .trouble("no pass of the satellite of `overpass` sees the place during the mission")
            .help("leave `overpass` out, raise `nadir_deg_max`, or set another `:start`"));
    }
    Ok(Some(OverpassNeed { passes_s, full_s, zero_s }))
}

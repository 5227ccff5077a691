//! Permitted beginnings of a look and the value of its timing, in the form of planners: windows, light, and a table of the timing factor
//! over the beginning of the observation.

use crate::{Mission, Target};
use apex_geo::geodesy;
use apex_model::problem::{FOREVER_S, Light, TimeWindow};
use apex_observation::target::{IntervalNeed, WantedLook};
use apex_observation::timing::sun::solar_position;
use apex_observation::timing::{LightNeed, windows_factor};

/// Step of the table.
const STEP_S: f64 = 300.0;
/// Number of instants of an observation whose timing factors are averaged.
const INSTANTS: u32 = 5;

/// Returns the permitted beginnings of the look: its windows with their ramps; empty is any time.
pub(super) fn begins(look: &WantedLook) -> Vec<TimeWindow> {
    let with_ramp = look
        .windows
        .iter()
        .map(|window| TimeWindow { from_s: window.from_s - window.ramp_s, until_s: window.until_s + window.ramp_s });
    with_ramp.collect()
}

/// Like [`begins`], for a look of which other looks of the target were observed, from one time to another each.
pub(super) fn begins_after(look: &WantedLook, seen_s: &[(f64, f64)]) -> Vec<TimeWindow> {
    let begins = begins(look);
    let Some((need, last)) = look.interval.zip(seen_s.iter().max_by(|a, b| a.1.total_cmp(&b.1))) else { return begins };
    let after = interval_windows(&[*last], &need, f64::INFINITY);
    if begins.is_empty() {
        return after;
    }
    let both = begins.iter().flat_map(|window| {
        after.iter().map(move |after| TimeWindow {
            from_s: window.from_s.max(after.from_s),
            until_s: window.until_s.min(after.until_s),
        })
    });
    let both: Vec<TimeWindow> = both.filter(|window| window.from_s <= window.until_s).collect();
    // No window would mean any time.
    if both.is_empty() { vec![TimeWindow { from_s: 0.0, until_s: 0.0 }] } else { both }
}

/// Returns true if the windows of a look in a problem follow from an observation of another look.
pub(crate) fn is_bound_to_seen(look: &WantedLook, windows: &[TimeWindow]) -> bool {
    look.interval.is_some() && begins(look) != windows
}

/// Returns when a look of `duration_s` may begin so that the intervals to the other looks, which are seen from one time to another each and
/// in order, are as wanted.
pub(crate) fn interval_windows(others_s: &[(f64, f64)], need: &IntervalNeed, duration_s: f64) -> Vec<TimeWindow> {
    let gap = |index: usize| {
        let before = index.checked_sub(1).and_then(|index| others_s.get(index));
        let after = others_s.get(index);
        let from_s = before.map_or(f64::NEG_INFINITY, |(_, end_s)| end_s + need.min_s);
        let until_s = before.map_or(f64::INFINITY, |(begin_s, _)| begin_s + need.max_s);
        let from_s = after.map_or(from_s, |(_, end_s)| from_s.max(end_s - need.max_s));
        let until_s = after.map_or(until_s, |(begin_s, _)| until_s.min(begin_s - need.min_s - duration_s));
        let window = TimeWindow { from_s: from_s.max(0.0), until_s: until_s.min(FOREVER_S) };
        (window.from_s <= window.until_s).then_some(window)
    };
    (0..=others_s.len()).filter_map(gap).collect()
}

/// Returns the first instant from `from_s` on at which the look may begin; `from_s` itself without windows, or after the last one.
pub(super) fn first_s(look: &WantedLook, from_s: f64) -> f64 {
    let open = begins(look).into_iter().filter(|window| window.until_s > from_s);
    let first_s = open.map(|window| window.from_s.max(from_s)).fold(f64::INFINITY, f64::min);
    if first_s.is_finite() { first_s } else { from_s }
}

/// Returns the light that planners know without a table: with the usual elevations of the sun, and no ramp.
pub(super) fn hard_light(look: &WantedLook) -> Light {
    match look.light {
        light if light == LightNeed::DAY => Light::Day,
        light if light == LightNeed::NIGHT => Light::Night,
        _ => Light::Any,
    }
}

/// Arrival of images on the ground where the mission does not say that they are sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GroundArrival {
    /// After the way home from the target: the earliest.
    AfterWayHome,
    /// This long after the middle of the observation, in seconds.
    After(f64),
}

/// Returns the timing factor by the beginning of an observation of `duration_s`; empty if the look has no windows and the factor is 1
/// whenever the light permits the observation.
pub(super) fn table(
    mission: &Mission,
    target: &Target,
    look: &WantedLook,
    (now_s, duration_s, line_s): (f64, f64, f64),
    arrival: GroundArrival,
) -> Vec<(f64, f64)> {
    let ramps = look.light != LightNeed::Any && hard_light(look) == Light::Any;
    let is_steady = look.slope.is_none() && look.overpass.is_none() && look.latency.is_none();
    if look.windows.is_empty() && is_steady && !ramps {
        return Vec::new();
    }
    let zero_unix_s = mission.settings.epoch_unix_s.unwrap_or(0.0);
    let least_s = on_ground_after_s(mission, target, (duration_s, line_s));
    let on_ground_s = match arrival {
        _ if mission.settings.images_on_ground.is_some() => least_s,
        GroundArrival::AfterWayHome => least_s,
        GroundArrival::After(after_s) => after_s,
    };
    let at = |time_s: f64| {
        let light = if ramps {
            look.light.factor(solar_position(target.position, zero_unix_s + time_s).elevation_deg)
        } else {
            1.0
        };
        let slope = look.slope.map_or(1.0, |slope| slope.factor(time_s));
        let overpass = look.overpass.as_ref().map_or(1.0, |overpass| overpass.factor(time_s));
        let latency = look.latency.map_or(1.0, |need| need.factor(Some(on_ground_s)));
        windows_factor(&look.windows, time_s) * slope * overpass * latency * light
    };
    let of_beginning = |begin_s: f64| {
        let instant = |step: u32| begin_s + duration_s * (f64::from(step) + 0.5) / f64::from(INSTANTS);
        (0..INSTANTS).map(|step| at(instant(step))).sum::<f64>() / f64::from(INSTANTS)
    };
    let end_s = mission.settings.duration.seconds();
    let count = libm::ceil(((end_s - now_s) / STEP_S).max(1.0)) as usize;
    let mut times_s: Vec<f64> = (0..=count).map(|step| now_s + STEP_S * step as f64).collect();
    // Edges between steps: where windows open and close for the observation's beginning and end.
    let edges = look.windows.iter().flat_map(|window| {
        let sides = [window.from_s - window.ramp_s, window.from_s, window.until_s, window.until_s + window.ramp_s];
        sides.into_iter().flat_map(move |edge_s| [edge_s, edge_s - duration_s])
    });
    times_s.extend(edges.filter(|edge_s| *edge_s > now_s && *edge_s < end_s));
    times_s.sort_by(f64::total_cmp);
    times_s.dedup_by(|next, before| *next - *before < 1.0);
    let all: Vec<(f64, f64)> = times_s.into_iter().map(|time_s| (time_s, of_beginning(time_s))).collect();
    corners(&all)
}

/// Returns the mean time in seconds from the middle of an observation until its images are on the ground. An image is sent when its line
/// is finished; if the mission does not state that images are sent, it is read after the landing, at the earliest after the way home and
/// the descent there.
fn on_ground_after_s(mission: &Mission, target: &Target, (duration_s, line_s): (f64, f64)) -> f64 {
    let model = &mission.model;
    let descent_mps = model.descent_rate_m_s_max * model.planning.descent_share;
    let descent_s = (mission.cruise_altitude_m() - mission.start_altitude_m).max(0.0) / descent_mps;
    let home_s = geodesy::distance_m(target.position, mission.start) / model.true_airspeed_m_s_cruise + descent_s;
    let sent_s = mission.settings.images_on_ground.map(|delay| 0.5 * line_s + delay.seconds());
    sent_s.unwrap_or(0.5 * duration_s + home_s)
}

/// Returns the points that are needed to draw the same line.
fn corners(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let straight = match (kept.last(), points.get(index + 1)) {
            (Some(before), Some(next)) => {
                let share = (point.0 - before.0) / (next.0 - before.0);
                (before.1 + share * (next.1 - before.1) - point.1).abs() < 1e-9
            }
            _ => false,
        };
        if !straight {
            kept.push(*point);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_keeps_its_corners() {
        let line = [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.5), (4.0, 0.0), (5.0, 0.0)];
        assert_eq!(corners(&line), [(0.0, 1.0), (2.0, 1.0), (4.0, 0.0), (5.0, 0.0)]);
    }
}

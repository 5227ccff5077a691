//! Synthesis: predicts the candidates for a goal, filters them by the requirements and by Pareto dominance, and chooses one by value and
//! time. A rejected candidate keeps its reason; if all are rejected, the error is the reason of the candidate nearest to the goal.
//!
//! Bound: `CANDIDATES_MAX` forecasts and O(n^2) comparisons.

use super::candidates::{CANDIDATES_MAX, ManoeuvreCandidate, at_height, heights_m, lowest_m, sensors};
use super::checks::{closed_by, requirements_kept, sun_miss};
use super::goal::AcquisitionGoal;
use super::pareto::{ANSWERS_MAX, Cost, Predicted, add, answer, beats, cost, figures, full_at_s, is_perfect};
use super::permitted::PathRequirements;
use super::predicted::observe;
use super::risk::{Risk, RiskLimits};
use super::vehicle::{craft_of, scene_of};
use crate::Mission;
use apex_geo::geodesy::{self, Position};
use apex_observation::manoeuvres::{
    Craft, FlightPath, Forecast, Instrument, PathPose, Scene, TimedTrack, rounded_down, rounded_up,
};
use apex_observation::sensor::CameraSetting;
use apex_observation::timing::LightNeed;
use apex_observation::timing::sun::solar_position;

/// Least mean factor of resolution: nearly all of the ground has at least the wanted resolution.
const RESOLUTION_MIN: f64 = 0.9;

/// Place, time and remaining energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    /// Position of the vehicle.
    pub(crate) here: Position,
    /// Instant.
    pub(crate) at_s: f64,
    /// Flight time left without the reserve.
    pub(crate) endurance_s: f64,
}

/// A rejected candidate: its relative distance from meeting the goal, and the reason.
#[derive(Clone, Debug, PartialEq)]
struct Miss {
    by: f64,
    why: String,
    /// Pixels with which the candidate may work, m: a miss of the height alone.
    pixel_m: Option<f64>,
}

impl Miss {
    fn new(by: f64, why: String) -> Miss {
        Miss { by, why, pixel_m: None }
    }
}

/// Result for a goal: the Pareto front, best first, and counts.
#[derive(Clone, Debug)]
pub(crate) struct Synthesis {
    /// The front; the first is chosen.
    pub(crate) front: Vec<Predicted>,
    /// Candidates in all.
    pub(crate) tried: usize,
    /// Reasons of the rejected candidates, the nearest to the goal first; candidates that another one certainly beats are not predicted.
    pub(crate) misses: Vec<String>,
}

/// Synthesises manoeuvres for a goal.
///
/// # Errors
/// No vehicle or sensor of the mission can meet the goal: the nearest miss.
pub(crate) fn synthesise(mission: &Mission, goal: &AcquisitionGoal, start: Start) -> Result<Synthesis, String> {
    let mut misses: Vec<Miss> = Vec::new();
    let candidates = all_candidates(mission, goal, start, &mut misses)?;
    let tried = candidates.len();
    let (front, _) = predicted(mission, goal, candidates, start, &mut misses);
    misses.sort_by(|a, b| a.by.total_cmp(&b.by));
    misses.dedup_by(|next, before| next.why == before.why);
    misses.truncate(ANSWERS_MAX);
    let front = answer(front);
    if !front.is_empty() {
        return Ok(Synthesis { front, tried, misses: misses.into_iter().map(|miss| miss.why).collect() });
    }
    let nearest = match misses.into_iter().next() {
        None => "no manoeuvre fits the vehicle and its sensors".to_string(),
        Some(Miss { why, pixel_m, .. }) => match pixel_m.and_then(|least_m| works(mission, goal, least_m, start)) {
            Some(pixel) => format!("{why}; {pixel} m works"),
            None => why,
        },
    };
    Err(format!("none of {tried} manoeuvres acquires `{}` as wanted; the nearest miss: {nearest}", goal.target.name))
}

/// Returns a size of pixels from `least_m` on for which a manoeuvre meets the rest of the goal, as text; `None` if none of a few sizes is
/// one. Pixels at the edges of pictures and at look angles are larger than those straight below, so each size is tried.
fn works(mission: &Mission, goal: &AcquisitionGoal, least_m: f64, start: Start) -> Option<String> {
    const SHARES: [f64; 8] = [1.0, 1.05, 1.15, 1.35, 1.7, 2.2, 3.0, 4.5];
    SHARES.iter().map(|share| rounded_up(share * least_m, 3)).find(|text| {
        let Some(coarser) = text.parse().ok().and_then(|pixel_m| goal.at_resolution(pixel_m)) else { return false };
        is_met(mission, &coarser, start)
    })
}

/// Returns true if a candidate meets the goal: the first one found suffices.
fn is_met(mission: &Mission, goal: &AcquisitionGoal, start: Start) -> bool {
    let candidates = all_candidates(mission, goal, start, &mut Vec::new()).unwrap_or_default();
    let requirements = PathRequirements::of(mission);
    let mut timed = by_time(mission, goal, candidates, start).into_iter().filter_map(Result::ok);
    timed.any(|timed| judged(mission, (goal, &requirements), timed, start).is_ok())
}

/// Returns the candidates of all sensors at all heights, at most [`CANDIDATES_MAX`]; adds the misses of heights.
fn all_candidates(
    mission: &Mission,
    goal: &AcquisitionGoal,
    start: Start,
    misses: &mut Vec<Miss>,
) -> Result<Vec<ManoeuvreCandidate>, String> {
    let sensors = sensors(mission, goal)?;
    light(mission, goal, &sensors, start.at_s)?;
    let mut candidates = Vec::new();
    for (name, instrument) in &sensors {
        height_miss(mission, goal, (name, instrument), misses);
        for height_m in heights_m(mission, goal, instrument) {
            candidates.extend(at_height((mission, goal), (name, instrument), height_m, (start.here, start.at_s)));
        }
    }
    thin(&mut candidates);
    Ok(candidates)
}

/// Returns the Pareto front of the candidates that meet the goal, and the number of those that were predicted; adds the misses of the
/// others. Candidates that cannot be in the answer are not predicted: those that a perfect one beats whatever they saw, and those that end
/// after the last one of a full answer.
fn predicted(
    mission: &Mission,
    goal: &AcquisitionGoal,
    candidates: Vec<ManoeuvreCandidate>,
    start: Start,
    misses: &mut Vec<Miss>,
) -> (Vec<Predicted>, usize) {
    let (mut front, mut predictions): (Vec<Predicted>, usize) = (Vec::new(), 0);
    let mut full_s = None;
    let requirements = PathRequirements::of(mission);
    for timed in by_time(mission, goal, candidates, start) {
        let timed = match timed {
            Ok(timed) => timed,
            Err(miss) => {
                misses.push(miss);
                continue;
            }
        };
        if full_s.is_some_and(|full_s: f64| timed.cost[0] > full_s) {
            break;
        }
        if front.iter().any(|one| is_perfect(one) && beats(&figures(one)[1..], &timed.cost)) {
            continue;
        }
        predictions += 1;
        match judged(mission, (goal, &requirements), timed, start) {
            Ok(predicted) => {
                add(&mut front, predicted);
                full_s = full_at_s(&front);
            }
            Err(miss) => misses.push(miss),
        }
    }
    (front, predictions)
}

/// Adds a miss: the required pixels need a height at which the vehicle may not fly.
fn height_miss(
    mission: &Mission,
    goal: &AcquisitionGoal,
    (name, instrument): (&str, &Instrument),
    misses: &mut Vec<Miss>,
) {
    let highest_m = goal.resolution_m / instrument.pixel_rad();
    let lowest_m = lowest_m(mission, goal);
    if highest_m < lowest_m {
        let why = format!(
            "`{name}` needs {highest_m:.0} m above the target or less for pixels of {} m, `{}` flies no lower than {lowest_m:.0} m",
            goal.resolution_m, mission.model.name
        );
        let by = (lowest_m - highest_m) / lowest_m * 0.5;
        misses.push(Miss { by, why, pixel_m: Some(lowest_m * instrument.pixel_rad()) });
    }
}

/// Thins the candidates evenly to [`CANDIDATES_MAX`].
fn thin(candidates: &mut Vec<ManoeuvreCandidate>) {
    let count = candidates.len();
    if count <= CANDIDATES_MAX {
        return;
    }
    let mut index = 0;
    candidates.retain(|_| {
        let kept = index * CANDIDATES_MAX / count != (index + 1) * CANDIDATES_MAX / count;
        index += 1;
        kept
    });
}

/// Checks the light that the goal or every sensor needs.
fn light(mission: &Mission, goal: &AcquisitionGoal, sensors: &[(String, Instrument)], at_s: f64) -> Result<(), String> {
    let Some(zero_unix_s) = mission.settings.epoch_unix_s else { return Ok(()) };
    let sun_deg = solar_position(goal.position, zero_unix_s + at_s).elevation_deg;
    let needs = |instrument: &Instrument| match instrument {
        Instrument::Camera(CameraSetting { sun_deg_min, .. }) => *sun_deg_min,
        Instrument::Scanner(_) => None,
    };
    let (least_deg, most_deg, whose) = match goal.light {
        LightNeed::Day { elevation_deg_min, .. } => {
            (Some(elevation_deg_min), None, "the goal requires day".to_string())
        }
        LightNeed::Night { elevation_deg_max, .. } => {
            (None, Some(elevation_deg_max), "the goal requires night".to_string())
        }
        LightNeed::Any => {
            let least = sensors.iter().map(|(_, instrument)| needs(instrument));
            let all: Option<Vec<f64>> = least.collect();
            let least = all.and_then(|all| all.into_iter().reduce(f64::min));
            (least, None, "its cameras have no band for the night".to_string())
        }
    };
    let is_dark = least_deg.is_some_and(|least| sun_deg < least);
    let is_bright = most_deg.is_some_and(|most| sun_deg > most);
    if !is_dark && !is_bright {
        return Ok(());
    }
    let fits = |deg: f64| least_deg.is_none_or(|least| deg >= least) && most_deg.is_none_or(|most| deg <= most);
    let minutes = (0..24 * 60).find(|minute| {
        fits(solar_position(goal.position, zero_unix_s + at_s + 60.0 * f64::from(*minute)).elevation_deg)
    });
    let later = minutes
        .map_or_else(String::new, |minute| format!("; in {} h it does", rounded_up(f64::from(minute) / 60.0, 1)));
    let limit = least_deg.or(most_deg).unwrap_or(0.0);
    let side = if is_dark { "at least" } else { "at most" };
    Err(format!("{whose}, with the sun {side} at {limit:.0} degrees; it is at {sun_deg:.0} degrees{later}"))
}

/// Predicts a candidate and compares it with the goal.
fn judged(
    mission: &Mission,
    (goal, requirements): (&AcquisitionGoal, &PathRequirements),
    timed: TimedCandidate,
    start: Start,
) -> Result<Predicted, Miss> {
    let TimedCandidate { candidate, craft, scene, timed, travel_s, risk, .. } = timed;
    let name = candidate.manoeuvre.path.name();
    let at = format!("`{name}` from {:.0} m above the target", candidate.height_m);
    let altitude_m = goal.target.elevation_m + candidate.height_m;
    let conditions = (&craft, &candidate.instrument, &scene);
    let forecast = observe(mission, (&candidate.manoeuvre, timed), conditions, (&goal.target, &goal.grid), false);
    // The distance of a candidate from the goal is that of its worst deficit; the others are stated with it.
    let mut misses: Vec<Miss> = Vec::new();
    if let Some(zone) = closed_by(mission, &forecast, &scene, Some(start.at_s + travel_s)) {
        let (low_m, high_m) = (zone.altitude_m_min, zone.altitude_m_max);
        let by = (high_m - altitude_m).min(altitude_m - low_m).max(0.0) / altitude_m.max(1.0);
        let why = format!(
            "{at} needs {altitude_m:.0} m above sea level, the zone `{}` reaches from {low_m:.0} m to {high_m:.0} m",
            zone.name
        );
        misses.push(Miss::new(by, why));
    } else if let Err(refusal) =
        requirements_kept((mission, requirements), goal, &candidate, (&forecast, &scene), start.at_s + travel_s)
    {
        misses.push(Miss::new(refusal.excess(), refusal.to_string()));
    }
    if let Instrument::Camera(_) = &candidate.instrument
        && let Some((by, why)) = sun_miss(mission, &candidate.sensor, &forecast, &scene)
    {
        misses.push(Miss::new(by, format!("{at} {why}")));
    }
    if let Some((figure, wanted, found)) = short_of(goal, &forecast) {
        let why = format!("{at} is predicted a {figure} of {}, {wanted:.2} is wanted", rounded_down(found, 2));
        misses.push(Miss::new((wanted - found) / wanted, why));
    }
    let end_s = start.at_s + travel_s + forecast.time_s;
    if let Some(by_s) = goal.by_s.filter(|by_s| end_s > *by_s) {
        let why = format!("{at} ends at {} s, `:by` is {by_s:.0} s", rounded_up(end_s, 0));
        misses.push(Miss::new((end_s - by_s) / end_s, why));
    }
    let home_s = geodesy::distance_m(goal.position, mission.start) / craft.true_airspeed_mps;
    let end_of_data_s = forecast.on_ground_s.map(|at_s| at_s - scene.from_s - forecast.time_s);
    misses.extend(late(mission, goal, &at, (end_of_data_s, home_s)));
    let back_s = end_s + home_s;
    let duration_s = mission.settings.duration.seconds();
    if back_s > duration_s {
        let why = format!(
            "{at} ends at {end_s:.0} s, the vehicle would be at its start at {back_s:.0} s, and the mission ends at {duration_s:.0} s"
        );
        misses.push(Miss::new((back_s - duration_s) / back_s, why));
    }
    let whole_s = travel_s + forecast.time_s + home_s;
    if whole_s > start.endurance_s {
        let why = format!(
            "{at} takes {whole_s:.0} s with the way there and home, the energy lasts {:.0} s",
            start.endurance_s
        );
        misses.push(Miss::new((whole_s - start.endurance_s) / whole_s, why));
    }
    if misses.is_empty() {
        return Ok(Predicted { candidate, scene, forecast, travel_s, risk });
    }
    misses.sort_by(|a, b| b.by.total_cmp(&a.by));
    let worst = misses.first().map_or(0.0, |miss| miss.by);
    let all: Vec<String> = misses.into_iter().map(|miss| miss.why).collect();
    Err(Miss::new(worst, all.join("; moreover ")))
}

/// Returns the miss of a goal whose data would be on the ground too late: by the handling that the goal states (`sent_s` after the end, or
/// after landing), otherwise after the time that images take over the link of the mission, or, without such a link, after the way home.
fn late(mission: &Mission, goal: &AcquisitionGoal, at: &str, (sent_s, home_s): (Option<f64>, f64)) -> Option<Miss> {
    let (after_s, how) = match (goal.data, sent_s, mission.settings.images_on_ground) {
        (Some(_), Some(sent_s), _) => (sent_s, "data are sent as the goal states, and on the ground"),
        (None, _, Some(delay)) => (delay.seconds(), "data are sent, and on the ground"),
        _ => (home_s, "data are read after landing,"),
    };
    let latency_s = goal.latency_s.filter(|latency_s| after_s > *latency_s)?;
    let why = format!("{at}: {how} {after_s:.0} s after the observation, `:latency` is {latency_s:.0} s");
    Some(Miss::new((after_s - latency_s) / after_s, why))
}

/// Returns the factor that falls short of the goal most.
fn short_of(goal: &AcquisitionGoal, forecast: &Forecast) -> Option<(&'static str, f64, f64)> {
    let factors = &forecast.factors;
    let least = |wanted: f64| wanted.max(1e-3);
    // Without a pixel size the factor of resolution is that of the look angle.
    let all = [
        ("coverage", least(goal.coverage_min), factors.coverage),
        ("clarity", least(goal.clarity_min), factors.clarity),
        ("resolution and look-angle factor", RESOLUTION_MIN, factors.resolution),
    ];
    let short = all.into_iter().filter(|(_, wanted, found)| found < wanted);
    short.max_by(|a, b| ((a.1 - a.2) / a.1).total_cmp(&((b.1 - b.2) / b.1)))
}

/// A candidate with its poses over time, before the prediction of what it sees.
struct TimedCandidate {
    candidate: ManoeuvreCandidate,
    craft: Craft,
    scene: Scene,
    timed: TimedTrack,
    travel_s: f64,
    risk: Risk,
    cost: Cost,
}

/// Returns the candidates in the order of their ends, then the misses of those that vehicle, sensor or wind do not permit.
fn by_time(
    mission: &Mission,
    goal: &AcquisitionGoal,
    candidates: Vec<ManoeuvreCandidate>,
    start: Start,
) -> Vec<Result<TimedCandidate, Miss>> {
    let limits = RiskLimits::of(mission, goal);
    let timed = |candidate: ManoeuvreCandidate| {
        let (craft, scene) = setting(mission, goal, &candidate, start);
        let timed = candidate
            .manoeuvre
            .timed(&craft, &candidate.instrument, &scene)
            .map_err(|refusal| Miss::new(1.0 + refusal.excess(), refusal.to_string()))?;
        let travel_s = travel_s(timed.flown.poses.first(), &scene, goal, start, &craft);
        let risk = limits.risk(&timed.flown, &craft, &scene);
        let cost = cost(&timed.flown, travel_s, risk);
        Ok(TimedCandidate { candidate, craft, scene, timed, travel_s, risk, cost })
    };
    let mut all: Vec<Result<TimedCandidate, Miss>> = candidates.into_iter().map(timed).collect();
    let end_s = |one: &Result<TimedCandidate, Miss>| one.as_ref().map_or(f64::INFINITY, |one| one.cost[0]);
    all.sort_by(|a, b| end_s(a).total_cmp(&end_s(b)));
    all
}

/// Returns the vehicle and the scene of a candidate.
fn setting(mission: &Mission, goal: &AcquisitionGoal, candidate: &ManoeuvreCandidate, start: Start) -> (Craft, Scene) {
    let craft = craft_of(&mission.model, goal.target.elevation_m + candidate.height_m);
    let direct_s = geodesy::distance_m(start.here, goal.position) / craft.true_airspeed_mps;
    let place = (goal.position, goal.target.elevation_m);
    let scene = scene_of(place, &mission.forecast, candidate.height_m, start.here, start.at_s + direct_s);
    (craft, scene)
}

/// Returns the flight time to the first pose of a manoeuvre.
fn travel_s(first: Option<&PathPose>, scene: &Scene, goal: &AcquisitionGoal, start: Start, craft: &Craft) -> f64 {
    let first = first.map_or(goal.position, |pose| scene.position(pose.point));
    geodesy::distance_m(start.here, first) / craft.true_airspeed_mps
}

/// Returns one line for operators: a candidate and its predicted quality.
pub(super) fn told(one: &Predicted) -> String {
    let Forecast { factors, points, time_s, .. } = &one.forecast;
    let what = match &one.candidate.manoeuvre.path {
        FlightPath::Sweep(_) => "sweep",
        path => path.name(),
    };
    format!(
        "{what} from {:.0} m with {}: {points:.1} of 100 points (coverage {:.2}, clarity {:.2}, resolution {:.2}), {time_s:.0} s \
         and {:.0} s to get there, risk {:.2} ({})",
        one.candidate.height_m,
        one.candidate.sensor,
        factors.coverage,
        factors.clarity,
        factors.resolution,
        one.travel_s,
        one.risk.share,
        one.risk.cause
    )
}

#[cfg(test)]
mod tests;

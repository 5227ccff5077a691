//! Poses a planning problem from a mission and its present situation.

pub(crate) mod limits;
mod timing;

pub(crate) use timing::{GroundArrival, interval_windows, is_bound_to_seen};

use super::situation::Situation;
use super::{Fire, Mission, Site, TargetKind};
use crate::descent::{Descent, descent_rate_mps};
use crate::energy::energy;
use crate::manoeuvres::{self, Wish};
use crate::score::{FlownScore, is_complete};
use crate::site_pictures::{self, Daylight};
use crate::vehicle::turn_radius_m;
use crate::visit_altitude::sites;
pub use crate::visit_altitude::visit_altitude_m;
use crate::ways::time_error_s;
use apex_geo::geodesy;
use apex_model::problem::{
    AirspaceZone, EventRate, FOREVER_S, Manoeuvre, MustVisit, Position, Problem, SingleVisitProblem, SingleVisitTarget,
    SingleVisitVehicle, SurveillanceProblem, SurveillanceTarget, TimeWindow, ZoneKind,
};
use apex_model::time::Time;
use apex_observation::target::WantedLook;
use apex_planning::surveillance::travel::{SurveillanceTravel, Transit};
use apex_portfolio::parallel::on_all_processors;

/// Reason for a missing plan. `NothingLeft` ends a mission in progress; a `Fault` does so only in the air, and only if the program does
/// not handle it (decision 0240).
#[derive(Debug, Clone, PartialEq)]
pub enum NoPlan {
    /// No remaining target can be visited.
    NothingLeft(String),
    /// Planning failed: a refused plan, an unknown solver, invalid data.
    Fault(String),
}

impl std::fmt::Display for NoPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (NoPlan::NothingLeft(reason) | NoPlan::Fault(reason)) = self;
        f.write_str(reason)
    }
}

/// Returns the problem for a plan of the mission as assumed at `at`: observed looks are left out, and partly observed ones have their
/// remaining value.
///
/// # Errors
/// If nothing is left to plan, or the data are invalid.
pub fn pose(mission: &Mission, situation: &Situation, flown: Option<&FlownScore>, at: Time) -> Result<Problem, NoPlan> {
    if mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_))) {
        single_visits(mission, (situation, flown, at), (&|_| true, true)).map(Problem::SingleVisit)
    } else {
        // The sites are near one another, and the plan is short: the wind that was measured blows at all of them.
        let measured = situation.in_measured_wind(mission.clone(), at.seconds());
        surveillance(&measured, situation, at).map(Problem::Surveillance)
    }
}

/// Returns the surveillance problem of a mission without fires, posed at its start, with all visits, even those that cannot give a valid
/// picture. The cost of a flight is computed from it.
///
/// # Errors
/// If the data are invalid.
pub(crate) fn watched(mission: &Mission) -> Result<SurveillanceProblem, NoPlan> {
    every_visit(mission, &Situation::default(), Time::ZERO)
}

/// Returns the position of the vehicle, as far as known.
pub(super) fn here(mission: &Mission, situation: &Situation) -> Position {
    situation.vehicle.position.unwrap_or(mission.start)
}

/// Selection of looks by their names in plans, and whether the causes of their losses are requested.
pub(crate) type Asked<'a> = (&'a dyn Fn(&str) -> bool, bool);

/// The situation, the observations so far, and the instant of the request.
pub(crate) type PlanningKnowledge<'a> = (&'a Situation, Option<&'a FlownScore>, Time);

/// Returns the single-visit problem of the selected looks.
///
/// # Errors
/// Like [`pose`].
pub(crate) fn single_visits(
    mission: &Mission,
    known: PlanningKnowledge<'_>,
    asked: Asked<'_>,
) -> Result<SingleVisitProblem, NoPlan> {
    let (situation, _, at) = known;
    let model = &mission.model;
    let planning = &model.planning;
    let now_s = at.seconds();
    let energy = energy(mission, situation);
    let flow = energy.fuel_flow_kg_per_s;
    let climb_s = if flow > 0.0 { energy.climb_fuel_kg / flow } else { 0.0 };
    let start = here(mission, situation);
    let (targets, precedence) = wanted(mission, known, asked)?;
    let mut problem = SingleVisitProblem {
        targets,
        vehicle: SingleVisitVehicle {
            true_airspeed_mps: model.true_airspeed_m_s_cruise,
            cruise_altitude_m: mission.cruise_altitude_m(),
            climb_rate_mps: model.climb_rate_m_s_max * planning.climb_share,
            descent_rate_mps: descent_rate_mps(model),
            fuel_kg: energy.fuel_kg,
            fuel_reserve_kg: energy.fuel_reserve_kg + energy.landing_fuel_kg + energy.climb_fuel_kg,
            fuel_flow_kg_per_s: energy.fuel_flow_kg_per_s,
            endurance_s: energy.endurance_s,
            endurance_reserve_s: energy.reserve_s + energy.landing_s + climb_s,
            endurance_limit: None,
            turn_radius_m: turn_radius_m(model),
        },
        start,
        start_altitude_m: situation.vehicle.altitude_m.max(mission.start_altitude_m),
        start_s: now_s,
        base: Some(mission.start),
        // Plans end over the base at cruise altitude: the descent needs its time, as it needs its energy.
        end_s: Some(limits::end_s(mission, now_s) - Descent::to_base(mission).time_s),
        end_limit: limits::end(mission, now_s, limits::latest_end_s(mission, now_s)),
        zero_unix_s: mission.settings.epoch_unix_s.unwrap_or(0.0),
        precedence,
        zones: mission.zones.iter().map(|zone| timed(&grown(zone, mission), now_s)).collect(),
        zone_margin_m: mission.requirements.zone_margin_m,
        landing_places: mission.landing_places(),
        landing_distance_m_max: mission.requirements.landing_distance_m_max(),
        wind: mission.forecast.clone(),
        crew: mission.crew.clone(),
        failure: mission.failure,
        travel: None,
    };
    problem.vehicle.endurance_limit = limits::endurance(mission, &problem.vehicle);
    Ok(problem)
}

/// Targets of a problem, and pairs of names of which the first must precede the second.
type ProblemTargets = (Vec<SingleVisitTarget>, Vec<(String, String)>);

/// Returns the selected looks that are still open, each as a separate target, and their required order.
fn wanted(
    mission: &Mission,
    (situation, flown, at): PlanningKnowledge<'_>,
    (is_asked, is_explained): Asked<'_>,
) -> Result<ProblemTargets, NoPlan> {
    let start = here(mission, situation);
    let is_open = |name: &str| is_asked(name) && !situation.observed().any(|visit| visit.target == name);
    let open = mission.targets.iter().filter_map(|target| match &target.kind {
        TargetKind::Fire(fire) if mission.weak_reason(&target.id).is_none() => Some((target, fire)),
        _ => None,
    });
    let open = open.flat_map(|(target, fire)| {
        // A look cannot begin before the vehicle can arrive.
        let way_s = geodesy::distance_m(start, target.position) / mission.model.true_airspeed_m_s_cruise;
        fire.looks().filter(|(name, _)| is_open(name)).map(move |(name, look)| {
            let from_s = timing::first_s(look, at.seconds() + way_s);
            (name, Wish { mission, target, fire, look, approach: start, from_s, is_explained })
        })
    });
    let open: Vec<(String, Wish<'_>)> = open.collect();
    let ways = on_all_processors(open.len(), |number| open.get(number).map(|(_, wish)| manoeuvres::of(wish)));
    let (mut targets, mut after, mut troubles) = (Vec::new(), Vec::new(), Vec::new());
    let mut passed: Vec<&String> = Vec::new();
    for ((name, Wish { target, fire, look, .. }), manoeuvres) in open.into_iter().zip(ways.into_iter().flatten()) {
        let result = flown.and_then(|flown| flown.result(&target.id));
        let result = result.as_ref().and_then(|result| result.looks.iter().find(|seen| seen.name == look.name));
        // It was seen in passing, which fulfils orders that name its target.
        if result.is_some_and(is_complete) {
            passed.push(&target.id);
            continue;
        }
        let seen = result.map_or(0.0, |seen| seen.factors.product() * look.value);
        let manoeuvres = match manoeuvres {
            Ok(manoeuvres) => manoeuvres,
            Err(why) => {
                troubles.push(format!("{name}: no way to observe it: {why}"));
                continue;
            }
        };
        let (shortest_s, line_s) = durations_s(&manoeuvres);
        let times_s = (at.seconds(), shortest_s, line_s);
        after.extend(fire.wanted.after.iter().map(|need| (need.target.clone(), name.clone())));
        targets.push(SingleVisitTarget {
            position: target.position,
            value: (look.value - seen).max(0.0),
            must: must_visit(look, seen),
            manoeuvres,
            windows: timing::begins_after(look, &seen_s(situation, fire, &name)),
            light: timing::hard_light(look),
            timing: timing::table(mission, target, look, times_s, GroundArrival::AfterWayHome),
            name,
        });
    }
    match (targets.is_empty(), troubles.is_empty()) {
        (true, true) => return Err(NoPlan::NothingLeft("no known target is left to observe".to_string())),
        (true, false) => return Err(NoPlan::Fault(troubles.join("; "))),
        (false, _) => {}
    }
    // An order that names an observed target is fulfilled; of several looks, the first one in the data must come first.
    let first_look = |id: &String| {
        let of_target = |target: &&SingleVisitTarget| {
            target.name == *id || target.name.strip_prefix(id.as_str()).is_some_and(|rest| rest.starts_with('/'))
        };
        let seen = situation.observed().any(|visit| {
            visit.target == *id || visit.target.strip_prefix(id.as_str()).is_some_and(|rest| rest.starts_with('/'))
        });
        targets.iter().find(of_target).filter(|_| !seen && !passed.contains(&id)).map(|target| target.name.clone())
    };
    let precedence = after.iter().filter_map(|(earlier, later)| Some((first_look(earlier)?, later.clone()))).collect();
    Ok((targets, precedence))
}

/// Returns what missing a look costs; `None` if what was seen so far, worth `seen`, suffices.
fn must_visit(look: &WantedLook, seen: f64) -> Option<MustVisit> {
    let seen_share = if look.value > 0.0 { seen / look.value } else { 0.0 };
    let must = look.must.filter(|must| seen_share <= must.factor_min)?;
    Some(MustVisit { factor_min: must.factor_min, cost: must.cost })
}

/// Returns begin and end of the observations of a fire's other looks.
fn seen_s(situation: &Situation, fire: &Fire, name: &str) -> Vec<(f64, f64)> {
    let is_sibling = |target: &str| target != name && fire.looks().any(|(other, _)| other == target);
    let visits = situation.observed().filter(|visit| is_sibling(&visit.target));
    visits.filter_map(|visit| Some((visit.begin.seconds(), visit.end?.seconds()))).collect()
}

/// Returns the time of the shortest manoeuvre, and of one of its lines: a scanner's lines are sent as a whole, pictures one by one (0).
fn durations_s(manoeuvres: &[Manoeuvre]) -> (f64, f64) {
    let shortest = manoeuvres.iter().min_by(|a, b| a.duration_s.total_cmp(&b.duration_s));
    let lines = shortest.filter(|manoeuvre| manoeuvre.pictures.is_none());
    let line_s = lines.map_or(0.0, |manoeuvre| manoeuvre.duration_s / manoeuvre.lines.len().max(1) as f64);
    (shortest.map_or(f64::INFINITY, |manoeuvre| manoeuvre.duration_s), line_s)
}

/// Returns the problem with timing factors for images that reach the ground as `arrival` states for each look, by its name in plans.
pub(crate) fn with_landing(
    mission: &Mission,
    problem: &SingleVisitProblem,
    arrival: &dyn Fn(&str) -> GroundArrival,
) -> SingleVisitProblem {
    let mut problem = problem.clone();
    for target in &mission.targets {
        let TargetKind::Fire(fire) = &target.kind else { continue };
        for (name, look) in fire.looks().filter(|(_, look)| look.latency.is_some()) {
            let Some(posed) = problem.targets.iter_mut().find(|posed| posed.name == name) else { continue };
            let (shortest_s, line_s) = durations_s(&posed.manoeuvres);
            let times_s = (problem.start_s, shortest_s, line_s);
            posed.timing = timing::table(mission, target, look, times_s, arrival(&name));
        }
    }
    problem
}

/// Returns the reason for which a look cannot be observed from the mission's start, with the nearest possibility; `None` if it can.
pub(crate) fn trouble(mission: &Mission, target: &super::Target, name: &str) -> Option<String> {
    let TargetKind::Fire(fire) = &target.kind else { return site_pictures::trouble(mission, target) };
    let (_, look) = fire.looks().find(|(of_look, _)| of_look == name)?;
    let wish = Wish {
        mission,
        target,
        fire,
        look,
        approach: mission.start,
        from_s: timing::first_s(look, 0.0),
        is_explained: false,
    };
    manoeuvres::trouble(&wish)
}

/// Returns the problem of the visits that can give a valid picture.
fn surveillance(mission: &Mission, situation: &Situation, at: Time) -> Result<SurveillanceProblem, NoPlan> {
    let mut problem = every_visit(mission, situation, at)?;
    let troubles: Vec<(usize, String)> = sites(mission)
        .enumerate()
        .filter_map(|(index, site)| Some((index, site_pictures::trouble(mission, site)?)))
        .collect();
    if let Some((_, why)) = troubles.first().filter(|_| troubles.len() == problem.targets.len()) {
        return Err(NoPlan::NothingLeft(format!("no visit of any site can give a valid picture: {why}")));
    }
    troubles.iter().for_each(|(index, _)| problem.travel.shut(*index));
    if let Some(daylight) = Daylight::next(mission, at.seconds()).map_err(NoPlan::NothingLeft)? {
        daylight.restrict(&mut problem, at.seconds());
    }
    Ok(problem)
}

fn every_visit(mission: &Mission, situation: &Situation, at: Time) -> Result<SurveillanceProblem, NoPlan> {
    let now_s = at.seconds();
    let mut targets = Vec::new();
    let mut positions = Vec::new();
    for target in &mission.targets {
        let TargetKind::Site(site) = &target.kind else { continue };
        positions.push(target.position);
        targets.push(site_target(target, site, situation, now_s));
    }
    let mut travel = survey(mission, &positions, here(mission, situation), now_s).map_err(NoPlan::Fault)?.times;
    for (index, target) in targets.iter().enumerate() {
        if mission.weak_reason(&target.name).is_some() {
            travel.shut(index);
        }
    }
    let energy = energy(mission, situation);
    let endurance_s = situation.vehicle.endurance_s.map(|_| (energy.endurance_s - energy.reserve_s).max(0.0));
    Ok(SurveillanceProblem {
        targets,
        travel,
        horizon_s: (mission.settings.duration - mission.settings.watch_margin).seconds() - now_s,
        return_to_base: false,
        endurance_s,
    })
}

/// Plans state the bends of ways to about a metre, and a vehicle reaches them within about a metre. Planned ways keep this much more
/// from obstacles, so that a vehicle at a stated bend may fly the next leg.
const STATED_M: f64 = 2.0;

/// Returns the ways between the sites at `positions`, around zones, for a plan that begins at `now_s` of mission time.
///
/// # Errors
/// A message that names the invalid zone, start or base.
pub fn survey(
    mission: &Mission,
    positions: &[Position],
    start: Position,
    now_s: f64,
) -> Result<SurveillanceTravel, String> {
    let heights = sites(mission).map(|site| visit_altitude_m(mission, site));
    let (low_m, high_m) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (f64::min(l, m), f64::max(h, m)));
    let transit = Transit {
        true_airspeed_mps: mission.model.true_airspeed_m_s_cruise,
        turn_radius_m: mission.model.turns.circle_width * turn_radius_m(&mission.model),
        altitude_m: high_m,
        wind: &mission.forecast,
        time_s: now_s,
        until_s: mission.settings.duration.seconds(),
        zones: &mission.zones,
        margin_m: mission.requirements.obstacle_margin_m + STATED_M,
        altitudes_m: (low_m, high_m),
    };
    SurveillanceTravel::new(start, positions, mission.start, &transit)
}

fn site_target(target: &super::Target, site: &Site, situation: &Situation, now_s: f64) -> SurveillanceTarget {
    let seen = situation.observed().filter(|visit| visit.target == target.id).filter_map(|visit| visit.end).max();
    SurveillanceTarget {
        name: target.id.clone(),
        position: target.position,
        dwell_s: site.dwell_s,
        rate: from(&site.rate, now_s),
        cost: site.cost.clone(),
        initial_age_s: now_s - seen.map_or(-site.initial_age_s, Time::seconds),
    }
}

/// Returns the rate in a time that begins at `now_s`.
fn from(rate: &EventRate, now_s: f64) -> EventRate {
    let now = std::iter::once((0.0, rate.at(now_s)));
    let later = rate.steps.iter().filter(|(from_s, _)| *from_s > now_s).map(|(from_s, rate)| (from_s - now_s, *rate));
    EventRate { steps: now.chain(later).collect() }
}

/// Returns a zone whose lower and upper faces are moved by the distance that the flight must keep from them, so that a plan that avoids it
/// raises no alarm. A lower face at sea level is the ground, and stays.
fn grown(zone: &AirspaceZone, mission: &Mission) -> AirspaceZone {
    let height_m = mission.requirements.airspace.map_or(0.0, |buffer| buffer.vertical_m);
    let out_m = if zone.kind == ZoneKind::Restricted { height_m } else { -height_m };
    let (low_m, high_m) = (zone.altitude_m_min, zone.altitude_m_max);
    let low_m = if low_m > 0.0 { low_m - out_m } else { low_m };
    AirspaceZone { altitude_m_min: low_m, altitude_m_max: (high_m + out_m).max(low_m), ..zone.clone() }
}

/// Returns a zone that closes the airspace earlier, and opens it later, by the error that paths in flight assume for the time at which a
/// zone is passed: a visit planned to the last second would have no path. For the opening the least error counts, because a vehicle can
/// wait. A closing is moved by at most half of the time until then.
fn timed(zone: &AirspaceZone, now_s: f64) -> AirspaceZone {
    let TimeWindow { from_s, until_s } = zone.active;
    let closed_s = |time_s: f64| {
        let ahead_s = (time_s - now_s).max(0.0);
        if time_s < FOREVER_S { time_s - time_error_s(ahead_s).min(0.5 * ahead_s) } else { time_s }
    };
    let opened_s = |time_s: f64| if (now_s..FOREVER_S).contains(&time_s) { time_s + time_error_s(0.0) } else { time_s };
    let active = match zone.kind {
        ZoneKind::Restricted => TimeWindow { from_s: closed_s(from_s), until_s: opened_s(until_s) },
        ZoneKind::Permitted => TimeWindow { from_s: opened_s(from_s), until_s: closed_s(until_s) },
    };
    AirspaceZone { active, ..zone.clone() }
}

#[cfg(test)]
mod tests {
    use super::limits::end_before_margin_s;
    use super::*;

    #[test]
    fn the_margin_at_the_end_shrinks_with_the_time_left() {
        assert_eq!(end_before_margin_s(86_400.0, 3_600.0, 0.0), 82_800.0);
        assert_eq!(end_before_margin_s(86_400.0, 3_600.0, 64_800.0), 84_600.0);
        assert_eq!(end_before_margin_s(86_400.0, 3_600.0, 90_000.0), 86_400.0);
    }

    fn zone(kind: ZoneKind, (from_s, until_s): (f64, f64)) -> AirspaceZone {
        let (name, active) = ("z".to_string(), TimeWindow { from_s, until_s });
        AirspaceZone { name, kind, corners: Vec::new(), altitude_m_min: 0.0, altitude_m_max: 1_000.0, active }
    }

    #[test]
    fn times_of_zones_are_as_uncertain_as_ways_in_flight_take_them() {
        let active = |kind, times, now_s| {
            let TimeWindow { from_s, until_s } = timed(&zone(kind, times), now_s).active;
            (from_s, until_s)
        };
        // 2 minutes and a tenth of the time until then, at most 15 minutes.
        assert_eq!(active(ZoneKind::Restricted, (3_600.0, 7_200.0), 0.0), (3_120.0, 7_320.0));
        assert_eq!(active(ZoneKind::Restricted, (36_000.0, 72_000.0), 0.0), (35_100.0, 72_120.0));
        assert_eq!(active(ZoneKind::Permitted, (3_600.0, 7_200.0), 0.0), (3_720.0, 6_360.0));
        // The error shrinks as the closing approaches, so a visit that was planned before remains possible.
        assert_eq!(active(ZoneKind::Restricted, (3_600.0, 7_200.0), 3_000.0), (3_420.0, 7_320.0));
        assert_eq!(active(ZoneKind::Restricted, (3_600.0, 7_200.0), 3_500.0), (3_550.0, 7_320.0));
        for always in [(0.0, FOREVER_S), (-FOREVER_S, FOREVER_S)] {
            assert_eq!(active(ZoneKind::Restricted, always, 10.0), always);
            assert_eq!(active(ZoneKind::Permitted, always, 10.0), always);
        }
    }

    #[test]
    fn a_rate_continues_from_now() {
        let rate = EventRate { steps: vec![(0.0, 1.0), (100.0, 2.0), (300.0, 3.0)] };
        assert_eq!(from(&rate, 0.0).steps, rate.steps);
        assert_eq!(from(&rate, 150.0).steps, [(0.0, 2.0), (150.0, 3.0)]);
        assert_eq!(from(&rate, 300.0).steps, [(0.0, 3.0)]);
    }
}

//! From a mission and its state now to a planning problem.

use super::situation::Situation;
use super::{Fire, Mission, Site, TargetKind};
use crate::vehicle::{Airframe, VehicleModel, line_scanner};
use apex_geo::coverage::{Ground, LineFlight, LineScanner, ObservationWish, fly_lines, sweep_manoeuvre};
use apex_geo::perimeter::perimeter_manoeuvre;
use apex_geo::travel;
use apex_model::problem::{
    EventRate, Manoeuvre, Position, Problem, SingleVisitProblem, SingleVisitTarget, SingleVisitVehicle,
    SurveillanceProblem, SurveillanceTarget, WindField,
};
use apex_model::time::Time;
use apex_planning::surveillance::travel::{Transit, Ways};

/// Why there is no plan. Only the first kind is a reason to end a mission in progress and go home.
#[derive(Debug, Clone, PartialEq)]
pub enum NoPlan {
    /// Nothing that is left can be visited.
    NothingLeft(String),
    /// The planning itself went wrong: a refused plan, an unknown solver, data that make no sense.
    Fault(String),
}

impl std::fmt::Display for NoPlan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (NoPlan::NothingLeft(reason) | NoPlan::Fault(reason)) = self;
        f.write_str(reason)
    }
}

/// The problem that a plan of the mission, as it is believed at `at`, has to solve: what has been observed already is left out.
///
/// # Errors
/// Nothing is left to plan for, or the data make no sense.
pub fn pose(mission: &Mission, situation: &Situation, at: Time) -> Result<Problem, NoPlan> {
    if mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_))) {
        single_visit(mission, situation, at).map(Problem::SingleVisit)
    } else {
        surveillance(mission, situation, at).map(Problem::Surveillance)
    }
}

/// Where the vehicle is, as far as is known.
pub(super) fn here(mission: &Mission, situation: &Situation) -> Position {
    situation.vehicle.position.unwrap_or(mission.start)
}

fn single_visit(mission: &Mission, situation: &Situation, at: Time) -> Result<SingleVisitProblem, NoPlan> {
    let model = &mission.model;
    let planning = &model.planning;
    let now_s = at.seconds();
    let fuel_kg = situation.vehicle.fuel_kg.unwrap_or(model.fuel.capacity_kg);
    let endurance_s = situation.vehicle.endurance_s.unwrap_or(fuel_kg / model.fuel.flow_kg_h_reference * 3600.0);
    let start = here(mission, situation);
    let open: Vec<&super::Target> =
        mission.targets.iter().filter(|target| !situation.observed().any(|visit| visit.target == target.id)).collect();
    if open.is_empty() {
        return Err(NoPlan::NothingLeft("no known target is left to observe".to_string()));
    }
    let mut precedence = Vec::new();
    let mut targets = Vec::new();
    for target in &open {
        let TargetKind::Fire(fire) = &target.kind else { continue };
        // An order that names a target already observed is fulfilled.
        let pending = fire.after.iter().filter(|earlier| open.iter().any(|other| other.id == **earlier));
        precedence.extend(pending.map(|earlier| (earlier.clone(), target.id.clone())));
        targets.push(SingleVisitTarget {
            name: target.id.clone(),
            position: target.position,
            value: fire.value,
            manoeuvres: manoeuvres(mission, target, fire, start, now_s).map_err(NoPlan::Fault)?,
            windows: fire.windows.clone(),
            light: fire.light,
            timing: Vec::new(),
        });
    }
    Ok(SingleVisitProblem {
        targets,
        vehicle: SingleVisitVehicle {
            true_airspeed_mps: model.true_airspeed_m_s_cruise,
            cruise_altitude_m: planning.cruise_altitude_m,
            climb_rate_mps: model.climb_rate_m_s_max * planning.climb_share,
            descent_rate_mps: model.descent_rate_m_s_max * planning.descent_share,
            fuel_kg,
            fuel_reserve_kg: model.fuel.capacity_kg * planning.reserve_share,
            fuel_flow_kg_per_s: model.fuel.flow_kg_h_reference / 3600.0,
            endurance_s,
            endurance_reserve_s: mission.settings.duration.seconds() * planning.reserve_share,
            turn_radius_m: turn_radius_m(model),
        },
        start,
        start_altitude_m: situation.vehicle.altitude_m.max(mission.start_altitude_m),
        start_s: now_s,
        base: Some(mission.start),
        end_s: Some(mission.settings.duration.seconds() - mission.settings.end_margin.seconds()),
        zero_unix_s: mission.settings.epoch_unix_s.unwrap_or(0.0),
        precedence,
        zones: mission.zones.clone(),
        zone_margin_m: mission.settings.zone_margin_m,
        landing_places: mission.landing_places(),
        landing_distance_m_max: mission.settings.landing_distance_m_max,
        wind: mission.forecast.clone(),
        crew: mission.crew.clone(),
        failure: mission.failure,
        travel: None,
    })
}

/// Least radius of the turns that a plan counts on; 0 for who turns on the spot.
pub fn turn_radius_m(model: &VehicleModel) -> f64 {
    match model.airframe {
        Airframe::FixedWing => travel::turn_radius_m(
            model.true_airspeed_m_s_cruise,
            (model.turns.bank_share * model.bank_deg_max).to_radians(),
        ),
        Airframe::Rotorcraft => 0.0,
    }
}

/// One sweep for each altitude that the vehicle can hold, best product of factors first; worse and slower ones are
/// dropped.
fn manoeuvres(
    mission: &Mission,
    target: &super::Target,
    fire: &Fire,
    approach: Position,
    now_s: f64,
) -> Result<Vec<Manoeuvre>, String> {
    let Some((scanner, carried)) = line_scanner(&mission.model).zip(mission.model.scanner.as_ref()) else {
        let name = &mission.model.name;
        return Err(format!("{}: no way to observe it: the vehicle `{name}` carries no line scanner", target.id));
    };
    let grounds: Vec<Ground> = if target.polygons.is_empty() {
        vec![Ground::Circle { centre: target.position, radius_m: fire.radius_m }]
    } else {
        target.polygons.iter().cloned().map(Ground::Polygon).collect()
    };
    let mut made: Vec<Manoeuvre> = Vec::new();
    let mut reason = String::new();
    for height_m in &carried.heights_m {
        let altitude_m = target.elevation_m + height_m;
        if altitude_m > mission.model.ceiling_m * mission.model.planning.ceiling_share {
            continue;
        }
        let flight = LineFlight {
            altitude_m,
            true_airspeed_mps: mission.model.true_airspeed_m_s_cruise,
            bank_deg: mission.model.bank_deg_max,
            start_s: now_s,
        };
        match sweep(&grounds, target.elevation_m, fire, &scanner, &flight, &mission.forecast, approach) {
            Ok(mut manoeuvre) => {
                // The turn onto the first line is part of the way to it; each further line is met antiparallel and close by.
                let further = manoeuvre.lines.len().saturating_sub(1) as f64;
                manoeuvre.duration_s += carried.first_join_s + carried.further_join_s * further;
                made.push(manoeuvre);
            }
            Err(error) => reason = error,
        }
    }
    // Of equally good ones the first stays: in calm air altitudes may make no difference.
    let better = |(number, a): (usize, &Manoeuvre), (other, b): (usize, &Manoeuvre)| {
        let (a, b) = ((a.quality.product(), -a.duration_s), (b.quality.product(), -b.duration_s));
        a.0 >= b.0 && a.1 >= b.1 && (a != b || number < other)
    };
    let all = || made.iter().enumerate();
    let kept: Vec<Manoeuvre> =
        all().filter(|each| !all().any(|other| better(other, *each))).map(|(_, each)| each.clone()).collect();
    if kept.is_empty() { Err(format!("{}: no way to observe it: {reason}", target.id)) } else { Ok(kept) }
}

/// The sweeps of all parts of a target one after the other; worst quality of the parts.
fn sweep(
    grounds: &[Ground],
    elevation_m: f64,
    fire: &Fire,
    scanner: &LineScanner,
    flight: &LineFlight,
    forecast: &WindField,
    approach: Position,
) -> Result<Manoeuvre, String> {
    let mut whole: Option<Manoeuvre> = None;
    let mut entry = approach;
    for ground in grounds {
        let wish = ObservationWish {
            ground: ground.clone(),
            ground_elevation_m: elevation_m,
            resolution_m: fire.resolution_m,
        };
        let swept = sweep_manoeuvre(&wish, scanner, flight, forecast, entry)?;
        // Where the outline is all that is wanted, flying along it may be quicker than sweeping what it encloses.
        let along = fire.perimeter_only.then(|| perimeter_manoeuvre(&wish, scanner, flight, forecast, entry));
        let part = match along {
            Some(Ok(along)) if along.duration_s < swept.duration_s => along,
            _ => swept,
        };
        entry = part.lines.last().map_or(entry, |(_, exit)| *exit);
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => {
                if part.quality.product() < whole.quality.product() {
                    whole.quality = part.quality;
                }
                whole.lines.extend(part.lines);
                (whole.duration_s, whole.length_m) = fly_lines(&whole.lines, flight, forecast)?;
            }
        }
    }
    whole.ok_or_else(|| "there is nothing to see".to_string())
}

fn surveillance(mission: &Mission, situation: &Situation, at: Time) -> Result<SurveillanceProblem, NoPlan> {
    let now_s = at.seconds();
    let mut targets = Vec::new();
    let mut positions = Vec::new();
    for target in &mission.targets {
        let TargetKind::Site(site) = &target.kind else { continue };
        positions.push(target.position);
        targets.push(site_target(target, site, situation, now_s));
    }
    let travel = survey(mission, &positions, here(mission, situation), now_s).map_err(NoPlan::Fault)?.times;
    let endurance_s = situation.vehicle.endurance_s.map(|left| left * (1.0 - mission.model.planning.reserve_share));
    Ok(SurveillanceProblem {
        targets,
        travel,
        horizon_s: mission.settings.duration.seconds() - now_s,
        return_to_base: false,
        endurance_s,
    })
}

fn sites(mission: &Mission) -> impl Iterator<Item = &super::Target> {
    mission.targets.iter().filter(|target| matches!(target.kind, TargetKind::Site(_)))
}

/// Altitude above mean sea level from which a site is looked at.
pub fn visit_altitude_m(mission: &Mission, site: &super::Target) -> f64 {
    match mission.model.airframe {
        Airframe::Rotorcraft => site.elevation_m + mission.model.planning.visit_height_m,
        Airframe::FixedWing => {
            let planning = &mission.model.planning;
            let highest_m = sites(mission).map(|site| site.elevation_m).fold(f64::NEG_INFINITY, f64::max);
            (highest_m + planning.visit_height_m).min(planning.ceiling_share * mission.model.ceiling_m)
        }
    }
}

/// The ways between the sites at `positions`, around obstacles, for a plan that begins at `now_s`.
///
/// # Errors
/// A sentence that names what is wrong with a zone, the start or the base.
pub fn survey(mission: &Mission, positions: &[Position], start: Position, now_s: f64) -> Result<Ways, String> {
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
        margin_m: mission.settings.obstacle_margin_m,
        altitudes_m: (low_m, high_m),
    };
    Ways::new(start, positions, mission.start, &transit)
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

/// The rate in a time that begins at `now_s`.
fn from(rate: &EventRate, now_s: f64) -> EventRate {
    let now = std::iter::once((0.0, rate.at(now_s)));
    let later = rate.steps.iter().filter(|(from_s, _)| *from_s > now_s).map(|(from_s, rate)| (from_s - now_s, *rate));
    EventRate { steps: now.chain(later).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_goes_on_from_now() {
        let rate = EventRate { steps: vec![(0.0, 1.0), (100.0, 2.0), (300.0, 3.0)] };
        assert_eq!(from(&rate, 0.0).steps, rate.steps);
        assert_eq!(from(&rate, 150.0).steps, [(0.0, 2.0), (150.0, 3.0)]);
        assert_eq!(from(&rate, 300.0).steps, [(0.0, 3.0)]);
    }
}

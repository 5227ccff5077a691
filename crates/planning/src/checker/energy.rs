//! Independent arithmetic of climbs and of flight in thin air.

use apex_model::problem::{SingleVisitPlan, SingleVisitProblem};
use std::borrow::Cow;

/// Returns the problem with the speed and the turns of flight at an altitude, to which a vehicle changes when it leaves a place.
pub(super) fn at_altitude(problem: &SingleVisitProblem, altitude_m: f64) -> Cow<'_, SingleVisitProblem> {
    let mut levels = problem.vehicle.thin_air.iter().rev();
    let Some(level) = levels.find(|level| level.altitude_m <= altitude_m) else { return Cow::Borrowed(problem) };
    let mut there = problem.clone();
    let ratio = level.true_airspeed_mps / problem.vehicle.true_airspeed_mps;
    there.vehicle.true_airspeed_mps = level.true_airspeed_mps;
    there.vehicle.turn_radius_m *= ratio * ratio;
    Cow::Owned(there)
}

/// Returns the seconds of flight whose energy flight in thin air takes beyond that in cruise; waits and given times are not in thin air.
pub(super) fn thin_air_s(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> f64 {
    let mut extra_s = 0.0;
    if problem.travel.is_some() {
        return extra_s;
    }
    let excess = |altitude_m: f64| {
        let level = problem.vehicle.thin_air.iter().rev().find(|level| level.altitude_m <= altitude_m);
        level.map_or(0.0, |level| level.drain_share - 1.0)
    };
    for visit in &plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        if let Some(manoeuvre) = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre)) {
            let flown_s = visit.arrive_s - visit.depart_s + manoeuvre.duration_s;
            extra_s += excess(manoeuvre.altitude_m) * flown_s;
        }
    }
    if problem.base.is_some() && !plan.return_route.is_empty() {
        extra_s += excess(problem.vehicle.cruise_altitude_m) * (plan.end_s - plan.return_depart_s);
    }
    extra_s
}

/// Returns the metres climbed after the first climb, which leads to cruise altitude at least.
pub(super) fn climbed_m(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> f64 {
    let cruise_m = problem.vehicle.cruise_altitude_m;
    let (mut altitude_m, mut climbed_m) = (problem.start_altitude_m.max(cruise_m), 0.0);
    let mut level = |next_m: f64| {
        climbed_m += if next_m > altitude_m { next_m - altitude_m } else { 0.0 };
        altitude_m = next_m;
    };
    for visit in &plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        if let Some(manoeuvre) = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre)) {
            level(manoeuvre.altitude_m);
        }
    }
    if problem.base.is_some() {
        level(cruise_m);
    }
    climbed_m
}

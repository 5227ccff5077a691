//! Plans that must also end in time in the wind as measured.
//!
//! Planners plan by the forecast, with a margin at the end of the mission for delays. If the plan would exceed this margin in
//! the wind that was measured, the mission is planned again by the measured wind.

use super::landing::solve_for_landing;
use super::operator_plan::HUMAN;
use super::solve::{Deliberation, PLAN_VISITS_MAX, SolveOptions};
use crate::Mission;
use crate::descent::Descent;
use crate::problem::{NoPlan, limits};
use apex_model::problem::{Light, Plan, Problem, SingleVisitProblem, SingleVisitVehicle, WindField};
use apex_planning::solver::{Environment, WorkBudget, units_in};
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use apex_solvers::planners::human::brought;
use apex_vehicle::EnergyModel;

/// Share of the margin for delays that plans by the measured wind keep.
const REST_SHARE: f64 = 0.1;
/// Endurance that limits no flight, to compute times regardless of energy.
const ENDLESS_S: f64 = 1e9;

/// Like [`solve_for_landing`], for the forecast and for the wind as measured; `None`: nothing was measured.
///
/// # Errors
/// Like [`solve_for_landing`].
pub(super) fn solve_for_wind(
    mission: &Mission,
    (problem, measured): (Problem, Option<WindField>),
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let SolveOptions { means, solver, budget, seed, .. } = &wish;
    let (means, solver, budget, seed, previous) = (*means, *solver, *budget, *seed, wish.previous.clone());
    let by_wind = measured.zip(single_visits(&problem).cloned()).filter(|_| solver != Some(HUMAN));
    let first = solve_for_landing(Some(mission), problem, wish, invocations, cancel);
    let Some((wind, posed)) = by_wind else { return first };
    let believed = Mission { forecast: wind.clone(), ..mission.clone() };
    let latest_s = latest_s(&believed, &posed);
    let vehicle = with_landing_reserve(posed.vehicle.clone(), mission, &believed);
    let end_limit = limits::end(&believed, posed.start_s, mission.settings.duration.seconds());
    let end_s_with_rest = Some(end_with_rest_s(mission, &posed, latest_s));
    let windy = SingleVisitProblem { wind, vehicle, end_s: end_s_with_rest, end_limit, ..posed };
    match &first {
        Err(NoPlan::Fault(_)) => return first,
        // The measured wind may permit visits: it may be better than the forecast, and it needs a smaller margin.
        Err(NoPlan::NothingLeft(_)) => {}
        Ok(first_plan) => {
            let is_in_time =
                |problem: &SingleVisitProblem| end_s(problem, &first_plan.plan, seed).map(|end_s| end_s <= latest_s);
            // If an arrival misses its window, the time without windows counts; if there is no path, the plan is not in time.
            if is_in_time(&windy).or_else(|| is_in_time(&without_windows(&windy))) == Some(true) {
                return first;
            }
        }
    }
    let wish = SolveOptions { means, solver, budget, seed, previous };
    let second = solve_for_landing(Some(&believed), Problem::SingleVisit(windy), wish, invocations, cancel);
    match (first, second) {
        (Err(first), Err(NoPlan::NothingLeft(_))) => Err(first),
        (_, Err(second)) => Err(second),
        (first, Ok(second)) => {
            let reason =
                format!("{}; planned by the measured wind, because it differs from the forecast", second.reason);
            let work = first.map_or(0, |first| first.work) + second.work;
            Ok(Deliberation { reason, work, ..second })
        }
    }
}

/// Returns the latest end of plans by the measured wind: the margin for delays includes errors of the forecast, which no longer count, so
/// only [`REST_SHARE`] of it is kept.
fn end_with_rest_s(mission: &Mission, problem: &SingleVisitProblem, latest_s: f64) -> f64 {
    let by_forecast_s = problem.end_s.unwrap_or(latest_s);
    latest_s - REST_SHARE * (latest_s - by_forecast_s).clamp(0.0, mission.settings.end_margin.seconds())
}

/// Returns the vehicle with the reserve over the base for a landing in the wind as measured.
fn with_landing_reserve(mut vehicle: SingleVisitVehicle, mission: &Mission, believed: &Mission) -> SingleVisitVehicle {
    let more = Descent::to_base(believed).energy - Descent::to_base(mission).energy;
    vehicle.endurance_reserve_s += more / mission.model.drain_planned_per_s(mission.cruise_altitude_m());
    if matches!(mission.model.energy, EnergyModel::Fuel(_)) {
        vehicle.fuel_reserve_kg += more;
    }
    vehicle.endurance_limit = limits::endurance(believed, &vehicle);
    vehicle
}

/// Returns the problem without windows, light, timing factors and precedence: only travel and manoeuvres take time.
fn without_windows(problem: &SingleVisitProblem) -> SingleVisitProblem {
    let mut problem = SingleVisitProblem { precedence: Vec::new(), ..problem.clone() };
    for target in &mut problem.targets {
        (target.windows, target.light, target.timing) = (Vec::new(), Light::Any, Vec::new());
    }
    problem
}

fn single_visits(problem: &Problem) -> Option<&SingleVisitProblem> {
    match problem {
        Problem::SingleVisit(problem) => Some(problem),
        Problem::Surveillance(_) => None,
    }
}

/// Returns the latest arrival over the base after which the vehicle still lands as early as required, and with its reserve.
fn latest_s(mission: &Mission, problem: &SingleVisitProblem) -> f64 {
    let before_s = mission.requirements.landed_before_end_s.unwrap_or(0.0);
    let open_s = mission.settings.duration.seconds().min(limits::base_open_until_s(mission, problem.start_s));
    let ends_s = open_s - before_s - Descent::to_base(mission).time_s;
    let vehicle = &problem.vehicle;
    let endurance_s = vehicle.endurance_s - vehicle.endurance_reserve_s;
    let burn_s = match vehicle.fuel_flow_kg_per_s {
        flow if flow > 0.0 => (vehicle.fuel_kg - vehicle.fuel_reserve_kg) / flow,
        _ => f64::INFINITY,
    };
    ends_s.min(problem.start_s + endurance_s.min(burn_s))
}

/// Returns the end of the plan's visits in their order, in the wind of the problem, regardless of the limits of time and energy; `None` if
/// they cannot be flown at all.
fn end_s(windy: &SingleVisitProblem, plan: &Plan, seed: u64) -> Option<f64> {
    let mut endless = SingleVisitProblem { end_s: None, ..windy.clone() };
    (endless.vehicle.endurance_s, endless.vehicle.fuel_flow_kg_per_s) = (ENDLESS_S, 0.0);
    let endless = Problem::SingleVisit(endless);
    let mut budget = WorkBudget::new(units_in(apex_model::time::Duration::from_seconds(1.0)));
    let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
    if plan.targets().len() > PLAN_VISITS_MAX {
        return None;
    }
    match brought::retimed(&endless, plan, &mut environment).ok()? {
        Plan::SingleVisit(plan) => Some(plan.end_s),
        Plan::Surveillance(_) => None,
    }
}

//! Plans whose images are read after the landing: the landing is a result of the plan, and what an image is worth depends on it.
//!
//! Planners assume that an image arrives after the direct way home from its target, which is true for the last target only. The plan that
//! they make, and the same visits in the opposite order, are therefore scored with their own landing; the better one is used.

use super::intervals::solve_with_intervals;
use super::operator_plan::{self, HUMAN};
use super::solve::{Deliberation, SolveOptions, solve};
use crate::descent::Descent;
use crate::problem::{GroundArrival, NoPlan, with_landing};
use crate::situation::OperatorPlan;
use crate::{Mission, TargetKind};
use apex_geo::wind;
use apex_model::problem::{Plan, Problem, SingleVisitPlan};
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use apex_solvers::planners::human::brought;
use apex_solvers::planners::single_visit;

/// Like [`solve`], but a plan of a mission whose images are read after the landing is scored with its own landing.
///
/// # Errors
/// Like [`solve`].
pub fn solve_for_landing(
    mission: Option<&Mission>,
    problem: Problem,
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let all = problem.clone();
    solve_for_own_landing(mission, problem, wish, invocations, cancel).map(|solved| bounded(all, solved))
}

/// Returns the plan with a bound for all plans of `all`, if the plan was made in a problem that excludes some of them.
fn bounded(all: Problem, mut solved: Deliberation) -> Deliberation {
    if all == solved.problem {
        return solved;
    }
    if let (Problem::SingleVisit(all), Plan::SingleVisit(plan)) = (&all, &mut solved.plan) {
        *plan = single_visit::bounded_by(all, plan.clone());
    }
    if let Err(contradiction) = apex_solvers::bounds::state(&all, &mut solved.plan) {
        // The plan passed the check and can be flown; only its bound is wrong.
        solved.reason = format!("{}; {contradiction}", solved.reason);
    }
    Deliberation { whole: Some(all), ..solved }
}

fn solve_for_own_landing(
    mission: Option<&Mission>,
    problem: Problem,
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let Some(mission) = mission.filter(|mission| counts(mission, &problem)) else {
        return solve_with_intervals(mission, problem, wish, invocations, cancel);
    };
    let SolveOptions { means, solver, budget, seed, .. } = &wish;
    let (means, solver, budget, seed) = (*means, *solver, *budget, *seed);
    let first = judged(mission, solve_with_intervals(Some(mission), problem.clone(), wish, invocations, cancel)?);
    let visits: Vec<String> = first.plan.targets().iter().rev().map(ToString::to_string).collect();
    // The order that an operator states is kept.
    if visits.len() < 2 || solver == Some(HUMAN) {
        return Ok(first);
    }
    let Ok(means) = operator_plan::means(means, Some(HUMAN), Some(&OperatorPlan { visits, repeat: false })) else {
        return Ok(first);
    };
    let wish = SolveOptions { means: &means, solver: Some(HUMAN), budget, seed, previous: None };
    let Ok(second) = solve(with_windows_of(problem, &first.problem), wish, invocations, cancel) else {
        return Ok(first);
    };
    let second = judged(mission, second);
    let work = first.work + second.work;
    match (&first.plan, second.plan) {
        (Plan::SingleVisit(plan), Plan::SingleVisit(reversed)) if reversed.score > plan.score => {
            let (solver, left_out) = (plan.solver.clone(), plan.left_out.clone());
            let plan = Plan::SingleVisit(SingleVisitPlan { solver, left_out, ..reversed });
            Ok(Deliberation { plan, problem: second.problem, work, ..first })
        }
        _ => Ok(Deliberation { work, ..first }),
    }
}

/// Returns a problem with the targets and windows of the solved one, which follow from intervals between looks.
fn with_windows_of(problem: Problem, solved: &Problem) -> Problem {
    let (Problem::SingleVisit(mut problem), Problem::SingleVisit(solved)) = (problem.clone(), solved) else {
        return problem;
    };
    let of = |name: &str| solved.targets.iter().find(|target| target.name == name);
    problem.targets.retain(|target| of(&target.name).is_some());
    problem.precedence.clone_from(&solved.precedence);
    for target in &mut problem.targets {
        if let Some(solved) = of(&target.name) {
            target.windows.clone_from(&solved.windows);
        }
    }
    Problem::SingleVisit(problem)
}

/// Returns true if the worth of an observation depends on the instant of the landing.
fn counts(mission: &Mission, problem: &Problem) -> bool {
    let Problem::SingleVisit(_) = problem else { return false };
    mission.settings.images_on_ground.is_none()
        && mission.targets.iter().any(|target| match &target.kind {
            TargetKind::Fire(fire) => fire.looks().any(|(_, look)| look.latency.is_some()),
            _ => false,
        })
}

/// Returns the instant at which the vehicle is on the ground. It flies home and descends to cruise altitude on the way, at its full rate;
/// over the base it descends at the rate of plans, because its last turns and the final approach take time.
fn landing_s(mission: &Mission, problem: &Problem, plan: &Plan) -> Option<f64> {
    let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (problem, plan) else { return None };
    let last = plan.visits.last()?;
    let target = problem.targets.iter().find(|target| target.name == last.target)?;
    let altitude_m = target.manoeuvres.get(last.manoeuvre)?.altitude_m;
    let (model, cruise_m) = (&mission.model, mission.cruise_altitude_m());
    let mut legs = plan.return_route.iter().zip(plan.return_route.iter().skip(1));
    let home_s = legs.try_fold(0.0, |flown_s, (from, to)| {
        let at_s = plan.return_depart_s + flown_s;
        let leg_s = wind::leg_time_s(*from, *to, cruise_m, model.true_airspeed_m_s_cruise, &mission.forecast, at_s);
        Some(flown_s + leg_s?)
    });
    let planned_s = plan.end_s - plan.return_depart_s;
    let down_s = (altitude_m - cruise_m).max(0.0) / model.descent_rate_m_s_max;
    let home_s = home_s.map_or(planned_s, |home_s| home_s.max(down_s).min(planned_s));
    let over_base_s = plan.return_depart_s + home_s;
    Some(over_base_s + Descent::to_base_at(mission, over_base_s).time_s)
}

fn posed(mission: &Mission, problem: &Problem, arrival: &dyn Fn(&str) -> GroundArrival) -> Problem {
    match problem {
        Problem::SingleVisit(problem) => Problem::SingleVisit(with_landing(mission, problem, arrival)),
        Problem::Surveillance(_) => problem.clone(),
    }
}

/// Returns the plan scored with its own landing, and the problem in which that landing is the arrival of each image; unchanged if the plan
/// cannot be scored.
fn judged(mission: &Mission, solved: Deliberation) -> Deliberation {
    let Some(landing_s) = landing_s(mission, &solved.problem, &solved.plan) else { return solved };
    let Plan::SingleVisit(plan) = &solved.plan else { return solved };
    let middle_s = |name: &str| {
        let visit = plan.visits.iter().find(|visit| visit.target == name)?;
        Some(0.5 * (visit.begin_s + visit.end_s))
    };
    let arrival = |name: &str| match middle_s(name) {
        Some(middle_s) => GroundArrival::After((landing_s - middle_s).max(0.0)),
        None => GroundArrival::AfterWayHome,
    };
    let problem = posed(mission, &solved.problem, &arrival);
    match brought::scored(&problem, &solved.plan) {
        Ok(Plan::SingleVisit(judged)) => {
            let plan = Plan::SingleVisit(SingleVisitPlan {
                solver: plan.solver.clone(),
                left_out: plan.left_out.clone(),
                ..judged
            });
            Deliberation { problem, plan, ..solved }
        }
        _ => solved,
    }
}

//! The single-visit planner: chooses a subset of targets, their order and manoeuvres for the highest mission score (paper, II.B).
//!
//! A first plan by estimated times (`construct`), greedy insertion by gain per time, then local search (insert,
//! replace, relocate, exchange, reverse, other manoeuvre, wait for a better time, drop), then ruin and re-insertion
//! from the best plan until the search stagnates or the budget is exhausted. During a flight, the search begins from the
//! remainder of the plan in execution. [`schedule`] evaluates all plans: wind, airspace, light, windows, order, fuel and
//! endurance.
//! Bound: the budget. Evaluating a leg takes two units of work, preparing a path some hundreds.

mod companions;
mod construct;
mod exhaust;
mod explain;
mod in_order;
mod moves;
mod order_value;
mod plan;
mod search;
mod time_independent;

pub use in_order::{OrderFault, in_order};
pub use order_value::{OrderValue, OrderedVisit, order_value};
pub(crate) use plan::most;
pub use plan::{bounded_by, scored};

use crate::routing::{schedule, travel};
use apex_model::problem::{Plan, Problem, SingleVisitPlan, SingleVisitProblem};
use apex_planning::meter::Meter;
use apex_planning::obstacle::LeftOutReason;
use apex_planning::solver::{Environment, Solver};
use explain::Troubles;
use std::collections::BTreeMap;

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct SingleVisit;

const NAME: &str = "single-visit";

impl Solver for SingleVisit {
    fn name(&self) -> &'static str {
        NAME
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::SingleVisit(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let previous = match environment.previous {
            Some(Plan::SingleVisit(plan)) => Some(plan),
            _ => None,
        };
        solve(problem, previous, environment)
    }
}

/// Returns the number of paths of a plan, and the time that turns add to their straight legs, in seconds.
///
/// # Errors
/// An error message if a zone is invalid.
pub fn turns_s(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Result<(usize, f64), String> {
    let mut travel = travel::Travel::new(problem)?;
    let (mut here, mut ready_s) = (travel::PointKey::Start, problem.start_s);
    let (mut ways, mut sum_s) = (0, 0.0);
    for visit in &plan.visits {
        let Some(target) = problem.targets.iter().position(|target| target.name == visit.target) else { continue };
        sum_s += travel.turns_s(here, travel::PointKey::Entry(target, visit.manoeuvre), ready_s);
        ways += 1;
        (here, ready_s) = (travel::PointKey::Exit(target, visit.manoeuvre), visit.end_s);
    }
    if problem.base.is_some() && !plan.visits.is_empty() {
        sum_s += travel.turns_s(here, travel::PointKey::Base, ready_s);
        ways += 1;
    }
    Ok((ways, sum_s))
}

fn solve(
    problem: &Problem,
    previous: Option<&SingleVisitPlan>,
    environment: &mut Environment<'_>,
) -> Result<Plan, String> {
    let Problem::SingleVisit(problem) = problem else {
        return Err("the solver `single-visit` accepts problems of single visits only".to_string());
    };
    let mut schedule = schedule::Schedule::new(problem)?;
    let troubles = Troubles::new(&mut schedule);
    let usable = troubles.possible();
    let mut tell = |schedule: &mut schedule::Schedule<'_>, order, environment: &mut Environment<'_>| {
        let best = search::longest_flown(schedule, order);
        if best.order.is_empty() {
            return;
        }
        if let Some(plan) = plan::sketch(schedule, NAME, &best, &troubles) {
            (environment.report)(&Plan::SingleVisit(plan));
        }
    };
    if let Some((best, bound)) = search::enumerated(&mut schedule, &usable, environment) {
        let best = search::or_idle(&mut schedule, best)?;
        let mut plan = plan::plan_of(&mut schedule, NAME, &best, &troubles, explain::left_out)?;
        let bound = bound - problem.miss_costs();
        plan.benefits_bound = Some(plan.benefits_bound.map_or(bound, |other| other.min(bound)));
        plan.summary = plan::summary(problem, &plan);
        return Ok(Plan::SingleVisit(plan));
    }
    let Some(found) = time_independent::run(&mut schedule, &usable, previous, environment, &mut tell) else {
        let best = search::run(&mut schedule, &troubles, previous, environment);
        let best = search::or_idle(&mut schedule, best)?;
        return plan::plan_of(&mut schedule, NAME, &best, &troubles, explain::left_out).map(Plan::SingleVisit);
    };
    let best = search::longest_flown(&mut schedule, found.order);
    let best = search::or_idle(&mut schedule, best)?;
    // With given travel times (benchmarks of a thousand targets) the search itself finds the reasons at low cost. For a flight, the
    // operator needs to know which limit excludes a target.
    let given = problem.travel.is_some();
    let reasons = if given { explain::left_out_quickly } else { explain::left_out };
    let mut plan = plan::plan_of(&mut schedule, NAME, &best, &troubles, reasons)?;
    if let Some(bound) = found.bound.map(|bound| bound - problem.miss_costs()) {
        plan.benefits_bound = Some(plan.benefits_bound.map_or(bound, |other| other.min(bound)));
        plan.summary = plan::summary(problem, &plan);
    }
    let name = |target: usize| problem.targets.get(target).map(|target| target.name.as_str());
    let mut reasons: BTreeMap<&str, LeftOutReason> =
        found.reasons.into_iter().filter_map(|(target, reason)| Some((name(target)?, reason))).collect();
    for left_out in plan.left_out.iter_mut().filter(|_| given) {
        if let Some(reason) = reasons.remove(left_out.target.as_str()) {
            reason.replace_in(left_out);
        }
    }
    Ok(Plan::SingleVisit(plan))
}

/// Computes an upper bound on the benefits of a plan if travel times depend on the departure or the order is constrained; this
/// takes seconds. For other problems the search has found a bound already. The plan keeps the lower bound.
pub(crate) fn prove(problem: &SingleVisitProblem, plan: &mut SingleVisitPlan, meter: &mut Meter<'_>) {
    if plan.benefits_bound.is_some_and(|bound| bound <= plan.benefits) {
        return;
    }
    let Ok(mut schedule) = schedule::Schedule::new(problem) else { return };
    let usable = Troubles::new(&mut schedule).possible();
    // Searches count what visits gain; a plan also counts what is missed.
    let missed = problem.miss_costs();
    let reached = plan.benefits + missed;
    let Some(found) = time_independent::at_best_departures(&mut schedule, &usable, reached, meter) else { return };
    let found = found - missed;
    plan.benefits_bound = Some(plan.benefits_bound.map_or(found, |claimed| claimed.min(found)));
    plan.summary = plan::summary(problem, plan);
}

#[cfg(test)]
mod tests;

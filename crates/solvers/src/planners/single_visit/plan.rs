//! Makes the plan of the best order: routes, times, fuel, costs, reasons.

use super::explain::{self, Troubles};
use super::search::Candidate;
use crate::routing::schedule::{Choice, Judged, Schedule};
use crate::routing::travel::{PointKey, TimedPath};
use apex_metrics::mission_score;
use apex_model::problem::{LeftOut, PlannedVisit, SingleVisitPlan, SingleVisitProblem, SingleVisitTarget};

/// Finds the reasons of left-out targets.
type Reasons = fn(&mut Schedule<'_>, &[Choice], &Judged, &Troubles) -> Vec<LeftOut>;

/// Returns the whole plan, with the reasons of left-out targets.
///
/// # Errors
/// An error message if a path that was found before is not found again.
pub(super) fn plan_of(
    schedule: &mut Schedule<'_>,
    solver: &str,
    best: &Candidate,
    troubles: &Troubles,
    left_out: Reasons,
) -> Result<SingleVisitPlan, String> {
    let mut visits = Vec::with_capacity(best.order.len());
    let mut node = PointKey::Start;
    let mut ready_s = schedule.problem.start_s;
    for (choice, timed) in best.order.iter().zip(&best.judged.visits) {
        let entry = PointKey::Entry(choice.target, choice.manoeuvre);
        let way = schedule.travel.way(node, entry, ready_s)?;
        ready_s = timed.end_s;
        node = PointKey::Exit(choice.target, choice.manoeuvre);
        let target = schedule.problem.targets.get(choice.target).ok_or("a visit names no target")?;
        let manoeuvre = target.manoeuvres.get(choice.manoeuvre).ok_or("a visit names no manoeuvre")?;
        let timing = target.timing_at(timed.begin_s);
        visits.push(PlannedVisit {
            quality: None,
            target: target.name.clone(),
            manoeuvre: choice.manoeuvre,
            route: way.route,
            path: way.path,
            depart_s: way.depart_s,
            arrive_s: timed.arrive_s,
            begin_s: timed.begin_s,
            end_s: timed.end_s,
            timing,
            worth: target.value * manoeuvre.quality.product() * timing,
        });
    }
    let back = match schedule.problem.base {
        // Between places with given times, a vehicle without visits stays where it is.
        Some(_) if !best.order.is_empty() || schedule.problem.travel.is_none() => {
            schedule.travel.way(node, PointKey::Base, ready_s)?
        }
        _ => TimedPath { route: Vec::new(), path: Vec::new(), depart_s: ready_s, arrive_s: ready_s },
    };
    let left_out = left_out(schedule, &best.order, &best.judged, troubles);
    Ok(assembled(schedule, solver, best, (visits, back, left_out), troubles))
}

/// Returns an unfinished plan for display: reasons that take time to compute are left out. `None` if a path is missing.
pub(super) fn sketch(
    schedule: &mut Schedule<'_>,
    solver: &str,
    best: &Candidate,
    troubles: &Troubles,
) -> Option<SingleVisitPlan> {
    plan_of(schedule, solver, best, troubles, explain::left_out_quickly).ok()
}

fn assembled(
    schedule: &Schedule<'_>,
    solver: &str,
    best: &Candidate,
    (visits, back, left_out): (Vec<PlannedVisit>, TimedPath, Vec<LeftOut>),
    troubles: &Troubles,
) -> SingleVisitPlan {
    let problem = schedule.problem;
    // Every target that a plan may visit, at its best: no plan can gain more.
    let possible = troubles.possible().into_iter().filter_map(|target| problem.targets.get(target));
    let bound = possible.map(gain_max).sum::<f64>() - problem.miss_costs() + 0.0;
    let plan = SingleVisitPlan {
        solver: solver.to_string(),
        visits,
        return_route: back.route,
        return_path: back.path,
        return_depart_s: back.depart_s,
        end_s: best.judged.end_s,
        fuel_used_kg: 0.0,
        benefits: 0.0,
        costs: 0.0,
        score: 0.0,
        benefits_bound: Some(bound),
        left_out,
        summary: String::new(),
    };
    scored(problem, plan)
}

/// Returns the plan with all figures derived from its visits and its end: fuel, benefits, costs, score and the summary for operators.
pub fn scored(problem: &SingleVisitProblem, mut plan: SingleVisitPlan) -> SingleVisitPlan {
    let flight_s = plan.end_s - problem.start_s;
    plan.fuel_used_kg = problem.vehicle.fuel_flow_kg_per_s * flight_s;
    plan.benefits = plan.visits.iter().map(|visit| visit.worth).sum::<f64>() - missed_points(problem, &plan);
    plan.costs = mission_score::flight_cost(problem, flight_s);
    plan.score = plan.benefits - plan.costs;
    plan.summary = summary(problem, &plan);
    plan
}

/// Returns the points that the plan loses because it misses targets that must be observed.
pub(super) fn missed_points(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> f64 {
    let is_missed = |target: &&SingleVisitTarget| {
        let visit = plan.visits.iter().find(|visit| visit.target == target.name);
        let manoeuvre = visit.and_then(|visit| target.manoeuvres.get(visit.manoeuvre));
        let product = visit.zip(manoeuvre).map_or(0.0, |(visit, manoeuvre)| manoeuvre.quality.product() * visit.timing);
        target.is_missed_by(product)
    };
    let missed = problem.targets.iter().filter(|target| target.must.is_some()).filter(is_missed);
    missed.map(SingleVisitTarget::miss_cost).fold(0.0, std::ops::Add::add)
}

/// Returns the plan with a bound on the benefits of all plans of `problem`, which may have more targets and windows than the problem in
/// which the plan was made.
pub fn bounded_by(problem: &SingleVisitProblem, mut plan: SingleVisitPlan) -> SingleVisitPlan {
    plan.benefits_bound = Some(most(problem));
    plan.summary = summary(problem, &plan);
    plan
}

/// Returns the benefits of visits to all targets, none of which is missed, each in its best way at its best time.
pub(crate) fn most(problem: &SingleVisitProblem) -> f64 {
    // Adding zero turns the -0.0 of an empty sum into 0.0.
    problem.targets.iter().map(gain_max).sum::<f64>() - problem.miss_costs() + 0.0
}

fn gain_max(target: &SingleVisitTarget) -> f64 {
    let quality = target.manoeuvres.iter().map(|manoeuvre| manoeuvre.quality.product()).fold(0.0, f64::max);
    let timing = target.timing.iter().map(|(_, factor)| *factor).reduce(f64::max).unwrap_or(1.0);
    target.gain(quality * timing)
}

/// Returns one line for operators.
pub(super) fn summary(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> String {
    if plan.visits.is_empty() && !plan.left_out.is_empty() {
        let may_gain = plan.benefits_bound.is_none_or(|bound| bound > plan.benefits);
        return explain::nothing_visited(&plan.left_out, may_gain);
    }
    let missed = missed_points(problem, plan);
    let missing = if missed > 0.0 { format!(" after {missed:.2} for missed targets") } else { String::new() };
    format!(
        "{} of {} targets in {}; worth {:.2}{missing} of at most {:.2}, costs {:.2}, score {:.2}.",
        plan.visits.len(),
        problem.targets.len(),
        apex_planning::obstacle::spoken(plan.end_s - problem.start_s),
        plan.benefits,
        plan.benefits_bound.unwrap_or(plan.benefits),
        plan.costs,
        plan.score
    )
}

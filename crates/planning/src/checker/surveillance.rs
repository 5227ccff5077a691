//! Independent check of a surveillance plan.

use super::given_times::leg_s;
use apex_metrics::{eci, quadrature};
use apex_model::problem::{CostFunction, EventRate, SurveillancePlan, SurveillanceProblem, SurveillanceTarget};

/// Times may differ by this much from the checker's.
const TIME_TOLERANCE_S: f64 = 1e-6;
/// Share by which costs may differ.
const COST_TOLERANCE: f64 = 1e-8;

/// Returns the violations of `plan`; empty if there are none.
pub(super) fn violations(problem: &SurveillanceProblem, plan: &SurveillancePlan) -> Vec<String> {
    let mut found = Vec::new();
    let index = |name: &str| problem.targets.iter().position(|target| target.name == name);
    let mut place: Option<usize> = None;
    let mut time_s = 0.0;
    let mut seen = vec![Vec::new(); problem.targets.len()];
    for (number, visit) in (1_usize..).zip(&plan.visits) {
        let Some((at, target)) = index(&visit.target).and_then(|at| Some((at, problem.targets.get(at)?))) else {
            found.push(format!("visits {}, which is not a target", visit.target));
            continue;
        };
        // An immediate departure arrives first: a later departure never arrives earlier.
        let travel_s = leg_s(&problem.travel, place, Some(at), time_s);
        let missing_s = time_s + travel_s - visit.arrive_s;
        if missing_s.is_nan() || missing_s > TIME_TOLERANCE_S {
            let name = &visit.target;
            found.push(format!("arrives at {name} {missing_s:.1} s before it can be there, on visit {number}"));
        }
        let short_s = visit.arrive_s + target.dwell_s - visit.end_s;
        if short_s.is_nan() || short_s > TIME_TOLERANCE_S {
            found.push(format!("observes {} {short_s:.1} s too briefly, on visit {number}", visit.target));
        }
        if let Some(ends) = seen.get_mut(at) {
            ends.push(visit.end_s);
        }
        (place, time_s) = (Some(at), visit.end_s);
    }
    let home_s = if problem.return_to_base {
        place.map_or(0.0, |place| leg_s(&problem.travel, Some(place), None, time_s))
    } else {
        0.0
    };
    let limits = [(Some(problem.horizon_s), "horizon"), (problem.endurance_s, "endurance")];
    for (limit_s, name) in limits.into_iter().filter_map(|(limit_s, name)| Some((limit_s?, name))) {
        if time_s + home_s > limit_s + TIME_TOLERANCE_S {
            found.push(format!("ends {:.1} s after the {name}", time_s + home_s - limit_s));
        }
    }
    let costs = problem.targets.iter().zip(&seen).map(|(target, ends)| cost(target, ends, problem.horizon_s));
    match costs.sum::<Result<f64, String>>() {
        Ok(cost) if (cost - plan.expected_cost).abs() > COST_TOLERANCE * cost.abs().max(1.0) => {
            found.push(format!("claims an expected cost of {}, but costs {cost}", plan.expected_cost));
        }
        Ok(cost) => {
            let claimed = plan.expected_cost_bound.filter(|bound| *bound > cost + COST_TOLERANCE * cost.abs().max(1.0));
            found.extend(claimed.map(|bound| format!("claims that no plan costs less than {bound}, but costs {cost}")));
        }
        Err(trouble) => found.push(format!("has no expected cost: {trouble}")),
    }
    found.extend(bookkeeping(problem, plan, &seen));
    found
}

/// Returns the ages at which a cost function is not smooth.
fn jumps(cost: &CostFunction) -> Vec<f64> {
    match cost {
        CostFunction::Step { deadline_s, .. } => vec![*deadline_s],
        CostFunction::Table { points } => points.iter().map(|(age_s, _)| *age_s).collect(),
        CostFunction::Delayed { response_s, cost } => jumps(cost).into_iter().map(|age_s| age_s - response_s).collect(),
        CostFunction::Linear { .. } | CostFunction::Saturating { .. } | CostFunction::Logistic { .. } => Vec::new(),
    }
}

/// Returns the expected cost of one target by quadrature, not by the planners' closed forms. Constant-rate intervals of equal
/// length recur in cycles, so each length is integrated once.
fn cost(target: &SurveillanceTarget, ends_s: &[f64], horizon_s: f64) -> Result<f64, String> {
    let jumps = jumps(&target.cost);
    let constant = target.rate.steps.len() <= 1;
    let mut known: Vec<(f64, f64)> = Vec::new();
    let mut last_s = -target.initial_age_s;
    let mut sum = 0.0;
    for end_s in ends_s.iter().copied().chain([horizon_s]) {
        let length_s = end_s - last_s;
        let remembered =
            known.iter().find(|(length, _)| constant && (length - length_s).abs() < 1e-9).map(|(_, cost)| *cost);
        sum += match remembered {
            Some(cost) => cost,
            None => {
                let cost = integral(&target.rate, &target.cost, &jumps, (last_s, end_s))?;
                known.push((length_s, cost));
                cost
            }
        };
        last_s = end_s;
    }
    Ok(sum)
}

fn integral(
    rate: &EventRate,
    cost: &CostFunction,
    jumps: &[f64],
    (from_s, until_s): (f64, f64),
) -> Result<f64, String> {
    let mut breaks: Vec<f64> = rate.steps.iter().map(|(time_s, _)| *time_s).collect();
    breaks.extend(jumps.iter().map(|age_s| until_s - age_s));
    let mut density = |time_s: f64| rate.at(time_s) * eci::cost_at(cost, until_s - time_s);
    quadrature::integrate(&mut density, from_s, until_s, &breaks, 0.1 * COST_TOLERANCE)
}

/// Checks that every target is either visited or left out with a reason, and that the cycle is the beginning of the visits.
fn bookkeeping(problem: &SurveillanceProblem, plan: &SurveillancePlan, seen: &[Vec<f64>]) -> Vec<String> {
    let mut found = Vec::new();
    for (target, ends) in problem.targets.iter().zip(seen) {
        let left_out = plan.left_out.iter().any(|left_out| left_out.target == target.name);
        if left_out != ends.is_empty() {
            let what =
                if left_out { "is visited, but listed as left out" } else { "is not visited and no reason is given" };
            found.push(format!("{} {what}", target.name));
        }
    }
    if !plan.cycle.is_empty() {
        let laps = plan.visits.iter().zip(plan.cycle.iter().cycle());
        if let Some((visit, wanted)) = laps.into_iter().find(|(visit, wanted)| visit.target != **wanted) {
            found.push(format!("visits {} where its cycle has {wanted}", visit.target));
        }
    }
    found
}

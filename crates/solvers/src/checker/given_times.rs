//! The checker's own look at a single-visit plan whose travel times are given as numbers.

use apex_model::problem::{PlannedVisit, SingleVisitPlan, SingleVisitProblem, TravelTimes};

/// Times are sums of a few thousand numbers: rounding stays far below this.
const TOLERANCE_S: f64 = 1e-6;

/// Legs that are quicker than the given times allow, and targets seen twice or not known.
pub(super) fn legs(
    problem: &SingleVisitProblem,
    travel: &TravelTimes,
    plan: &SingleVisitPlan,
    found: &mut Vec<String>,
) {
    let mut here: Option<usize> = None;
    let mut time_s = problem.start_s;
    for visit in &plan.visits {
        let Some(target) = problem.targets.iter().position(|target| target.name == visit.target) else { continue };
        let row = here.map_or(Some(&travel.from_start_s), |from| travel.between_s.get(from));
        leg(visit, time_s, row.and_then(|row| row.get(target)).copied(), found);
        (here, time_s) = (Some(target), visit.end_s);
    }
    let home_s = match here.filter(|_| problem.base.is_some()) {
        Some(from) => travel.to_base_s.get(from).copied().unwrap_or(f64::INFINITY),
        None => 0.0,
    };
    let spare_s = plan.end_s - time_s - home_s;
    if spare_s.is_nan() || spare_s < -TOLERANCE_S {
        found.push(format!("is back after {:.3} s, which takes {home_s:.3} s", plan.end_s - time_s));
    }
}

fn leg(visit: &PlannedVisit, free_s: f64, needed_s: Option<f64>, found: &mut Vec<String>) {
    let name = &visit.target;
    if visit.depart_s < free_s - TOLERANCE_S {
        found.push(format!("leaves for {name} before the visit before has ended"));
    }
    let (given_s, needed_s) = (visit.arrive_s - visit.depart_s, needed_s.unwrap_or(f64::INFINITY));
    if given_s.is_nan() || given_s < needed_s - TOLERANCE_S {
        found.push(format!("allows {given_s:.3} s for the way to {name}, which takes {needed_s:.3} s"));
    }
}

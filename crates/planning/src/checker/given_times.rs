//! Independent check of a single-visit plan whose travel times are given as numbers.

use apex_model::problem::{PlannedVisit, SingleVisitPlan, SingleVisitProblem, TravelTimes, UNREACHABLE_S};

/// Times are sums of a few thousand numbers: rounding stays far below this.
const TOLERANCE_S: f64 = 1e-6;

/// Reports legs that are faster than the given times allow, and targets that are unknown or visited twice.
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
        leg(visit, time_s, leg_s(travel, here, Some(target), visit.depart_s), found);
        (here, time_s) = (Some(target), visit.end_s);
    }
    let home_s = match here.filter(|_| problem.base.is_some()) {
        Some(from) => leg_s(travel, Some(from), None, plan.return_depart_s.max(time_s)),
        None => 0.0,
    };
    let spare_s = plan.end_s - time_s - home_s;
    if spare_s.is_nan() || spare_s < -TOLERANCE_S {
        found.push(format!("returns after {:.3} s, but the way back takes {home_s:.3} s", plan.end_s - time_s));
    }
}

/// Returns the time of a leg at `depart_s`, computed independently: an average of the two neighbouring departures, weighted by nearness.
/// `from` `None` is the start, `to` `None` the base; infinite if no path exists.
pub(super) fn leg_s(travel: &TravelTimes, from: Option<usize>, to: Option<usize>, depart_s: f64) -> f64 {
    let of = |start: &[f64], between: &[Vec<f64>], base: &[f64]| {
        let time_s = match (from, to) {
            (Some(from), Some(to)) => between.get(from).and_then(|row| row.get(to)),
            (Some(from), None) => base.get(from),
            (None, Some(to)) => start.get(to),
            (None, None) => None,
        };
        time_s.copied().filter(|time_s| *time_s < UNREACHABLE_S).unwrap_or(f64::INFINITY)
    };
    let (mut sum, mut left) = (0.0, 1.0);
    let mut from_s = 0.0;
    let mut time_s = of(&travel.from_start_s, &travel.between_s, &travel.to_base_s);
    for later in &travel.later {
        let next_s = of(&later.from_start_s, &later.between_s, &later.to_base_s);
        if depart_s < later.depart_s {
            let nearness = ((later.depart_s - depart_s) / (later.depart_s - from_s)).min(1.0);
            if nearness < 1.0 {
                sum = (1.0 - nearness) * next_s;
                left = nearness;
            }
            break;
        }
        (from_s, time_s) = (later.depart_s, next_s);
    }
    sum + left * time_s
}

fn leg(visit: &PlannedVisit, free_s: f64, needed_s: f64, found: &mut Vec<String>) {
    let name = &visit.target;
    if visit.depart_s < free_s - TOLERANCE_S {
        found.push(format!("leaves for {name} before the previous visit has ended"));
    }
    let given_s = visit.arrive_s - visit.depart_s;
    if given_s.is_nan() || given_s < needed_s - TOLERANCE_S {
        found.push(format!("allows {given_s:.3} s for the way to {name}, but it takes {needed_s:.3} s"));
    }
}

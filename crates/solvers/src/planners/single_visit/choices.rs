//! Ways to observe a target: its manoeuvres, and the instants from which on they may begin.

use crate::routing::flight_limit::FlightLimit;
use crate::routing::schedule::Choice;
use apex_model::problem::{Manoeuvre, SingleVisitProblem, SingleVisitTarget};

/// Returns all ways to observe a target: each manoeuvre at once, from each corner of its timing on, or at the latest instant before which
/// its timing still rises.
pub(super) fn choices(problem: &SingleVisitProblem, target: usize) -> Vec<Choice> {
    let Some(data) = problem.targets.get(target) else { return Vec::new() };
    let starts = [f64::NEG_INFINITY].into_iter().chain(data.timing.iter().map(|(time_s, _)| *time_s));
    let starts: Vec<f64> = starts.collect();
    let of_manoeuvre = |(manoeuvre, way): (usize, &Manoeuvre)| {
        let latest_s = latest_rising_s(problem, (target, data), way);
        let starts = starts.iter().copied().chain(latest_s);
        starts.map(|not_before_s| Choice { target, manoeuvre, not_before_s }).collect::<Vec<_>>()
    };
    data.manoeuvres.iter().enumerate().flat_map(of_manoeuvre).collect()
}

/// Returns the instants within a rise of a target's timing at which the observation must begin at the latest: at the end of a window, and
/// with given times, where the way to the base leaves no more time.
fn latest_rising_s(
    problem: &SingleVisitProblem,
    (number, target): (usize, &SingleVisitTarget),
    way: &Manoeuvre,
) -> Vec<f64> {
    if target.timing.is_empty() {
        return Vec::new();
    }
    let mut latest_s: Vec<f64> = target.windows.iter().map(|window| window.until_s).collect();
    if let Some(travel) = &problem.travel {
        let limit_s = FlightLimit::earliest(problem).0 - way.duration_s;
        let home_s = |to_base_s: &[f64]| match problem.base {
            Some(_) => to_base_s.get(number).copied().unwrap_or(0.0),
            None => 0.0,
        };
        latest_s.push(limit_s - home_s(&travel.to_base_s));
        latest_s.extend(travel.later.iter().map(|later| limit_s - home_s(&later.to_base_s)));
    }
    let corners = || target.timing.iter().zip(target.timing.iter().skip(1));
    let rises = |at_s: &f64| corners().any(|(one, next)| one.0 < *at_s && *at_s < next.0 && one.1 < next.1);
    latest_s.retain(rises);
    latest_s
}

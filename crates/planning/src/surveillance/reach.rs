//! Surveillance targets that can be observed at all, and targets from which a detour over others is faster than the direct way home.
//!
//! Given times need not obey the triangle inequality, so a target that cannot be reached or left directly may be reachable through
//! another one. Bound: O(targets), or O(targets^2) if a target cannot be the first.

use apex_model::problem::{SurveillanceProblem, UNREACHABLE_S};

/// Returns the indices of the targets, of `count`, that some flight can observe, and the work of this search in nanoseconds. `end_s(from,
/// time_s, to)` is the end of the observation of `to` after a departure from `from` (`None`: the start) at `time_s`; infinite if it is
/// impossible.
pub(super) fn usable(count: usize, end_s: impl Fn(Option<usize>, f64, usize) -> f64) -> (Vec<usize>, u64) {
    let mut ends_s: Vec<f64> = (0..count).map(|target| end_s(None, 0.0, target)).collect();
    let mut spent_ns = 0;
    if ends_s.iter().any(|end_s| end_s.is_infinite()) {
        settle(&mut ends_s, |from, ready_s, to| end_s(Some(from), ready_s, to));
        spent_ns = (count * count) as u64 * LOOK_NS;
    }
    let usable = (0..count).filter(|target| ends_s.get(*target).is_some_and(|end_s| end_s.is_finite()));
    (usable.collect(), spent_ns)
}

/// Returns the least times home over all departures and detours; empty if the direct way home is always the fastest.
pub(super) fn detours_home_s(problem: &SurveillanceProblem) -> Vec<f64> {
    let count = problem.targets.len();
    let (travel, dwells_s) = (&problem.travel, problem.targets.iter().map(|target| target.dwell_s));
    let dwells_s: Vec<f64> = dwells_s.collect();
    let over_s = |next: usize, home_s: f64, here: usize| {
        travel.between_s_min(here, next) + dwells_s.get(next).copied().unwrap_or(0.0) + home_s
    };
    let direct_s: Vec<f64> = (0..count).map(|target| travel.to_base_s_min(target)).collect();
    // If no detour over one other target is shorter than a direct way home, at any departure, no longer detour is.
    let longest_s = |here: usize| {
        let home_s = |to_base_s: &Vec<f64>| to_base_s.get(here).copied().unwrap_or(UNREACHABLE_S);
        travel.later.iter().map(|later| home_s(&later.to_base_s)).fold(home_s(&travel.to_base_s), f64::max)
    };
    let shorter = |here: usize| {
        let home_s = longest_s(here);
        direct_s.iter().enumerate().any(|(next, rest_s)| next != here && over_s(next, *rest_s, here) < home_s - SAME_S)
    };
    if !(0..count).any(shorter) {
        return Vec::new();
    }
    let mut least_s = direct_s.clone();
    settle(&mut least_s, over_s);
    least_s
}

/// Times that differ by no more are equal.
const SAME_S: f64 = 1e-6;
/// Work of comparing two targets, in nanoseconds.
const LOOK_NS: u64 = 12;

/// Computes least values in the manner of Dijkstra: makes the least one final, lets it lower the others, and repeats. `over(a, value, b)`
/// is the value of `b` through `a`, which has `value`.
fn settle(least: &mut [f64], over: impl Fn(usize, f64, usize) -> f64) {
    let mut open: Vec<usize> = (0..least.len()).collect();
    let at = |least: &[f64], node: Option<&usize>| node.and_then(|node| least.get(*node)).copied();
    loop {
        let own = |slot: &usize| at(least, open.get(*slot)).unwrap_or(f64::INFINITY);
        let Some(slot) = (0..open.len()).min_by(|a, b| own(a).total_cmp(&own(b))) else { return };
        let here = open.swap_remove(slot);
        let Some(own) = at(least, Some(&here)).filter(|own| *own < UNREACHABLE_S) else { return };
        for there in &open {
            let lower = over(here, own, *there);
            if let Some(known) = least.get_mut(*there) {
                *known = known.min(lower);
            }
        }
    }
}

//! Lower bounds of inputs, from which bounds on plans are made: least event rates and shortest travel times.

use apex_model::problem::{SurveillanceProblem, SurveillanceTarget, UNREACHABLE_S};

/// Returns the least events per second at any time.
pub(super) fn events_per_s(target: &SurveillanceTarget) -> f64 {
    target.rate.steps.iter().map(|(_, events_per_s)| *events_per_s).reduce(f64::min).unwrap_or(0.0)
}

/// Returns the shortest times in seconds from the end of an observation to the end of another, with detours over other targets.
pub(super) fn ways(problem: &SurveillanceProblem) -> Vec<Vec<f64>> {
    let count = problem.targets.len();
    let dwells = || problem.targets.iter().map(|target| target.dwell_s);
    let leg = |from: usize, (to, dwell_s): (usize, f64)| {
        if from == to { 0.0 } else { problem.travel.between(from, to).min(UNREACHABLE_S) + dwell_s }
    };
    let mut ways: Vec<Vec<f64>> =
        (0..count).map(|from| dwells().enumerate().map(|to| leg(from, to)).collect()).collect();
    for over in 0..count {
        let onward = ways.get(over).cloned().unwrap_or_default();
        for way in &mut ways {
            let first = way.get(over).copied().unwrap_or(UNREACHABLE_S);
            for (direct, rest) in way.iter_mut().zip(&onward) {
                *direct = direct.min(first + rest);
            }
        }
    }
    // A path that no vehicle can fly is in no plan; as a number it would only weaken the bounds.
    let limit_s = problem.horizon_s;
    ways.iter_mut().flatten().for_each(|way| *way = way.min(limit_s));
    ways
}

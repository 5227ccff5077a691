//! Restriction of event rates to the time that matters for bounds: from the last observation before the flight to the horizon.

use apex_model::problem::{EventRate, SurveillanceProblem, SurveillanceTarget};
use std::borrow::Cow;

/// Returns the problem without the steps of rates that lie wholly outside the time that matters.
pub(super) fn held(problem: &SurveillanceProblem) -> Cow<'_, SurveillanceProblem> {
    let steps = |target: &SurveillanceTarget| steps(target, problem.horizon_s);
    if problem.targets.iter().all(|target| steps(target).len() == target.rate.steps.len()) {
        return Cow::Borrowed(problem);
    }
    let mut held = problem.clone();
    for target in &mut held.targets {
        target.rate = EventRate { steps: steps(target) };
    }
    Cow::Owned(held)
}

/// Returns true if a rate changes within the time that matters.
pub(super) fn change(problem: &SurveillanceProblem) -> bool {
    let differ = |steps: &[(f64, f64)]| steps.iter().zip(steps.iter().skip(1)).any(|((_, a), (_, b))| a != b);
    problem.targets.iter().any(|target| differ(&steps(target, problem.horizon_s)))
}

fn steps(target: &SurveillanceTarget, horizon_s: f64) -> Vec<(f64, f64)> {
    let all = &target.rate.steps;
    // For a target observed just before the start (age 0), no time before the start matters.
    let holds = |(index, (from_s, _)): &(usize, &(f64, f64))| {
        let until_s = all.get(index + 1).map_or(f64::INFINITY, |(next_s, _)| *next_s);
        until_s > -target.initial_age_s && (*index == 0 || *from_s < horizon_s)
    };
    all.iter().enumerate().filter(holds).map(|(_, step)| *step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::surveillance as examples;

    #[test]
    fn steps_before_the_last_observation_and_after_the_horizon_do_not_count() {
        let mut problem = examples::random(1, 1);
        problem.targets[0].rate.steps = vec![(-900.0, 5.0), (-60.0, 1.0), (3600.0, 0.0)];
        assert_eq!(held(&problem).targets[0].rate.steps, [(-60.0, 1.0)]);
        assert!(!change(&problem));
        problem.targets[0].initial_age_s = 100.0;
        assert_eq!(held(&problem).targets[0].rate.steps.len(), 2);
        assert!(change(&problem));
        problem.targets[0].rate.steps = vec![(9_000.0, 2.0)];
        assert_eq!(held(&problem).targets[0].rate.steps, [(9_000.0, 2.0)], "the first holds before its time, too");
    }
}

//! Targets that can be visited only with others, and targets that must precede a target.

use super::explain::Troubles;
use crate::routing::schedule::{Choice, Schedule};

/// Returns the targets that a plan visits only together with others: those that cannot be the only visit, and those that must
/// follow a target without value, directly or through others.
pub(super) fn companions(schedule: &Schedule<'_>, troubles: &Troubles) -> Vec<usize> {
    let mut led = troubles.with_others();
    let worthless = |target: usize| {
        let data = schedule.problem.targets.get(target);
        data.is_some_and(|data| {
            data.gain(data.manoeuvres.iter().map(|it| it.quality.product()).fold(0.0, f64::max)) <= 0.0
        })
    };
    for target in troubles.possible() {
        let before = before(schedule, target, &[]);
        if !led.contains(&target) && before.iter().any(|earlier| worthless(*earlier) || led.contains(earlier)) {
            led.push(target);
        }
    }
    led
}

/// Returns the targets that must precede `target` and are not among `visited`, in an allowed order.
pub(super) fn before(schedule: &Schedule<'_>, target: usize, visited: &[Choice]) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let mut open = vec![(target, false)];
    while let Some((next, is_left)) = open.pop() {
        if is_left {
            if next != target && !found.contains(&next) {
                found.push(next);
            }
            continue;
        }
        open.push((next, true));
        let missing = |earlier: &&usize| !visited.iter().any(|choice| choice.target == **earlier);
        open.extend(schedule.earlier(next).iter().filter(missing).map(|earlier| (*earlier, false)));
    }
    found
}

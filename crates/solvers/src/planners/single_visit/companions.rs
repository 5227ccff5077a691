//! Which targets can be visited only with others, and what must come before a target.

use super::explain::Troubles;
use crate::routing::schedule::{Choice, Schedule};

/// Targets that are reached only after others: those in trouble alone, and those that must follow what is worth nothing, at once
/// or through others.
pub(super) fn companions(schedule: &Schedule<'_>, troubles: &Troubles) -> Vec<usize> {
    let mut led = troubles.with_others();
    let worthless = |target: usize| {
        let data = schedule.problem.targets.get(target);
        data.is_some_and(|data| {
            data.value * data.manoeuvres.iter().map(|it| it.quality.product()).fold(0.0, f64::max) <= 0.0
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

/// What must come before `target` and is not among `visited`, in an order that is allowed.
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

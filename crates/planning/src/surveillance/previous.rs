//! The plan in execution as a starting point: its remainder for a problem that has changed.
//!
//! Bound: O(targets + visits).

use super::scenario::Scenario;
use crate::solver::Budget;
use apex_model::problem::Plan;
use std::collections::BTreeMap;

/// Returns the remainder of a plan: its visits, if their targets still exist and the time suffices; a plan that repeats a cycle continues
/// it. `None` if the remainder is empty.
pub fn word(scenario: &Scenario<'_>, plan: Option<&Plan>) -> Option<Vec<usize>> {
    let Plan::Surveillance(plan) = plan? else { return None };
    let targets = &scenario.problem().targets;
    let by_name: BTreeMap<&str, usize> =
        scenario.usable().iter().filter_map(|index| Some((targets.get(*index)?.name.as_str(), *index))).collect();
    let index = |name: &str| by_name.get(name).copied();
    let visits: Vec<usize> = plan.visits.iter().filter_map(|visit| index(&visit.target)).collect();
    let cycle: Vec<usize> = plan.cycle.iter().filter_map(|name| index(name)).collect();
    // Position in the cycle after the remaining visits; the plan repeats the cycle from its beginning.
    let last = plan.visits.len().checked_sub(1).and_then(|last| plan.visits.get(last));
    let after = last.and_then(|last| plan.cycle.iter().position(|name| *name == last.target)).map_or(0, |at| at + 1);
    let after = plan.cycle.iter().take(after).filter(|name| index(name).is_some()).count();
    scenario.spend((visits.len() + cycle.len() + scenario.usable().len()) as u64 * NAME_NS);
    let word = scenario.flown(visits.into_iter().chain(cycle.iter().copied().cycle().skip(after)));
    (!word.is_empty()).then_some(word)
}

/// Returns the targets of the remainder of a plan in the order of their first visits, as an initial cycle.
pub fn cycle(scenario: &Scenario<'_>, plan: Option<&Plan>) -> Option<Vec<usize>> {
    let word = word(scenario, plan)?;
    let mut there = vec![false; scenario.problem().targets.len()];
    let mut first = |target: &usize| there.get_mut(*target).is_some_and(|there| !std::mem::replace(there, true));
    Some(word.into_iter().filter(|target| first(target)).collect())
}

/// Returns the remainder of the plan if it costs less than `cost`, with its cost.
pub fn better(
    scenario: &Scenario<'_>,
    plan: Option<&Plan>,
    cost: f64,
    budget: &mut dyn Budget,
) -> Option<(f64, Vec<usize>)> {
    let word = word(scenario, plan)?;
    let before = scenario.cost(word.iter().copied(), budget);
    (before < cost).then_some((before, word))
}

/// Work of finding a target by its name, in nanoseconds.
const NAME_NS: u64 = 100;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::surveillance as examples;

    #[test]
    fn a_cycle_continues_where_the_visits_that_are_left_end() {
        let problem = examples::random(4, 3);
        let scenario = Scenario::new(&problem).unwrap();
        let names = |indices: &[usize]| indices.iter().map(|index| problem.targets[*index].name.clone()).collect();
        let mut old = scenario.cycle_plan("test", &[2, 0, 3]);
        old.visits.truncate(5);
        old.visits.remove(0);
        let left = word(&scenario, Some(&Plan::Surveillance(old.clone()))).unwrap();
        assert_eq!(left[..6], [0, 3, 2, 0, 3, 2], "the first visit is over");
        old.cycle = names(&[2, 0, 3]);
        old.visits.clear();
        assert_eq!(word(&scenario, Some(&Plan::Surveillance(old))).unwrap()[..3], [2, 0, 3]);
        assert_eq!(word(&scenario, None), None);
    }
}

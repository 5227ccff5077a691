//! Repair of an earlier plan after a change of the problem: finds its visits in the new network and removes late ones.

use super::route::Route;
use crate::routing::network::Network;
use apex_model::problem::{SingleVisitPlan, SingleVisitProblem};
use std::collections::BTreeMap;

/// Returns the nodes of the visits of `plan` whose targets still exist, in the order of the plan.
pub(super) fn visits(network: &Network, problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Vec<u32> {
    let mut nodes: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
    for node in network.visits() {
        if let Some(target) = problem.targets.get(network.node(node).target as usize) {
            nodes.entry(target.name.as_str()).or_default().push(node);
        }
    }
    let same = |visit: &apex_model::problem::PlannedVisit| {
        let candidates = nodes.get(visit.target.as_str())?;
        let alike = |node: &&u32| network.node(**node).manoeuvre as usize == visit.manoeuvre;
        candidates.iter().find(alike).or(candidates.first()).copied()
    };
    plan.visits.iter().filter_map(same).collect()
}

/// Removes visits until the route is feasible; the visit that saves the most time per unit of value is removed first.
pub(super) fn mend(network: &Network, route: &mut Route) {
    while !route.is_feasible() {
        let last = route.stops.len() - 1;
        // Only the removal of the first late visit or of an earlier one helps.
        let late = route.stops.iter().position(|stop| stop.begin > network.node(stop.node).close);
        let until = late.map_or(last, |late| (late + 1).min(last));
        let best = (1..until).max_by(|a, b| saved(network, route, *a).total_cmp(&saved(network, route, *b)));
        let out = best.unwrap_or(1);
        if last < 2 {
            return;
        }
        route.remove(network, out, out + 1);
    }
}

/// Returns the ticks of travel that the removal of a stop saves, per unit of its value.
fn saved(network: &Network, route: &Route, at: usize) -> f64 {
    let stop = |at: usize| route.stops.get(at).map_or(0, |stop| stop.node);
    let (before, here, next) = (stop(at - 1), stop(at), stop(at + 1));
    let longer = network.leg(before, here) + network.leg(here, next) - network.leg(before, next);
    f64::from(longer) / network.node(here).value.max(1e-9)
}

//! A route from one that was flown or planned before a change: what is too late goes, what fits comes.

use super::route::Route;
use crate::routing::network::Network;
use apex_model::problem::{SingleVisitPlan, SingleVisitProblem};
use std::collections::BTreeMap;

/// The visits of `plan` that still exist, in their order.
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

/// Takes visits out until the others are in time, those first that save the most time for their value.
pub(super) fn mend(network: &Network, route: &mut Route) {
    while !route.is_feasible() {
        let last = route.stops.len() - 1;
        // What is too late is helped by leaving out itself or something before it.
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

/// Time saved for each unit of value by leaving a stop out.
fn saved(network: &Network, route: &Route, at: usize) -> f64 {
    let stop = |at: usize| route.stops.get(at).map_or(0, |stop| stop.node);
    let (before, here, next) = (stop(at - 1), stop(at), stop(at + 1));
    let longer = network.leg(before, here) + network.leg(here, next) - network.leg(before, next);
    f64::from(longer) / network.node(here).value.max(1e-9)
}

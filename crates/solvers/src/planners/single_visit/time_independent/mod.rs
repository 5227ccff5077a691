//! Planner for travel times that do not depend on the departure: ruin and recreate with annealing over a timetable.
//!
//! Three numbers per stop decide whether a visit fits between two others and when the route then ends, so an insertion is
//! evaluated in O(1). `search` divides the budget between annealing runs and proofs.
//! Bound: the budget. Deterministic: equal seed and budget give an equal route.

mod annealing;
mod polish;
mod reasons;
mod recreate;
mod repair;
mod route;
mod ruin;
mod search;
mod turn;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tour_tests;

use crate::bounds::routes;
use crate::routing::network::{self, Network};
use crate::routing::schedule::{Choice, Schedule};
use annealing::Annealing;
use apex_model::problem::SingleVisitPlan;
use apex_planning::meter::Meter;
use apex_planning::obstacle::LeftOutReason;
use apex_planning::solver::Environment;
use route::Route;
use search::SearchDriver;

/// Result of the search.
pub(super) struct Found {
    /// The visits in order.
    pub(super) order: Vec<Choice>,
    /// Upper bound on the value of all routes, if a proof found one.
    pub(super) bound: Option<f64>,
    /// Targets that are left out, each with the reason.
    pub(super) reasons: Vec<(usize, LeftOutReason)>,
}

/// Receives the first order found.
pub(super) type Tell<'t> = dyn FnMut(&mut Schedule<'_>, Vec<Choice>, &mut Environment<'_>) + 't;

/// Returns the best order found within the budget; `None` if the problem needs the general search. The search begins with the
/// visits of `previous`, if given.
pub(super) fn run(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    previous: Option<&SingleVisitPlan>,
    environment: &mut Environment<'_>,
    tell: &mut Tell<'_>,
) -> Option<Found> {
    let mut network = Network::new(schedule, usable, environment.budget)?;
    let visits = previous.map(|plan| repair::visits(&network, schedule.problem, plan)).unwrap_or_default();
    let mut first = Route::of(&network, &visits);
    repair::mend(&network, &mut first);
    Annealing::new(&network, environment.seed).fill_all(&mut first, environment.budget);
    tell(schedule, choices(&network, &first), environment);
    network.find_neighbours();
    let budget = &mut *environment.budget;
    let lowered = network.lowered(schedule.problem, schedule.limit_s);
    let networks = [&network, lowered.as_ref().unwrap_or(&network)];
    let (best, bound) = SearchDriver::new(networks, environment.seed, first, previous.is_none()).run(budget);
    Some(Found { order: choices(&network, &best), bound, reasons: reasons::left_out(&network, &best) })
}

/// Maximum work of a proof if the user requests the quality of a plan, in units; it takes some seconds.
const PROOF_UNITS: u64 = 4_000_000;

/// Returns an upper bound on the benefits of all plans over the `usable` targets, for problems that need the general search.
/// The relaxation flies every leg at its best departure and ignores costs and order. The bound is at least `reached`, the benefits
/// of a known plan.
///
/// `None` if there are too many targets, if the budget is too small to compute the legs, or for problems that this search serves, whose
/// plans have bounds already.
pub(super) fn at_best_departures(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    reached: f64,
    meter: &mut Meter<'_>,
) -> Option<f64> {
    if network::serves(schedule) {
        return None;
    }
    let network = Network::relaxed(schedule, usable, meter)?;
    let left = meter.budget().left().unwrap_or(u64::MAX);
    let before = meter.used();
    let found = routes::highest_value(&network, reached, PROOF_UNITS.min(left), meter.budget()).bound;
    if left < PROOF_UNITS && meter.used() - before >= left && found > reached {
        meter.cut();
    }
    Some(found)
}

fn choices(network: &Network, route: &Route) -> Vec<Choice> {
    let choice = |node: u32| {
        let node = network.node(node);
        Choice { target: node.target as usize, manoeuvre: node.manoeuvre as usize, not_before_s: f64::NEG_INFINITY }
    };
    route.visits().map(choice).collect()
}

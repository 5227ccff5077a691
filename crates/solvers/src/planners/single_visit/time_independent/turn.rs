//! Move that reverses a run of visits, so that two near targets follow each other.

use super::route::Route;
use crate::routing::network::Network;
use apex_planning::random::Generator;

/// Maximum length of a reversed run.
const RUN_MAX: usize = 1_000;

/// Reverses the run between a random visit and one of its neighbours if that raises the score by more than `accept` (which is
/// negative). Each tick of length costs `price` in addition. Returns the number of stops that were examined or timed again.
pub(super) fn try_one(network: &Network, route: &mut Route, price: f64, accept: f64, rng: &mut Generator) -> u64 {
    let count = route.count();
    if count < 3 {
        return 0;
    }
    let Some(stop) = route.stops.get(1 + rng.below(count)).copied() else { return 0 };
    let near = network.near.get(stop.node as usize).map_or(&[][..], Vec::as_slice);
    let Some(other) = near.get(rng.below(near.len().min(10))).and_then(|other| route.index(*other)) else {
        return 0;
    };
    let Some(own) = route.index(stop.node) else { return 0 };
    // The two visits become neighbours either at the beginning of the run or at its end.
    let (low, high) = (own.min(other), own.max(other));
    let (from, until) = if rng.below(2) == 0 { (low + 1, high + 1) } else { (low, high) };
    if until <= from + 1 || until - from > RUN_MAX {
        return 0;
    }
    let examined = (until - from) as u64;
    let Some((end, longer)) = route.turned(network, from, until) else { return examined };
    let gain = -network.cost_per_tick * f64::from(end - route.end()) - price * f64::from(longer);
    if gain <= accept {
        return examined;
    }
    route.turn(network, from, until);
    // Begins are computed again from the run on, latest begins from it back to the start; the route is copied after a change.
    2 * (examined + route.stops.len() as u64)
}

//! Removal of visits, the first step of ruin and recreate: a run of them, those around a position, or random ones.

use super::route::Route;
use crate::routing::network::Network;
use apex_planning::random::Generator;

/// Maximum number of visits that one step removes.
const GONE_MAX: usize = 10;

/// Removes some visits from `route` and adds them to `gone`.
pub(super) fn ruin(network: &Network, route: &mut Route, gone: &mut Vec<u32>, rng: &mut Generator) {
    gone.clear();
    let count = route.count();
    if count == 0 {
        return;
    }
    let most = GONE_MAX.min(count.div_ceil(2)).max(1);
    let take = 1 + rng.below(most);
    match rng.below(10) {
        0..5 => run(network, route, take, gone, rng),
        5..7 => {
            run(network, route, take.div_ceil(2), gone, rng);
            run(network, route, take / 2, gone, rng);
        }
        7..9 => around(network, route, take, gone, rng),
        _ => {
            let any = (0..take.min(4)).filter_map(|_| route.stops.get(1 + rng.below(count)).map(|stop| stop.node));
            gone.extend(any);
            route.retain(network, |node| !gone.contains(&node));
        }
    }
}

/// Removes visits that follow each other.
fn run(network: &Network, route: &mut Route, take: usize, gone: &mut Vec<u32>, rng: &mut Generator) {
    let count = route.count();
    if take == 0 || count < take {
        return;
    }
    let from = 1 + rng.below(count + 1 - take);
    gone.extend(route.stops.iter().skip(from).take(take).map(|stop| stop.node));
    route.remove(network, from, from + take);
}

/// Removes visits near a node, which need not be visited itself.
fn around(network: &Network, route: &mut Route, take: usize, gone: &mut Vec<u32>, rng: &mut Generator) {
    let visits = network.visits();
    let centre = visits.start + rng.below(visits.len()) as u32;
    let near = network.near.get(centre as usize).map_or(&[][..], Vec::as_slice);
    gone.push(centre);
    gone.extend(near.iter().copied().filter(|node| route.sees(network, *node)).take(take));
    route.retain(network, |node| !gone.contains(&node));
}

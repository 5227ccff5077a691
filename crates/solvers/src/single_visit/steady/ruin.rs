//! Taking visits out: a run of them, those around a place, or some by chance.

use super::network::Network;
use super::route::Route;
use crate::random::Generator;

/// Visits taken out at most.
const GONE_MAX: usize = 12;

/// Takes some visits out of `route`.
pub(super) fn ruin(network: &Network, route: &mut Route, chance: &mut Generator) {
    let count = route.count();
    if count == 0 {
        return;
    }
    let most = GONE_MAX.min(count.div_ceil(2)).max(1);
    let take = 1 + chance.below(most);
    match chance.below(10) {
        0..5 => {
            let from = 1 + chance.below(count + 1 - take);
            route.remove(network, from, from + take);
        }
        5..7 => {
            // Two runs.
            for share in [take.div_ceil(2), take / 2] {
                let count = route.count();
                if share > 0 && count >= share {
                    let from = 1 + chance.below(count + 1 - share);
                    route.remove(network, from, from + share);
                }
            }
        }
        7..9 => around(network, route, take, chance),
        _ => {
            let gone: Vec<u32> = (0..take.min(4))
                .filter_map(|_| route.stops.get(1 + chance.below(count)).map(|stop| stop.node))
                .collect();
            route.retain(network, |node| !gone.contains(&node));
        }
    }
}

/// Visits near a node, which need not be visited itself.
fn around(network: &Network, route: &mut Route, take: usize, chance: &mut Generator) {
    let visits = network.visits();
    let centre = visits.start + chance.below(visits.len()) as u32;
    let near = network.near.get(centre as usize).map_or(&[][..], Vec::as_slice);
    let mut gone: Vec<u32> = Vec::with_capacity(take + 1);
    gone.push(centre);
    gone.extend(near.iter().copied().filter(|node| route.sees(network, *node)).take(take));
    route.retain(network, |node| !gone.contains(&node));
}

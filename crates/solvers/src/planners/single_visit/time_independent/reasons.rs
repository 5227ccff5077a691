//! Reasons for which a target is not in a route: the least shortage over all positions.

use super::route::Route;
use crate::routing::network::Network;
use apex_model::problem::{Obstacle, TimeLimit};
use apex_planning::obstacle::LeftOutReason;

/// Returns the numbers of the targets that have nodes and are not visited, with the reasons.
pub(super) fn left_out(network: &Network, route: &Route) -> Vec<(usize, LeftOutReason)> {
    let mut found: Vec<(usize, Option<i32>)> = Vec::new();
    for node in network.visits().filter(|node| !route.sees(network, *node)) {
        let target = network.node(node).target as usize;
        let over = over(network, route, node);
        match found.last_mut().filter(|(last, _)| *last == target) {
            Some((_, least)) => *least = [*least, over].into_iter().flatten().min(),
            None => found.push((target, over)),
        }
    }
    let told = |over: Option<i32>| -> LeftOutReason {
        match over {
            Some(over) if over > 0 => {
                let over_s = f64::from(over) * network.tick_s;
                Obstacle::Late { over_s, limit: TimeLimit::OtherVisits, alone: false }.into()
            }
            Some(_) => "fits, but is not worth its time, or was not reached within the planning budget".into(),
            None => "no place between the others is within its time windows".into(),
        }
    };
    found.into_iter().map(|(target, over)| (target, told(over))).collect()
}

/// Returns the least delay, in ticks, beyond what the following stops allow, over all positions; `None` if the node's window is over
/// at every position.
fn over(network: &Network, route: &Route, node: u32) -> Option<i32> {
    let data = network.node(node);
    let pairs = route.stops.iter().zip(route.stops.iter().skip(1));
    let over = pairs.filter_map(|(before, next)| {
        let begin = (before.begin + network.leg(before.node, node)).max(data.open);
        (begin <= data.close).then(|| begin + network.leg(node, next.node) - next.latest)
    });
    over.min()
}

//! Knapsack bound from the shortest legs alone: each visit weighs half of the shortest leg to it and half of that from it.

use crate::routing::network::{END, Network, START};

/// Returns the greatest value whose weights fit into the flight, the last target in part (linear relaxation).
pub(super) fn bound(network: &Network) -> f64 {
    let shortest = |legs: &mut dyn Iterator<Item = i32>| f64::from(legs.min().unwrap_or(0));
    let others = |node: u32| network.visits().filter(move |other| *other != node);
    // Combines the greatest value and the least weight of each target's nodes: no route does better.
    let mut value = vec![0.0_f64; network.targets];
    let mut takes = vec![f64::INFINITY; network.targets];
    for node in network.visits() {
        let into = shortest(&mut others(node).chain([START]).map(|from| network.leg(from, node)));
        let out = shortest(&mut others(node).chain([END]).map(|to| network.leg(node, to)));
        let data = network.node(node);
        if data.open > data.close {
            continue;
        }
        if let (Some(value), Some(takes)) = (value.get_mut(data.target as usize), takes.get_mut(data.target as usize)) {
            *value = value.max(data.value);
            *takes = takes.min(0.5 * (into + out));
        }
    }
    let ends = shortest(&mut network.visits().map(|node| network.leg(START, node)))
        + shortest(&mut network.visits().map(|node| network.leg(node, END)));
    let mut left = f64::from(network.limit()) - 0.5 * ends;
    let mut items: Vec<(f64, f64)> = value.into_iter().zip(takes).filter(|(value, _)| *value > 0.0).collect();
    items.sort_by(|(value_a, takes_a), (value_b, takes_b)| (value_b * takes_a).total_cmp(&(value_a * takes_b)));
    let mut bound = 0.0;
    for (value, takes) in items {
        if takes > left {
            return bound + if takes > 0.0 { value * (left.max(0.0) / takes) } else { value };
        }
        bound += value;
        left -= takes;
    }
    bound
}

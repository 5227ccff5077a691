//! For each node and time, the targets that no path can reach before their windows close.

use super::ng_sets::{Targets, bit_of};
use crate::routing::network::{FIRST, Network};

/// For each node the latest departures in order of time, each with the targets that cannot be reached after it.
pub(super) struct LatestDepartures(Vec<Vec<(i32, Targets)>>);

impl LatestDepartures {
    pub(super) fn new(network: &Network) -> LatestDepartures {
        let nodes = network.nodes.len();
        let quickest = quickest(network);
        let of = |row: &[i32]| {
            let mut last = vec![i32::MIN; network.targets];
            for (ticks, data) in row.iter().zip(&network.nodes).skip(FIRST as usize) {
                if let Some(last) = last.get_mut(data.target as usize) {
                    *last = (*last).max(data.close.saturating_sub(*ticks));
                }
            }
            let mut order: Vec<(i32, Targets)> = (0..).zip(last).map(|(target, last)| (last, bit_of(target))).collect();
            order.sort_unstable();
            let mut missed = 0;
            for (_, set) in &mut order {
                missed |= *set;
                *set = missed;
            }
            order
        };
        LatestDepartures(quickest.chunks(nodes.max(1)).map(of).collect())
    }

    /// Returns the targets that no path from `node` with departure at `time` reaches in time.
    #[inline]
    pub(super) fn missed(&self, node: u32, time: i32) -> Targets {
        let Some(order) = self.0.get(node as usize) else { return 0 };
        let count = order.partition_point(|(last, _)| *last < time);
        count.checked_sub(1).and_then(|index| order.get(index)).map_or(0, |(_, missed)| *missed)
    }
}

/// Returns the shortest travel times between nodes through any others, without waiting (Floyd and Warshall).
fn quickest(network: &Network) -> Vec<i32> {
    let count = network.nodes.len();
    let mut quickest: Vec<i32> =
        (0..count * count).map(|index| network.leg((index / count) as u32, (index % count) as u32)).collect();
    for (node, row) in quickest.chunks_mut(count.max(1)).enumerate() {
        // A node reaches itself at once.
        if let Some(own) = row.get_mut(node) {
            *own = 0;
        }
    }
    for through in network.visits().map(|node| node as usize) {
        let successors: Vec<i32> = quickest.get(through * count..(through + 1) * count).unwrap_or_default().to_vec();
        for row in quickest.chunks_mut(count) {
            let Some(to_there) = row.get(through).copied() else { continue };
            for (ticks, on) in row.iter_mut().zip(&successors) {
                *ticks = (*ticks).min(to_there.saturating_add(*on));
            }
        }
    }
    quickest
}

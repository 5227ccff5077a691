//! Re-insertion of visits: each missing node, in random order, at its best position if it fits.

use super::route::{InsertionPoint, Route};
use crate::routing::network::{Network, Node};
use apex_planning::random::Generator;

/// In routes of more stops only positions next to a node's neighbours are examined.
const SCANNED_MAX: usize = 60;

/// Denominator of the chances to skip two positions: one, and another this many positions later.
const SKIPPED_OF: usize = 100;
const SKIPPED_BELOW: usize = 33;

/// One in this many nodes without value is inserted nevertheless.
const WORTHLESS_ONE_OF: usize = 3;

/// Weights of a delay of the next stop against longer legs.
const SHIFT_WEIGHTS: [i64; 4] = [0, 1, 2, 8];

/// Order of insertion of missing nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InsertionOrder {
    /// Random.
    Chance,
    /// The most valuable first.
    Value,
    /// The most value per path from the nearest nodes first.
    Worth,
    /// Nodes whose window closes first.
    Closing,
}

/// Nodes that may be inserted, with their keys; the memory is reused for each call.
#[derive(Default)]
pub(super) struct Recreation {
    keys: Vec<(f64, u32)>,
}

impl Recreation {
    /// Inserts those of `missing` that fit and are worthwhile; if `may_be_generous`, half of the calls insert the others that fit, too.
    /// Returns the number of examined positions.
    pub(super) fn run(
        &mut self,
        network: &Network,
        route: &mut Route,
        missing: &[u32],
        ease: &[f64],
        may_be_generous: bool,
        rng: &mut Generator,
    ) -> u64 {
        let order = match rng.below(8) {
            0 | 1 => InsertionOrder::Chance,
            2 | 3 => InsertionOrder::Value,
            4..=6 => InsertionOrder::Worth,
            _ => InsertionOrder::Closing,
        };
        let blur = 0.2 + 0.6 * rng.unit();
        self.keys.clear();
        for node in missing.iter().copied() {
            let noise = 1.0 + blur * (rng.unit() - 0.5);
            let data = network.node(node);
            let key = match order {
                InsertionOrder::Chance => noise,
                InsertionOrder::Value => data.value * noise,
                InsertionOrder::Worth => data.value * noise * ease.get(node as usize).copied().unwrap_or(1.0),
                InsertionOrder::Closing => -f64::from(data.close) * noise,
            };
            self.keys.push((key, node));
        }
        self.keys.sort_unstable_by(|(a, left), (b, right)| b.total_cmp(a).then(left.cmp(right)));
        // Some positions are skipped at random, so that results differ.
        let blind = rng.below(4) != 0;
        let weight = SHIFT_WEIGHTS.get(rng.below(SHIFT_WEIGHTS.len())).copied().unwrap_or(2);
        // Two visits may be worthwhile together although neither is alone.
        let generous = may_be_generous && network.cost_per_tick > 0.0 && rng.below(2) == 0;
        let mut looked = 0;
        for index in 0..self.keys.len() {
            let Some((_, node)) = self.keys.get(index).copied() else { break };
            if route.sees(network, node) {
                continue;
            }
            let (place, looks) = best_place(network, route, node, (blind, generous, weight), rng);
            looked += looks;
            if let Some(place) = place {
                route.insert(network, node, place.after);
                looked += route.stops.len() as u64;
            }
        }
        looked
    }
}

/// Returns the position at which `node` takes least time (its legs, and `weight` times the delay of the next stop), and the number of
/// examined positions. `None` if the node fits nowhere or, unless `generous`, costs more than its value.
pub(super) fn best_place(
    network: &Network,
    route: &Route,
    node: u32,
    (blind, generous, weight): (bool, bool, i64),
    rng: &mut Generator,
) -> (Option<InsertionPoint>, u64) {
    let mut looks = 8;
    let Node { open, close, value, .. } = network.node(node);
    let mut best: Option<(i64, InsertionPoint)> = None;
    let mut hear = |place: Option<InsertionPoint>| {
        looks += 1;
        if let Some(place) = place {
            let price = weight * i64::from(place.shift) + i64::from(place.longer);
            if best.is_none_or(|(least, _)| price < least) {
                best = Some((price, place));
            }
        }
    };
    if route.stops.len() > SCANNED_MAX && !network.near.is_empty() {
        hear(route.place(network, node, open, close, 0));
        hear(route.place(network, node, open, close, route.stops.len() - 2));
        for other in network.near.get(node as usize).into_iter().flatten() {
            if let Some(index) = route.index(*other) {
                hear(route.place(network, node, open, close, index - 1));
                hear(route.place(network, node, open, close, index));
            }
        }
    } else {
        let skipped = if blind { rng.below(SKIPPED_OF) } else { usize::MAX };
        let skipped = if skipped < SKIPPED_BELOW { [skipped, skipped + SKIPPED_BELOW] } else { [usize::MAX; 2] };
        // Before this position, later stops would be too late for any insertion.
        let first = route.stops.partition_point(|stop| stop.latest < open).saturating_sub(1);
        for (after, pair) in route.stops.windows(2).enumerate().skip(first) {
            let [before, next] = pair else { break };
            if before.begin > close {
                break;
            }
            if !skipped.contains(&after) {
                hear(Route::between(network, node, (open, close), (before, next), after));
            }
        }
    }
    let place = best.map(|(_, place)| place).filter(|place| {
        let cost = network.cost_per_tick * f64::from(place.end - route.end());
        // With given times, a visit without value may shorten the way to others.
        generous || value > cost || (value <= 0.0 && rng.below(WORTHLESS_ONE_OF) == 0)
    });
    (place, looks)
}

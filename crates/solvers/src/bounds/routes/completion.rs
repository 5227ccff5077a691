//! What a walk from a node at a time can still gather at the most, under prices: walks of `walks.rs`, from the end backwards.

use super::walks::Layout;
use crate::planners::single_visit::steady::network::{END, Network};

/// A way to go on: what it gathers, and the node it goes to next.
#[derive(Clone, Copy, Debug)]
struct Onward {
    value: f64,
    next: u32,
}

/// The flight ends.
const HOME: u32 = END;
const NO_WAY_ON: Onward = Onward { value: f64::NEG_INFINITY, next: HOME };

/// For each node and bucket of time the best way to go on, and the best to another node.
pub(super) struct Completion {
    layout: Layout,
    ways: Vec<[Onward; 2]>,
}

impl Completion {
    /// The best ways to go on from everywhere where each visit is worth its value less the price of its target; and the steps
    /// that were looked at. `onward` are, for each node, those that may follow it.
    pub(super) fn new(network: &Network, layout: &Layout, onward: &[Vec<u32>], prices: &[f64]) -> (Completion, u64) {
        let bucket = layout.bucket;
        let mut completion = Completion { layout: layout.clone(), ways: vec![[NO_WAY_ON; 2]; layout.count] };
        let mut steps = layout.count as u64;
        for time in (0..=network.limit() / bucket).rev() {
            for node in network.visits() {
                if let Some(state) = layout.state(node, time) {
                    let onward = onward.get(node as usize).map_or(&[][..], Vec::as_slice);
                    steps += 2 + onward.len() as u64;
                    let start = (time * bucket).max(network.node(node).open);
                    let best = completion.best_two(network, (onward, prices), node, start);
                    if let Some(slot) = completion.ways.get_mut(state) {
                        *slot = best;
                    }
                }
            }
        }
        (completion, steps)
    }

    fn best_two(&self, network: &Network, (onward, prices): (&[u32], &[f64]), node: u32, time: i32) -> [Onward; 2] {
        let mut two = [NO_WAY_ON; 2];
        if time + network.leg(node, END) <= network.limit() {
            two[0] = Onward { value: 0.0, next: HOME };
        }
        for next in onward.iter().copied() {
            let data = network.node(next);
            let arrive = time + network.leg(node, next);
            if arrive > data.close {
                continue;
            }
            let begin = arrive.max(data.open);
            let worth = data.value - prices.get(data.target as usize).copied().unwrap_or(0.0);
            let value = worth + self.after(next, begin, |back| back != node);
            if value > two[0].value {
                two = [Onward { value, next }, two[0]];
            } else if value > two[1].value {
                two[1] = Onward { value, next };
            }
        }
        two
    }

    /// The most that can be gathered after a visit of `node` that begins at `time`, where the next node is one that `may`
    /// follow; it is enough that the better of two ways is known.
    pub(super) fn after(&self, node: u32, time: i32, may: impl Fn(u32) -> bool) -> f64 {
        let ways = self.layout.state(node, time.div_euclid(self.layout.bucket)).and_then(|state| self.ways.get(state));
        let Some([first, second]) = ways else { return f64::NEG_INFINITY };
        if first.next == HOME || may(first.next) { first.value } else { second.value }
    }
}

//! Completion bounds from the walk relaxation (`walks.rs`), computed backwards from the end, under the current multipliers.

use super::walks::Layout;
use crate::routing::network::{END, Network};

/// A continuation: its profit, and its next node.
#[derive(Clone, Copy, Debug)]
struct Onward {
    value: f64,
    next: u32,
}

/// Next node of a continuation that ends the flight.
const HOME: u32 = END;
const NO_WAY_ON: Onward = Onward { value: f64::NEG_INFINITY, next: HOME };

/// For each node and time bucket the best continuation, and the best one with another next node.
pub(super) struct WalkCompletion {
    layout: Layout,
    ways: Vec<[Onward; 2]>,
}

impl WalkCompletion {
    /// Computes all continuations; a visit earns its value less the multiplier of its target. `successors` are the nodes that may
    /// follow each node. Also returns the steps taken.
    pub(super) fn new(
        network: &Network,
        layout: &Layout,
        successors: &[Vec<u32>],
        multipliers: &[f64],
    ) -> (WalkCompletion, u64) {
        let bucket = layout.bucket;
        let mut completion = WalkCompletion { layout: layout.clone(), ways: vec![[NO_WAY_ON; 2]; layout.count] };
        let mut steps = layout.count as u64;
        for time in (0..=network.limit() / bucket).rev() {
            for node in network.visits() {
                if let Some(state) = layout.state(node, time) {
                    let successors = successors.get(node as usize).map_or(&[][..], Vec::as_slice);
                    steps += 2 + successors.len() as u64;
                    let start = (time * bucket).max(network.node(node).open);
                    let best = completion.best_two(network, (successors, multipliers), node, start);
                    if let Some(slot) = completion.ways.get_mut(state) {
                        *slot = best;
                    }
                }
            }
        }
        (completion, steps)
    }

    fn best_two(
        &self,
        network: &Network,
        (successors, multipliers): (&[u32], &[f64]),
        node: u32,
        time: i32,
    ) -> [Onward; 2] {
        let mut two = [NO_WAY_ON; 2];
        if time + network.leg(node, END) <= network.limit() {
            two[0] = Onward { value: 0.0, next: HOME };
        }
        for next in successors.iter().copied() {
            let data = network.node(next);
            let arrive = time + network.leg(node, next);
            if arrive > data.close {
                continue;
            }
            let begin = arrive.max(data.open);
            let reduced_profit = data.value - multipliers.get(data.target as usize).copied().unwrap_or(0.0);
            let value = reduced_profit + self.after(next, begin, |back| back != node);
            if value > two[0].value {
                two = [Onward { value, next }, two[0]];
            } else if value > two[1].value {
                two[1] = Onward { value, next };
            }
        }
        two
    }

    /// Returns an upper bound on the profit after a visit of `node` that begins at `time`, over the next nodes that `may` admits. The
    /// better of two continuations suffices for a bound.
    pub(super) fn after(&self, node: u32, time: i32, may: impl Fn(u32) -> bool) -> f64 {
        let ways = self.layout.state(node, time.div_euclid(self.layout.bucket)).and_then(|state| self.ways.get(state));
        let Some([first, second]) = ways else { return f64::NEG_INFINITY };
        if first.next == HOME || may(first.next) { first.value } else { second.value }
    }
}

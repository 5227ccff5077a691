//! Completion bounds from the labels of a run in the opposite direction.

use super::labels::Label;
use super::ng_sets::{Targets, bit_of};
use super::pareto_front::ParetoFront;
use crate::routing::network::Network;

/// Time buckets of the whole flight.
const BUCKETS: i32 = 256;

/// For each node and time bucket: profits and memories of the partial routes from the other end that can follow a visit
/// that begins in the bucket, that visit not included.
pub(super) struct LabelCompletion {
    width: i32,
    fronts: Vec<(ParetoFront, f64)>,
}

impl LabelCompletion {
    /// Collects the bounds from `labels`, which come from the network with its ends exchanged, where each visit earned
    /// `reduced_profit`. Keeps at most `listed_max` pairs per node and bucket; of the others, only the highest profit.
    pub(super) fn new(
        network: &Network,
        labels: &[Label],
        reduced_profit: &[f64],
        listed_max: usize,
        steps: &mut u64,
    ) -> LabelCompletion {
        let limit = network.limit();
        let width = limit / BUCKETS + 1;
        let mut of_node: Vec<Vec<&Label>> = vec![Vec::new(); network.nodes.len()];
        for label in labels {
            if let Some(list) = of_node.get_mut(label.node as usize) {
                list.push(label);
            }
        }
        let nothing = (ParetoFront::default(), f64::NEG_INFINITY);
        let mut fronts = vec![nothing; network.nodes.len() * BUCKETS as usize];
        for (node, list) in (0..).zip(&mut of_node) {
            list.sort_by_key(|label| label.time);
            let own = bit_of(network.node(node).target);
            let gain = reduced_profit.get(node as usize).copied().unwrap_or(0.0);
            let (mut waiting, mut front, mut left_out) =
                (list.iter().peekable(), ParetoFront::default(), f64::NEG_INFINITY);
            // Fewer continuations remain the later a visit begins: those of one bucket are possible in every earlier one too.
            for bucket in (0..BUCKETS).rev() {
                while let Some(label) = waiting.next_if(|label| label.time <= limit - bucket * width) {
                    let (value, memory) = (label.value - gain, label.memory & !own);
                    if !front.beats(value, memory, steps) {
                        front.insert(value, memory, steps);
                        left_out = left_out.max(front.shorten(listed_max));
                    }
                }
                if let Some(slot) = fronts.get_mut(node as usize * BUCKETS as usize + bucket as usize) {
                    *slot = (front.clone(), left_out);
                    *steps += 4;
                }
            }
        }
        LabelCompletion { width, fronts }
    }

    /// Returns true if a route that visits `node` at `time` with `memory`, the target of the node not included, may still gain `cutoff`
    /// after it. An error is possible only towards true.
    #[inline]
    pub(super) fn may(&self, node: u32, time: i32, memory: Targets, cutoff: f64, steps: &mut u64) -> bool {
        let index = node as usize * BUCKETS as usize + (time / self.width) as usize;
        let Some((front, left_out)) = self.fronts.get(index) else { return true };
        *left_out >= cutoff || front.beats(cutoff, !memory, steps)
    }
}

//! What labels from the other end say of what can still be gathered.

use super::front::Front;
use super::labels::Label;
use super::memory::{Targets, bit_of};
use crate::planners::single_visit::steady::network::Network;

/// Buckets of the flight.
const BUCKETS: i32 = 256;
/// Pairs kept for a node and a bucket: of what is left out only the highest value is known. Tests have few pairs.
const LISTED_MAX: usize = if cfg!(test) { 2 } else { 64 };

/// For each node and bucket of time what ways from the other end gather that can follow a visit that begins in the bucket,
/// itself left out, with the targets that they remember.
pub(super) struct Rest {
    width: i32,
    fronts: Vec<(Front, f64)>,
}

impl Rest {
    /// `labels` are those of the same problem with its ends exchanged; each visit was worth `worth`.
    pub(super) fn new(network: &Network, labels: &[Label], worth: &[f64], steps: &mut u64) -> Rest {
        let limit = network.limit();
        let width = limit / BUCKETS + 1;
        let mut of_node: Vec<Vec<&Label>> = vec![Vec::new(); network.nodes.len()];
        for label in labels {
            if let Some(list) = of_node.get_mut(label.node as usize) {
                list.push(label);
            }
        }
        let nothing = (Front::default(), f64::NEG_INFINITY);
        let mut fronts = vec![nothing; network.nodes.len() * BUCKETS as usize];
        for (node, list) in (0..).zip(&mut of_node) {
            list.sort_by_key(|label| label.time);
            let own = bit_of(network.node(node).target);
            let gain = worth.get(node as usize).copied().unwrap_or(0.0);
            let (mut waiting, mut front, mut left_out) = (list.iter().peekable(), Front::default(), f64::NEG_INFINITY);
            // The later a visit begins, the less can follow: what follows in a bucket follows in all before it.
            for bucket in (0..BUCKETS).rev() {
                while let Some(label) = waiting.next_if(|label| label.time <= limit - bucket * width) {
                    let (value, seen) = (label.value - gain, label.seen & !own);
                    if !front.beats(value, seen, steps) {
                        front.insert(value, seen, steps);
                        left_out = left_out.max(front.shorten(LISTED_MAX));
                    }
                }
                if let Some(slot) = fronts.get_mut(node as usize * BUCKETS as usize + bucket as usize) {
                    *slot = (front.clone(), left_out);
                    *steps += 4;
                }
            }
        }
        Rest { width, fronts }
    }

    /// May a way that visits `node` at `time` and remembers `seen`, the node's own target left out, still gather `wanted`
    /// after it? Never no where it may.
    #[inline]
    pub(super) fn may(&self, node: u32, time: i32, seen: Targets, wanted: f64, steps: &mut u64) -> bool {
        let index = node as usize * BUCKETS as usize + (time / self.width) as usize;
        let Some((front, left_out)) = self.fronts.get(index) else { return true };
        *left_out >= wanted || front.beats(wanted, !seen, steps)
    }
}

//! The best walk from start to end through nodes and buckets of time, without going back at once to where it came from.

use crate::planners::single_visit::steady::network::{END, Network, START};

/// States kept at most: some tens of megabytes.
const STATES_MAX: usize = 1_500_000;
/// Buckets of the whole flight at least, or the bound is not worth its time.
const BUCKETS_MIN: i32 = 60;
/// No node.
const NONE: u32 = u32::MAX;

/// A way to be at a node in a bucket: what it gathered, and the state it came from.
#[derive(Clone, Copy, Debug)]
struct Way {
    value: f64,
    node: u32,
    state: u32,
    /// Was the state left by its second way?
    second: bool,
}

const NO_WALK: Way = Way { value: f64::NEG_INFINITY, node: NONE, state: NONE, second: false };

/// States of nodes and buckets of time, side by side.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Length of a bucket in ticks.
    pub(super) bucket: i32,
    /// For each node its first state and its first bucket, and how many it has.
    first: Vec<(usize, i32, i32)>,
    /// All states.
    pub(super) count: usize,
}

impl Layout {
    pub(super) fn new(network: &Network, bucket: i32) -> Layout {
        let mut count = 0;
        let mut first = Vec::with_capacity(network.nodes.len());
        for node in &network.nodes {
            let (from, until) = (node.open.div_euclid(bucket), node.close.div_euclid(bucket));
            let buckets = if node.open > node.close { 0 } else { until - from + 1 };
            first.push((count, from, buckets));
            count += buckets as usize;
        }
        Layout { bucket, first, count }
    }

    /// The state of `node` in a bucket, where it has one.
    #[inline]
    pub(super) fn state(&self, node: u32, bucket: i32) -> Option<usize> {
        let (first, from, count) = self.first.get(node as usize).copied()?;
        let within = bucket - from;
        (0..count).contains(&within).then(|| first + within as usize)
    }
}

/// The states, used again for other prices.
pub(super) struct Walks {
    layout: Layout,
    /// Each state's best way, and its best from another node.
    states: Vec<[Way; 2]>,
    /// How often the last best walk sees each target.
    counts: Vec<u32>,
}

impl Walks {
    /// Room for walks of which one search takes not many more than `steps`; none where buckets would be too long, or legs
    /// are shorter than a bucket.
    pub(super) fn new(network: &Network, steps: u64) -> Option<Walks> {
        let nodes = network.nodes.len() as u64;
        let shortest = network.visits().flat_map(|from| network.visits().map(move |to| (from, to)));
        let shortest = shortest.filter(|(from, to)| from != to).map(|(from, to)| network.leg(from, to)).min()?;
        let spans: i64 = network.nodes.iter().map(|node| i64::from((node.close - node.open).max(0))).sum();
        // Times are multiples of the common divisor: a finer bucket would gain nothing.
        let finest = divisor(network);
        let wanted = (spans as f64 * nodes as f64 / steps.max(1) as f64).max(spans as f64 / STATES_MAX as f64);
        let bucket = (libm::ceil(wanted / f64::from(finest)).min(1e8) as i32).saturating_mul(finest).max(finest);
        if bucket > shortest || network.limit() / bucket < BUCKETS_MIN {
            return None;
        }
        let layout = Layout::new(network, bucket);
        let states = vec![[NO_WALK; 2]; layout.count];
        Some(Walks { layout, states, counts: vec![0; network.targets] })
    }

    /// How often the last best walk sees each target.
    pub(super) fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// The value of the best walk where each visit pays the price of its target, and the steps that were looked at.
    pub(super) fn best(&mut self, network: &Network, prices: &[f64]) -> (f64, u64) {
        self.states.fill([NO_WALK; 2]);
        let mut steps = 2 * self.states.len() as u64;
        let worth: Vec<f64> = network
            .nodes
            .iter()
            .map(|node| node.value - prices.get(node.target as usize).copied().unwrap_or(0.0))
            .collect();
        let mut home = NO_WALK;
        let start = Way { value: 0.0, node: NONE, state: NONE, second: false };
        self.leave(network, (START, NONE, 0), [start, NO_WALK], &worth, &mut home);
        // What was reached earlier is at least as good: a state must beat it to be looked at.
        let mut beaten = vec![f64::NEG_INFINITY; network.nodes.len()];
        for bucket in 0..=network.limit() / self.layout.bucket {
            for node in network.visits() {
                let Some(state) = self.layout.state(node, bucket) else { continue };
                let Some(ways) = self.states.get(state).copied() else { continue };
                let Some(beaten) = beaten.get_mut(node as usize) else { continue };
                if ways[0].value <= *beaten {
                    continue;
                }
                *beaten = beaten.max(ways[1].value);
                steps += network.nodes.len() as u64;
                let time = (bucket * self.layout.bucket).max(network.node(node).open);
                self.leave(network, (node, state as u32, time), ways, &worth, &mut home);
            }
        }
        self.count(network, home);
        (home.value.max(0.0), steps)
    }

    /// Goes on from a state to every node that can be reached in time.
    fn leave(
        &mut self,
        network: &Network,
        (node, from, time): (u32, u32, i32),
        [best, other]: [Way; 2],
        worth: &[f64],
        home: &mut Way,
    ) {
        if time + network.leg(node, END) <= network.limit() && best.value > home.value {
            *home = Way { value: best.value, node, state: from, second: false };
        }
        for (to, worth) in network.visits().zip(worth.iter().skip(2)) {
            let data = network.node(to);
            let arrive = time + network.leg(node, to);
            if arrive > data.close {
                continue;
            }
            let second = best.node == to;
            let value = if second { other.value } else { best.value } + worth;
            let bucket = arrive.max(data.open).div_euclid(self.layout.bucket);
            let Some(state) = self.layout.state(to, bucket) else { continue };
            let Some(ways) = self.states.get_mut(state) else { continue };
            let way = Way { value, node, state: from, second };
            if value > ways[0].value {
                if ways[0].node != node {
                    ways[1] = ways[0];
                }
                ways[0] = way;
            } else if value > ways[1].value && ways[0].node != node {
                ways[1] = way;
            }
        }
    }

    /// Follows the best walk back and counts its visits.
    fn count(&mut self, network: &Network, home: Way) {
        self.counts.fill(0);
        let mut way = home;
        while way.node != NONE && way.node != START {
            if let Some(count) = self.counts.get_mut(network.node(way.node).target as usize) {
                *count += 1;
            }
            let Some(ways) = self.states.get(way.state as usize) else { return };
            way = if way.second { ways[1] } else { ways[0] };
        }
    }
}

/// The greatest number of ticks of which all legs and windows are multiples.
fn divisor(network: &Network) -> i32 {
    let opens = network.nodes.iter().map(|node| node.open);
    let legs = network.visits().flat_map(|from| network.visits().map(move |to| (from, to)));
    let legs = legs.filter(|(from, to)| from != to).map(|(from, to)| network.leg(from, to));
    let out = network.visits().map(|to| network.leg(START, to));
    let mut divisor = 0;
    for ticks in opens.chain(legs).chain(out) {
        let (mut a, mut b) = (divisor, ticks.max(0));
        while b != 0 {
            (a, b) = (b, a % b);
        }
        divisor = a;
        if divisor == 1 {
            break;
        }
    }
    divisor.max(1)
}

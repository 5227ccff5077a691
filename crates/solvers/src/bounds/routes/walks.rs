//! Best walk from start to end through nodes and time buckets, without returning directly to the preceding node.

use crate::routing::network::{END, Network, START};

/// Maximum number of states: some tens of megabytes.
const STATES_MAX: usize = 1_500_000;
/// Minimum number of buckets of the whole flight; with fewer, the bound is too weak for its time.
const BUCKETS_MIN: i32 = 60;
/// Index that means no node and no state.
const NONE: u32 = u32::MAX;

/// State of the dynamic program at a node and a bucket: its profit, and its predecessor.
#[derive(Clone, Copy, Debug)]
struct WalkState {
    value: f64,
    node: u32,
    state: u32,
    /// True if the predecessor is the second entry of its state.
    second: bool,
}

const NO_WALK: WalkState = WalkState { value: f64::NEG_INFINITY, node: NONE, state: NONE, second: false };

/// Layout of the states of all nodes and time buckets in one array.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// Length of a bucket in ticks.
    pub(super) bucket: i32,
    /// For each node its first state, its first bucket, and the number of its states.
    first: Vec<(usize, i32, i32)>,
    /// Number of states.
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

    /// Returns the state of `node` in a bucket; `None` if it has none there.
    #[inline]
    pub(super) fn state(&self, node: u32, bucket: i32) -> Option<usize> {
        let (first, from, count) = self.first.get(node as usize).copied()?;
        let within = bucket - from;
        (0..count).contains(&within).then(|| first + within as usize)
    }
}

/// The states, reused for other multipliers.
pub(super) struct Walks {
    layout: Layout,
    /// For each state the best walk, and the best with another preceding node.
    states: Vec<[WalkState; 2]>,
    /// Visits of each target by the last best walk.
    counts: Vec<u32>,
}

impl Walks {
    /// Allocates states such that one search takes about `steps`; `None` if buckets would be too long, or longer than a leg.
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

    /// Returns the number of visits of each target by the last best walk.
    pub(super) fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// Returns the profit of the best walk, whose visits are charged their multipliers, and the steps taken.
    pub(super) fn best(&mut self, network: &Network, multipliers: &[f64]) -> (f64, u64) {
        self.states.fill([NO_WALK; 2]);
        let mut steps = 2 * self.states.len() as u64;
        let reduced_profit: Vec<f64> = network
            .nodes
            .iter()
            .map(|node| node.value - multipliers.get(node.target as usize).copied().unwrap_or(0.0))
            .collect();
        let mut home = NO_WALK;
        let start = WalkState { value: 0.0, node: NONE, state: NONE, second: false };
        self.leave(network, (START, NONE, 0), [start, NO_WALK], &reduced_profit, &mut home);
        // A state is extended only if it exceeds the second walks of all earlier states of its node: of the two walks of a state, at
        // least one can continue to any node.
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
                self.leave(network, (node, state as u32, time), ways, &reduced_profit, &mut home);
            }
        }
        self.count(network, home);
        (home.value.max(0.0), steps)
    }

    /// Extends a state to every node that it reaches in time.
    fn leave(
        &mut self,
        network: &Network,
        (node, from, time): (u32, u32, i32),
        [best, other]: [WalkState; 2],
        reduced_profit: &[f64],
        home: &mut WalkState,
    ) {
        if time + network.leg(node, END) <= network.limit() && best.value > home.value {
            *home = WalkState { value: best.value, node, state: from, second: false };
        }
        for (to, reduced_profit) in network.visits().zip(reduced_profit.iter().skip(2)) {
            let data = network.node(to);
            let arrive = time + network.leg(node, to);
            if arrive > data.close {
                continue;
            }
            let second = best.node == to;
            let value = if second { other.value } else { best.value } + reduced_profit;
            let bucket = arrive.max(data.open).div_euclid(self.layout.bucket);
            let Some(state) = self.layout.state(to, bucket) else { continue };
            let Some(ways) = self.states.get_mut(state) else { continue };
            let way = WalkState { value, node, state: from, second };
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

    /// Traces the best walk back and counts its visits.
    fn count(&mut self, network: &Network, home: WalkState) {
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

/// Returns the greatest number of ticks of which all legs and windows are multiples.
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

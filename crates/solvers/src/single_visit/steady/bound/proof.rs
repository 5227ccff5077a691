//! The best route of few targets, proven: labels from both ends, each with the other end's for a bound, under prices.
//!
//! First prices are found under which walks hardly gain by coming back to a target. Then labels run from the start to the
//! end, from the end to the start, and so on: a label goes on only where what the last run from the other end knows lets it
//! come to what is wanted. After each run the targets between two visits of one remember that one, so walks get nearer to
//! routes and labels fewer (decremental state space relaxation: Righini and Salani 2008). Where the best walk visits no
//! target twice and yet is worth less than its bound, because of prices for targets it leaves out, labels count values
//! themselves, and prices are given back only for what may still be seen.

use super::super::network::Network;
use super::completion::Completion;
use super::grain::Grain;
use super::labels::{Ahead, Found, Given, STEPS_PER_UNIT, Search};
use super::late::Late;
use super::prices::Rounds;
use super::rest::Rest;
use super::walks::Layout;
use super::{Proven, memory, worths};
use apex_model::solver::Budget;

/// Targets that each one remembers in the beginning, itself included. Tests have few targets, and want walks that come back.
const REMEMBERED: usize = if cfg!(test) { 3 } else { 8 };
/// What they remember in the first runs: these have walks alone for a bound, so their labels must be few.
const FIRST_REMEMBERED: [usize; 4] = if cfg!(test) { [1, 2, 3, 4] } else { [3, 4, 5, 6] };
/// Runs under the same prices.
const RUNS_MAX: usize = 100;
/// Prices are found, and found anew where labels under them take too long: the first steps as shares of the gap, the targets
/// that a visit may be followed by meanwhile, and the share of the units left that labels may take.
const TURNS: [(f64, usize, f64); 3] = [(1.0, 14, 0.95), (0.5, 24, 0.7), (0.5, 64, 1.0)];
/// Buckets of the whole flight for bounds of walks, wanted and allowed.
const BUCKETS: i32 = 500;
const BUCKETS_MAX: i32 = 20_000;

/// A proof on its way.
struct Proof<'n> {
    /// The network, and with its ends exchanged.
    sides: [&'n Network; 2],
    late: [Late; 2],
    /// For each node all others.
    onward: Vec<Vec<u32>>,
    layout: Layout,
    grain: Grain,
    prices: Vec<f64>,
    sampled: Vec<u64>,
    remembers: Vec<u64>,
    reached: f64,
    known: Proven,
}

/// The least bound found within the units, from `prices` and the bound that they have; `reached` is what some route is
/// worth.
pub(super) fn best(
    network: &Network,
    prices: Vec<f64>,
    (bound, reached): (f64, f64),
    (until, budget): (u64, &mut dyn Budget),
) -> Proven {
    let known = Proven { bound, better: None };
    let Some(layout) = layout(network) else { return known };
    if network.targets > memory::TARGETS_MAX {
        return known;
    }
    let turned = network.turned();
    let others = |node: u32| network.visits().filter(|other| *other != node).collect();
    let mut proof = Proof {
        sides: [network, &turned],
        late: [Late::new(network), Late::new(&turned)],
        onward: (0..network.nodes.len() as u32).map(others).collect(),
        layout,
        grain: Grain::new(network),
        prices,
        sampled: memory::nearest(network, REMEMBERED),
        remembers: vec![0; network.targets],
        reached,
        known,
    };
    for (share, near, of_left) in TURNS {
        proof.find_prices(share, near, (until, budget));
        let left = until.saturating_sub(budget.used()) as f64;
        if proof.run(budget.used() + (of_left * left) as u64, budget) || budget.used() >= until || budget.exhausted() {
            break;
        }
    }
    proof.known
}

/// Buckets short enough that every leg takes one at least; none where these are too many.
fn layout(network: &Network) -> Option<Layout> {
    let legs = network.visits().flat_map(|from| network.visits().map(move |to| (from, to)));
    let shortest = legs.filter(|(from, to)| from != to).map(|(from, to)| network.leg(from, to)).min()?;
    let bucket = shortest.min(network.limit() / BUCKETS).max(1);
    (shortest > 0 && network.limit() / bucket <= BUCKETS_MAX).then(|| Layout::new(network, bucket))
}

impl Proof<'_> {
    fn find_prices(&mut self, share: f64, near: usize, (until, budget): (u64, &mut dyn Budget)) {
        let [network, _] = self.sides;
        let (reached, wanted) = (self.reached, self.grain.above(self.reached));
        let rounds = Rounds { network, late: &self.late[0], layout: &self.layout, near, reached, wanted };
        let mut best: Option<(f64, Vec<u32>)> = None;
        let mut hear = |walk: &[u32]| {
            let value = value_of(network, walk);
            if let Some(value) = value.filter(|value| best.as_ref().is_none_or(|(other, _)| value > other)) {
                best = Some((value, walk.to_vec()));
            }
        };
        rounds.run(&mut self.prices, &mut self.sampled, share, (until, budget), &mut hear);
        if let Some((_, walk)) = best {
            self.hear(walk);
        }
        self.remembers.iter_mut().zip(&self.sampled).for_each(|(all, sampled)| *all |= sampled);
    }

    /// Keeps a route that is better than what was reached.
    fn hear(&mut self, walk: Vec<u32>) -> bool {
        let value = value_of(self.sides[0], &walk).unwrap_or(f64::NEG_INFINITY);
        let better = value >= self.grain.above(self.reached);
        if better {
            self.reached = value;
            self.known.better = Some(walk);
        }
        better
    }

    /// Labels from both ends in turn: true where the best is proven, false where labels or units did not suffice.
    fn run(&mut self, until: u64, budget: &mut dyn Budget) -> bool {
        let worth = worths(self.sides[0], &self.prices);
        let given = Given::All(self.prices.iter().sum());
        let (completion, steps) = Completion::new(self.sides[0], &self.layout, &self.prices);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        let mut rest: Option<Rest> = None;
        for run in 0..RUNS_MAX {
            let end = run % 2;
            let first = FIRST_REMEMBERED.get(run).map(|size| {
                let few = memory::nearest(self.sides[0], *size);
                few.iter().zip(&self.remembers).map(|(few, all)| few & all).collect::<Vec<u64>>()
            });
            let ahead = rest.as_ref().map_or(Ahead::Walks(&completion), Ahead::Labels);
            let remembers = first.as_ref().unwrap_or(&self.remembers);
            let Some(found) = self.search(end, &worth, remembers, (ahead, given)).run(until, budget) else {
                return false;
            };
            let walk = in_order(end, &found);
            let stuck = first.is_none() && !memory::grow(&mut self.remembers, self.sides[0], &walk, u32::MAX);
            let better = self.hear(walk);
            if self.settles(&found) {
                return true;
            }
            let next = self.rest(end, &found, &worth, budget);
            if stuck && !better {
                return self.finish(1 - end, &next, until, budget);
            }
            rest = Some(next);
        }
        false
    }

    /// Labels that remember everything and count values themselves, from an end whose other end's labels say what is left: as
    /// `run`.
    fn finish(&mut self, end: usize, rest: &Rest, until: u64, budget: &mut dyn Budget) -> bool {
        let worth = worths(self.sides[0], &[]);
        let all = vec![u64::MAX; self.remembers.len()];
        let (ahead, given) = (Ahead::Labels(rest), Given::Open(&self.prices));
        let Some(found) = self.search(end, &worth, &all, (ahead, given)).run(until, budget) else {
            return false;
        };
        self.hear(in_order(end, &found));
        self.known.bound = self.known.bound.min(self.reached);
        true
    }

    fn search<'a>(
        &'a self,
        end: usize,
        worth: &'a [f64],
        remembers: &'a [u64],
        (ahead, given): (Ahead<'a>, Given<'a>),
    ) -> Search<'a> {
        let [start, turned] = self.sides;
        let (network, late) = if end == 0 { (start, &self.late[0]) } else { (turned, &self.late[1]) };
        let wanted = self.grain.above(self.reached);
        Search { network, late, worth, remembers, onward: &self.onward, ahead, given, wanted, slack: 0.0 }
    }

    /// What labels from `end` say to those from the other.
    fn rest(&self, end: usize, found: &Found, worth: &[f64], budget: &mut dyn Budget) -> Rest {
        let mut steps = 0;
        let rest = Rest::new(if end == 0 { self.sides[0] } else { self.sides[1] }, &found.labels, worth, &mut steps);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        rest
    }

    /// Takes what a search has proven: no route that is better is worth more than its best walk. True where that is no
    /// more than what was reached.
    fn settles(&mut self, found: &Found) -> bool {
        let bound = if found.is_nothing() { self.reached } else { found.value };
        self.known.bound = self.known.bound.min(bound);
        self.grain.below(self.known.bound) <= self.reached
    }
}

/// The walk that labels from `end` have found, from the start.
fn in_order(end: usize, found: &Found) -> Vec<u32> {
    let mut walk = found.walk.clone();
    if end == 1 {
        walk.reverse();
    }
    walk
}

/// What a walk is worth, where it sees no target twice.
pub(super) fn value_of(network: &Network, walk: &[u32]) -> Option<f64> {
    let (mut seen, mut value) = (0, 0.0);
    for node in walk.iter().map(|node| network.node(*node)) {
        let bit = memory::bit_of(node.target);
        if seen & bit != 0 {
            return None;
        }
        (seen, value) = (seen | bit, value + node.value);
    }
    Some(value)
}

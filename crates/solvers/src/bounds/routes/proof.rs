//! The best route of few targets, proven: labels from both ends, each with the other end's for a bound, under prices.
//!
//! First prices are found under which walks hardly gain by coming back to a target. Then labels run from the start to the
//! end, from the end to the start, and so on: a label goes on only where what the last run from the other end knows lets it
//! come to what is wanted. After each run the targets between two visits of one remember that one, so walks get nearer to
//! routes and labels fewer (decremental state space relaxation: Righini and Salani 2008). Where the best walk visits no
//! target twice and yet is worth less than its bound, because of prices for targets it leaves out, labels count values
//! themselves, and prices are given back only for what may still be seen.

use super::completion::Completion;
use super::grain::Grain;
use super::labels::{Ahead, Found, Given, STEPS_PER_UNIT, Search};
use super::late::Late;
use super::memory::{self, Targets};
use super::prices::Rounds;
use super::rest::Rest;
use super::walks::Layout;
use super::{Proven, worths};
use crate::planners::single_visit::steady::network::Network;
use apex_planning::solver::Budget;

/// Targets that each one remembers in the beginning, itself included. Tests have few targets, and want walks that come back.
const REMEMBERED: usize = if cfg!(test) { 3 } else { 8 };
/// What they remember in the first runs: these have walks alone for a bound, so their labels must be few.
const FIRST_REMEMBERED: [usize; 4] = if cfg!(test) { [1, 2, 3, 4] } else { [3, 4, 5, 6] };
/// Runs under the same prices.
const RUNS_MAX: usize = 100;
/// How prices are found, and labels tried under them.
#[derive(Clone, Copy)]
struct Turn {
    /// The first steps of prices as a share of the gap, and the least.
    share: f64,
    least: f64,
    /// Rounds without a better bound after which steps are halved.
    patience: u32,
    /// The targets that a visit may be followed by meanwhile.
    near: usize,
    /// The share of the units left that labels may take.
    of_left: f64,
}

/// In a hurry, which is enough where windows are narrow.
const QUICK: [Turn; 3] = [
    Turn { share: 1.0, least: 0.3, patience: 4, near: 14, of_left: 0.95 },
    Turn { share: 0.5, least: 0.3, patience: 4, near: 14, of_left: 0.7 },
    Turn { share: 0.5, least: 0.3, patience: 4, near: 24, of_left: 1.0 },
];
/// With care.
const CAREFUL: [Turn; 3] = [
    Turn { share: 1.0, least: 0.05, patience: 6, near: 14, of_left: 0.95 },
    Turn { share: 0.5, least: 0.05, patience: 6, near: 24, of_left: 0.7 },
    Turn { share: 0.5, least: 0.05, patience: 6, near: 64, of_left: 1.0 },
];
/// Buckets of the whole flight for bounds of walks: wanted, wanted while prices are sought in a hurry, and allowed.
const BUCKETS: i32 = 500;
const BUCKETS_IN_A_HURRY: i32 = 70;
const BUCKETS_MAX: i32 = 20_000;
/// The share of the units that the very first labels may take: where they take more, all that follows would take too long.
const FIRST_SHARE: f64 = 0.25;
/// Ways through another node that are looked at for one unit of work, from both ends.
const WAYS_PER_UNIT: u64 = 1_000;

/// A proof on its way.
pub(super) struct Proof<'n> {
    network: &'n Network,
    /// The network with its ends exchanged.
    turned: Network,
    late: [Late; 2],
    /// Of each of the two, for each node those that may follow it.
    onward: [Vec<Vec<u32>>; 2],
    layout: Layout,
    layout_in_a_hurry: Layout,
    grain: Grain,
    prices: Vec<f64>,
    sampled: Vec<Targets>,
    remembers: Vec<Targets>,
    /// What some route is worth.
    reached: f64,
    known: Proven,
    /// Are turns taken with care? The one that is on, and whether its prices are found.
    is_careful: bool,
    turn: usize,
    priced: bool,
}

/// Buckets short enough that every leg takes one at least; none where these are too many.
fn layout(network: &Network, buckets: i32) -> Option<Layout> {
    let legs = network.visits().flat_map(|from| network.visits().map(move |to| (from, to)));
    let shortest = legs.filter(|(from, to)| from != to).map(|(from, to)| network.leg(from, to)).min()?;
    let bucket = shortest.min(network.limit() / buckets).max(1);
    (shortest > 0 && network.limit() / bucket <= BUCKETS_MAX).then(|| Layout::new(network, bucket))
}

/// For each node the visits that are in time after it at its earliest.
pub(super) fn onward(network: &Network) -> Vec<Vec<u32>> {
    let follows = |node: u32, next: u32| {
        let (here, there) = (network.node(node), network.node(next));
        next != node && here.open + network.leg(node, next) <= there.close
    };
    let of = |node: u32| network.visits().filter(|next| follows(node, *next)).collect();
    (0..network.nodes.len() as u32).map(of).collect()
}

impl<'n> Proof<'n> {
    /// Work of `new`: the quickest ways through any other node, from either end.
    pub(super) fn units_to_begin(network: &Network) -> u64 {
        let nodes = network.nodes.len() as u64;
        1 + nodes.saturating_mul(nodes).saturating_mul(nodes) / WAYS_PER_UNIT
    }

    /// A proof that begins without prices, and the bound that is known; none where there are too many targets, or legs of no
    /// time.
    pub(super) fn new(network: &'n Network, bound: f64) -> Option<Proof<'n>> {
        if network.targets > memory::TARGETS_MAX {
            return None;
        }
        let (layout, layout_in_a_hurry) = (layout(network, BUCKETS)?, layout(network, BUCKETS_IN_A_HURRY)?);
        let turned = network.turned();
        Some(Proof {
            network,
            late: [Late::new(network), Late::new(&turned)],
            onward: [onward(network), onward(&turned)],
            turned,
            layout,
            layout_in_a_hurry,
            grain: Grain::new(network),
            prices: vec![0.0; network.targets],
            sampled: memory::nearest(network, REMEMBERED),
            remembers: vec![0; network.targets],
            reached: f64::NEG_INFINITY,
            known: Proven { bound, better: None },
            is_careful: false,
            turn: 0,
            priced: false,
        })
    }

    /// Begins with these prices, where no labels have come to an end yet.
    pub(super) fn begin_with(&mut self, prices: Vec<f64>) {
        self.prices = prices;
    }

    /// Begins anew with care, and with these prices if any are known: what was learnt in a hurry makes labels many.
    pub(super) fn begin_with_care(&mut self, prices: Option<Vec<f64>>) {
        self.prices = prices.unwrap_or_else(|| vec![0.0; self.network.targets]);
        (self.is_careful, self.turn, self.priced) = (true, 0, false);
        self.sampled = memory::nearest(self.network, REMEMBERED);
        self.remembers.fill(0);
    }

    /// The least bound known when the budget has used `until`, and a route that is worth more than `reached`, which is what
    /// some route is worth, if one was found. Goes on where the last call ended. False where even the first labels take too
    /// long: nothing is known then that was not known before.
    pub(super) fn run(&mut self, reached: f64, until: u64, budget: &mut dyn Budget) -> bool {
        (self.reached, self.known.better) = (reached, None);
        while let Some(turn) = self.turns().get(self.turn).copied() {
            if !self.priced && !self.find_prices(turn, (until, budget)) {
                return self.turn > 0;
            }
            // In a hurry what prices are by then is good enough to go on with.
            if self.is_careful && (budget.used() >= until || budget.exhausted()) {
                break;
            }
            self.priced = true;
            let left = until.saturating_sub(budget.used()) as f64;
            let settled = self.alternate(budget.used() + (turn.of_left * left) as u64, budget);
            if settled || budget.used() >= until || budget.exhausted() {
                break;
            }
            (self.turn, self.priced) = (self.turn + 1, false);
        }
        true
    }

    fn turns(&self) -> [Turn; 3] {
        if self.is_careful { CAREFUL } else { QUICK }
    }

    /// What is known by now.
    pub(super) fn known(&self) -> &Proven {
        &self.known
    }

    /// Finds prices; false where not even the first labels come to an end.
    fn find_prices(&mut self, turn: Turn, (until, budget): (u64, &mut dyn Budget)) -> bool {
        let Turn { share, least, patience, near, .. } = turn;
        let network = self.network;
        let (reached, wanted) = (self.reached, self.grain.above(self.reached));
        let layout = if self.is_careful { &self.layout } else { &self.layout_in_a_hurry };
        let rounds = Rounds {
            network,
            late: &self.late[0],
            onward: &self.onward[0],
            layout,
            near,
            least,
            patience,
            reached,
            wanted,
        };
        let mut best: Option<(f64, Vec<u32>)> = None;
        let mut hear = |walk: &[u32]| {
            let value = value_of(network, walk);
            if let Some(value) = value.filter(|value| best.as_ref().is_none_or(|(other, _)| value > other)) {
                best = Some((value, walk.to_vec()));
            }
        };
        let first = budget.used() + (FIRST_SHARE * until.saturating_sub(budget.used()) as f64) as u64;
        let found = rounds.run(&mut self.prices, &mut self.sampled, share, (first, until, budget), &mut hear);
        if let Some((_, walk)) = best {
            self.hear(walk);
        }
        self.remembers.iter_mut().zip(&self.sampled).for_each(|(all, sampled)| *all |= sampled);
        found
    }

    /// Keeps a route that is better than what was reached.
    fn hear(&mut self, walk: Vec<u32>) -> bool {
        let value = value_of(self.network, &walk).unwrap_or(f64::NEG_INFINITY);
        let better = value >= self.grain.above(self.reached);
        if better {
            self.reached = value;
            self.known.better = Some(walk);
        }
        better
    }

    /// Labels from both ends in turn: true where the best is proven, false where labels or units did not suffice.
    fn alternate(&mut self, until: u64, budget: &mut dyn Budget) -> bool {
        let worth = worths(self.network, &self.prices);
        let given = Given::All(self.prices.iter().sum());
        let (completion, steps) = Completion::new(self.network, &self.layout, &self.onward[0], &self.prices);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        let mut rest: Option<Rest> = None;
        let began = budget.used();
        for run in 0..RUNS_MAX {
            let end = run % 2;
            let first = FIRST_REMEMBERED.get(run).map(|size| {
                let few = memory::nearest(self.network, *size);
                few.iter().zip(&self.remembers).map(|(few, all)| few & all).collect::<Vec<Targets>>()
            });
            let ahead = rest.as_ref().map_or(Ahead::Walks(&completion), Ahead::Labels);
            let remembers = first.as_ref().unwrap_or(&self.remembers);
            let Some(found) = self.search(end, &worth, remembers, (ahead, given)).run(until, budget) else {
                return false;
            };
            let walk = in_order(end, &found.walk);
            let mut stuck = first.is_none();
            if stuck {
                stuck = !memory::grow(&mut self.remembers, self.network, &walk, u32::MAX);
                let others = if self.is_careful { &[] } else { found.others.as_slice() };
                for other in others.iter().map(|other| in_order(end, other)) {
                    memory::grow(&mut self.remembers, self.network, &other, u32::MAX);
                }
            }
            let better = self.hear(walk);
            if self.settles(&found) {
                return true;
            }
            let next = self.rest(end, &found, &worth, budget);
            if stuck && !better {
                // Either it is quickly done, or other prices help more.
                let last = self.turn + 1 == CAREFUL.len() && self.is_careful;
                let until = if last { until } else { until.min(budget.used() + (budget.used() - began)) };
                return self.finish(1 - end, &next, until, budget);
            }
            rest = Some(next);
        }
        false
    }

    /// Labels that remember everything and count values themselves, from an end whose other end's labels say what is left: as
    /// `alternate`.
    fn finish(&mut self, end: usize, rest: &Rest, until: u64, budget: &mut dyn Budget) -> bool {
        let worth = worths(self.network, &[]);
        let all = vec![Targets::MAX; self.remembers.len()];
        let (ahead, given) = (Ahead::Labels(rest), Given::Open(&self.prices));
        let Some(found) = self.search(end, &worth, &all, (ahead, given)).run(until, budget) else {
            return false;
        };
        self.hear(in_order(end, &found.walk));
        self.known.bound = self.known.bound.min(self.reached);
        true
    }

    fn search<'a>(
        &'a self,
        end: usize,
        worth: &'a [f64],
        remembers: &'a [Targets],
        (ahead, given): (Ahead<'a>, Given<'a>),
    ) -> Search<'a> {
        let [first, second] = &self.onward;
        let (network, late, onward) = match end {
            0 => (self.network, &self.late[0], first),
            _ => (&self.turned, &self.late[1], second),
        };
        let wanted = self.grain.above(self.reached);
        Search { network, late, worth, remembers, onward, ahead, given, wanted, slack: 0.0 }
    }

    /// What labels from `end` say to those from the other.
    fn rest(&self, end: usize, found: &Found, worth: &[f64], budget: &mut dyn Budget) -> Rest {
        let mut steps = 0;
        let rest = Rest::new(if end == 0 { self.network } else { &self.turned }, &found.labels, worth, &mut steps);
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

/// A walk that labels from `end` have found, from the start.
fn in_order(end: usize, walk: &[u32]) -> Vec<u32> {
    let mut walk = walk.to_vec();
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

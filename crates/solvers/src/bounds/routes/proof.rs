//! Exact search for the best route of few targets: labels from both ends, each bounded by the labels of the other end.
//!
//! First, subgradient steps find multipliers under which walks gain little from revisits. Then labels run from the start,
//! from the end, and so on; each run prunes labels by the completion bounds of the run before. After each run, a target that
//! the best walk revisits joins the ng-sets of the targets between its visits (decremental state space relaxation: Righini and
//! Salani 2008). The best walk may visit no target twice and still have less profit than its bound, because multipliers of unvisited
//! targets are refunded. A last run then counts full values and refunds only multipliers of targets that may still be visited.

use super::label_completion::LabelCompletion;
use super::labels::{CompletionBound, Labelling, LabellingResult, MultiplierRefund, STEPS_PER_UNIT};
use super::latest_departures::LatestDepartures;
use super::ng_sets::{self, Targets};
use super::subgradient::SubgradientAscent;
use super::value_step::ValueStep;
use super::walk_completion::WalkCompletion;
use super::walks::Layout;
use super::{Proven, reduced_profits};
use crate::routing::network::Network;
use apex_planning::solver::Budget;

/// Sizes of ng-sets and of completion bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemorySizes {
    /// Initial size of an ng-set, its own target included.
    pub(super) remembered: usize,
    /// Sizes in the first runs. These have only walks as completion bounds, so their labels must be few.
    pub(super) first_remembered: [usize; 4],
    /// Pairs kept per node and time bucket; of the others, only the highest value.
    pub(super) listed_max: usize,
}

impl MemorySizes {
    /// The sizes that ship. Tests with few targets also use smaller ones, with which walks revisit targets.
    pub(super) const SHIPPED: MemorySizes =
        MemorySizes { remembered: 8, first_remembered: [3, 4, 5, 6], listed_max: 64 };
}

/// Maximum number of runs under the same multipliers.
const RUNS_MAX: usize = 100;
/// Parameters of one pass: subgradient steps, then labels.
#[derive(Clone, Copy)]
struct ProofPass {
    /// Initial and least step length, as shares of the gap.
    share: f64,
    least: f64,
    /// Steps without a better bound after which their length is halved.
    patience: u32,
    /// Number of nearest targets that may follow a visit during the steps.
    near: usize,
    /// Share of the remaining units that labels may take.
    of_left: f64,
}

/// Fast passes, sufficient for narrow time windows.
const FAST_PASSES: [ProofPass; 3] = [
    ProofPass { share: 1.0, least: 0.3, patience: 4, near: 14, of_left: 0.95 },
    ProofPass { share: 0.5, least: 0.3, patience: 4, near: 14, of_left: 0.7 },
    ProofPass { share: 0.5, least: 0.3, patience: 4, near: 24, of_left: 1.0 },
];
/// Fine passes.
const FINE_PASSES: [ProofPass; 3] = [
    ProofPass { share: 1.0, least: 0.05, patience: 6, near: 14, of_left: 0.95 },
    ProofPass { share: 0.5, least: 0.05, patience: 6, near: 24, of_left: 0.7 },
    ProofPass { share: 0.5, least: 0.05, patience: 6, near: 64, of_left: 1.0 },
];
/// Time buckets of the whole flight for completion bounds of walks: for labels, for the steps of a fast pass, and their maximum.
const BUCKETS: i32 = 500;
const COARSE_BUCKETS: i32 = 70;
const BUCKETS_MAX: i32 = 20_000;
/// Share of the units that the first labels may take: if they need more, the runs after them would take too long.
const FIRST_SHARE: f64 = 0.25;
/// Paths through another node inspected per unit of work, from both ends.
const WAYS_PER_UNIT: u64 = 1_000;

/// State of the search.
pub(super) struct ProofSearch<'n> {
    network: &'n Network,
    sizes: MemorySizes,
    /// The network with its ends exchanged.
    turned: Network,
    latest_departures: [LatestDepartures; 2],
    /// The nodes that may follow each node, in both networks.
    successors: [Vec<Vec<u32>>; 2],
    layout: Layout,
    coarse_layout: Layout,
    value_step: ValueStep,
    multipliers: Vec<f64>,
    sampled: Vec<Targets>,
    ng_sets: Vec<Targets>,
    /// Profit of the best known route.
    incumbent: f64,
    known: Proven,
    /// True if passes are fine; the index of the current pass; true if its multipliers are found.
    is_fine_pass: bool,
    pass: usize,
    priced: bool,
}

/// Returns buckets so short that every leg takes at least one; `None` if these are more than [`BUCKETS_MAX`].
fn layout(network: &Network, buckets: i32) -> Option<Layout> {
    let legs = network.visits().flat_map(|from| network.visits().map(move |to| (from, to)));
    let shortest = legs.filter(|(from, to)| from != to).map(|(from, to)| network.leg(from, to)).min()?;
    let bucket = shortest.min(network.limit() / buckets).max(1);
    (shortest > 0 && network.limit() / bucket <= BUCKETS_MAX).then(|| Layout::new(network, bucket))
}

/// Returns for each node the visits that are in time after its earliest time.
pub(super) fn successors(network: &Network) -> Vec<Vec<u32>> {
    let follows = |node: u32, next: u32| {
        let (here, there) = (network.node(node), network.node(next));
        next != node && here.open + network.leg(node, next) <= there.close
    };
    let of = |node: u32| network.visits().filter(|next| follows(node, *next)).collect();
    (0..network.nodes.len() as u32).map(of).collect()
}

impl<'n> ProofSearch<'n> {
    /// Returns the work of `new`: shortest paths through any other node, from either end.
    pub(super) fn units_to_begin(network: &Network) -> u64 {
        let nodes = network.nodes.len() as u64;
        1 + nodes.saturating_mul(nodes).saturating_mul(nodes) / WAYS_PER_UNIT
    }

    /// Returns a search without multipliers that knows `bound`. `None` if there are too many targets, or a leg takes no time.
    pub(super) fn new(network: &'n Network, bound: f64, sizes: MemorySizes) -> Option<ProofSearch<'n>> {
        if network.targets > ng_sets::TARGETS_MAX {
            return None;
        }
        let (layout, coarse_layout) = (layout(network, BUCKETS)?, layout(network, COARSE_BUCKETS)?);
        let turned = network.turned();
        Some(ProofSearch {
            network,
            sizes,
            latest_departures: [LatestDepartures::new(network), LatestDepartures::new(&turned)],
            successors: [successors(network), successors(&turned)],
            turned,
            layout,
            coarse_layout,
            value_step: ValueStep::new(network),
            multipliers: vec![0.0; network.targets],
            sampled: ng_sets::nearest(network, sizes.remembered),
            ng_sets: vec![0; network.targets],
            incumbent: f64::NEG_INFINITY,
            known: Proven { bound, better: None },
            is_fine_pass: false,
            pass: 0,
            priced: false,
        })
    }

    /// Begins with these multipliers; only before the first labels.
    pub(super) fn begin_with(&mut self, multipliers: Vec<f64>) {
        self.multipliers = multipliers;
    }

    /// Restarts with fine passes and these multipliers, if any; the ng-sets of fast passes would create too many labels.
    pub(super) fn restart_fine(&mut self, multipliers: Option<Vec<f64>>) {
        self.multipliers = multipliers.unwrap_or_else(|| vec![0.0; self.network.targets]);
        (self.is_fine_pass, self.pass, self.priced) = (true, 0, false);
        self.sampled = ng_sets::nearest(self.network, self.sizes.remembered);
        self.ng_sets.fill(0);
    }

    /// Continues until the budget has used `until`, and updates the least bound and the best route ([`ProofSearch::known`]). `incumbent`
    /// is the profit of a known route. Returns false if the first labels did not finish: then nothing new is known.
    pub(super) fn run(&mut self, incumbent: f64, until: u64, budget: &mut dyn Budget) -> bool {
        (self.incumbent, self.known.better) = (incumbent, None);
        while let Some(pass) = self.passes().get(self.pass).copied() {
            if !self.priced && !self.find_multipliers(pass, (until, budget)) {
                return self.pass > 0;
            }
            // In a fast pass the multipliers found by then suffice.
            if self.is_fine_pass && (budget.used() >= until || budget.exhausted()) {
                break;
            }
            self.priced = true;
            let left = until.saturating_sub(budget.used()) as f64;
            let settled = self.alternate(budget.used() + (pass.of_left * left) as u64, budget);
            if settled || budget.used() >= until || budget.exhausted() {
                break;
            }
            (self.pass, self.priced) = (self.pass + 1, false);
        }
        true
    }

    fn passes(&self) -> [ProofPass; 3] {
        if self.is_fine_pass { FINE_PASSES } else { FAST_PASSES }
    }

    /// Returns the present bound and best route.
    pub(super) fn known(&self) -> &Proven {
        &self.known
    }

    /// Finds multipliers. Returns false if even the first labels did not end.
    fn find_multipliers(&mut self, pass: ProofPass, (until, budget): (u64, &mut dyn Budget)) -> bool {
        let ProofPass { share, least, patience, near, .. } = pass;
        let network = self.network;
        let (incumbent, cutoff) = (self.incumbent, self.value_step.above(self.incumbent));
        let layout = if self.is_fine_pass { &self.layout } else { &self.coarse_layout };
        let rounds = SubgradientAscent {
            network,
            latest_departures: &self.latest_departures[0],
            successors: &self.successors[0],
            layout,
            near,
            least,
            patience,
            incumbent,
            cutoff,
        };
        let mut best: Option<(f64, Vec<u32>)> = None;
        let mut hear = |walk: &[u32]| {
            let value = value_of(network, walk);
            if let Some(value) = value.filter(|value| best.as_ref().is_none_or(|(other, _)| value > other)) {
                best = Some((value, walk.to_vec()));
            }
        };
        let first = budget.used() + (FIRST_SHARE * until.saturating_sub(budget.used()) as f64) as u64;
        let found = rounds.run(&mut self.multipliers, &mut self.sampled, share, (first, until, budget), &mut hear);
        if let Some((_, walk)) = best {
            self.hear(walk);
        }
        self.ng_sets.iter_mut().zip(&self.sampled).for_each(|(all, sampled)| *all |= sampled);
        found
    }

    /// Keeps a route with more profit than the incumbent. Returns true if it was kept.
    fn hear(&mut self, walk: Vec<u32>) -> bool {
        let value = value_of(self.network, &walk).unwrap_or(f64::NEG_INFINITY);
        let better = value >= self.value_step.above(self.incumbent);
        if better {
            self.incumbent = value;
            self.known.better = Some(walk);
        }
        better
    }

    /// Runs labels from both ends alternately. Returns true if the best route is proven, false if labels or units did not suffice.
    fn alternate(&mut self, until: u64, budget: &mut dyn Budget) -> bool {
        let reduced_profit = reduced_profits(self.network, &self.multipliers);
        let refund = MultiplierRefund::All(self.multipliers.iter().sum());
        let (completion, steps) =
            WalkCompletion::new(self.network, &self.layout, &self.successors[0], &self.multipliers);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        let mut rest: Option<LabelCompletion> = None;
        let began = budget.used();
        for run in 0..RUNS_MAX {
            let end = run % 2;
            let first = self.sizes.first_remembered.get(run).map(|size| {
                let few = ng_sets::nearest(self.network, *size);
                few.iter().zip(&self.ng_sets).map(|(few, all)| few & all).collect::<Vec<Targets>>()
            });
            let completion_bound = rest.as_ref().map_or(CompletionBound::Walks(&completion), CompletionBound::Labels);
            let ng_sets = first.as_ref().unwrap_or(&self.ng_sets);
            let Some(found) = self.search(end, &reduced_profit, ng_sets, (completion_bound, refund)).run(until, budget)
            else {
                return false;
            };
            let walk = in_order(end, &found.walk);
            let mut stuck = first.is_none();
            if stuck {
                stuck = !ng_sets::grow(&mut self.ng_sets, self.network, &walk, u32::MAX);
                let others = if self.is_fine_pass { &[] } else { found.others.as_slice() };
                for other in others.iter().map(|other| in_order(end, other)) {
                    ng_sets::grow(&mut self.ng_sets, self.network, &other, u32::MAX);
                }
            }
            let better = self.hear(walk);
            if self.settles(&found) {
                return true;
            }
            let next = self.rest(end, &found, &reduced_profit, budget);
            if stuck && !better {
                // Except in the last fine pass, this run may take as much work as those before it: if it needs more, other
                // multipliers help more.
                let last = self.pass + 1 == FINE_PASSES.len() && self.is_fine_pass;
                let until = if last { until } else { until.min(budget.used() + (budget.used() - began)) };
                return self.finish(1 - end, &next, until, budget);
            }
            rest = Some(next);
        }
        false
    }

    /// Runs labels with full memory and full values from `end`, bounded by the labels of the other end. Returns as `alternate`.
    fn finish(&mut self, end: usize, rest: &LabelCompletion, until: u64, budget: &mut dyn Budget) -> bool {
        let reduced_profit = reduced_profits(self.network, &[]);
        let all = vec![Targets::MAX; self.ng_sets.len()];
        let (completion_bound, refund) =
            (CompletionBound::Labels(rest), MultiplierRefund::Unvisited(&self.multipliers));
        let Some(found) = self.search(end, &reduced_profit, &all, (completion_bound, refund)).run(until, budget) else {
            return false;
        };
        self.hear(in_order(end, &found.walk));
        self.known.bound = self.known.bound.min(self.incumbent);
        true
    }

    fn search<'a>(
        &'a self,
        end: usize,
        reduced_profit: &'a [f64],
        ng_sets: &'a [Targets],
        (completion_bound, refund): (CompletionBound<'a>, MultiplierRefund<'a>),
    ) -> Labelling<'a> {
        let [first, second] = &self.successors;
        let (network, latest_departures, successors) = match end {
            0 => (self.network, &self.latest_departures[0], first),
            _ => (&self.turned, &self.latest_departures[1], second),
        };
        let cutoff = self.value_step.above(self.incumbent);
        Labelling {
            network,
            latest_departures,
            reduced_profit,
            ng_sets,
            successors,
            completion_bound,
            refund,
            cutoff,
            slack: 0.0,
        }
    }

    /// Returns the completion bounds for the other end from the labels of `end`.
    fn rest(
        &self,
        end: usize,
        found: &LabellingResult,
        reduced_profit: &[f64],
        budget: &mut dyn Budget,
    ) -> LabelCompletion {
        let mut steps = 0;
        let network = if end == 0 { self.network } else { &self.turned };
        let rest = LabelCompletion::new(network, &found.labels, reduced_profit, self.sizes.listed_max, &mut steps);
        budget.charge(1 + steps / STEPS_PER_UNIT);
        rest
    }

    /// Updates the bound by the result of a run. Returns true if it does not exceed the incumbent.
    fn settles(&mut self, found: &LabellingResult) -> bool {
        let bound = if found.is_nothing() { self.incumbent } else { found.value };
        self.known.bound = self.known.bound.min(bound);
        self.value_step.below(self.known.bound) <= self.incumbent
    }
}

/// Returns a walk found from `end`, in order from the start.
fn in_order(end: usize, walk: &[u32]) -> Vec<u32> {
    let mut walk = walk.to_vec();
    if end == 1 {
        walk.reverse();
    }
    walk
}

/// Returns the profit of a walk; `None` if it visits a target twice.
pub(super) fn value_of(network: &Network, walk: &[u32]) -> Option<f64> {
    let (mut seen, mut value) = (0, 0.0);
    for node in walk.iter().map(|node| network.node(*node)) {
        let bit = ng_sets::bit_of(node.target);
        if seen & bit != 0 {
            return None;
        }
        (seen, value) = (seen | bit, value + node.value);
    }
    Some(value)
}

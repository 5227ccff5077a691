//! Prices on visits, found on samples: walks that are good, though not proven to be the best.
//!
//! The bound under any prices is a true one, so they may be found in a hurry: labels beat each other a little too soon, and
//! go on to near targets only. Each round moves prices along what the best walk visits too often or not at all, by less and
//! less; and now and then the walk's targets remember what they came back to.

use super::completion::Completion;
use super::labels::{Ahead, Given, STEPS_PER_UNIT, Search};
use super::late::Late;
use super::memory::{self, Targets};
use super::walks::Layout;
use super::{step, worths};
use crate::planners::single_visit::steady::network::{FIRST, Network};
use apex_planning::solver::Budget;

/// Rounds at most.
const ROUNDS_MAX: u32 = 200;
/// A bound is better when it is so by this share.
const BETTER: f64 = 1e-4;
/// By this share of a target's mean value labels beat each other too soon.
const SLACK: f64 = 0.1;
/// It shrinks with the steps, to this share of itself.
const SLACK_SHARE_MIN: f64 = 0.5;
/// Targets that each one remembers at most while prices are sought.
const REMEMBERED_MAX: u32 = 12;

/// What the rounds need of the problem.
pub(super) struct Rounds<'a> {
    pub(super) network: &'a Network,
    pub(super) late: &'a Late,
    /// For each node those that may follow it.
    pub(super) onward: &'a [Vec<u32>],
    pub(super) layout: &'a Layout,
    /// Targets that a visit may be followed by.
    pub(super) near: usize,
    /// The smallest steps, as a share of the gap.
    pub(super) least: f64,
    /// Rounds without a better bound after which steps are halved.
    pub(super) patience: u32,
    /// What some route is worth, and what another must be worth to be better.
    pub(super) reached: f64,
    pub(super) wanted: f64,
}

impl Rounds<'_> {
    /// Moves `prices` from where they are, beginning with steps of `share` of the gap. Tells `hear` of each walk. False where
    /// the first round does not end before the budget has used `first`.
    pub(super) fn run(
        &self,
        prices: &mut Vec<f64>,
        remembers: &mut [Targets],
        mut share: f64,
        (first, until, budget): (u64, u64, &mut dyn Budget),
        hear: &mut dyn FnMut(&[u32]),
    ) -> bool {
        let network = self.network;
        let onward = near(network, self.onward, self.near);
        let visits = network.visits().len().max(1) as f64;
        let slack = SLACK * network.nodes.iter().map(|node| node.value).sum::<f64>() / visits;
        let (mut best, mut kept, mut stale) = (f64::INFINITY, prices.clone(), 0);
        let mut counts = vec![0_u32; network.targets];
        for round in 0..ROUNDS_MAX {
            let worth = worths(network, prices);
            let (completion, steps) = Completion::new(network, self.layout, self.onward, prices);
            budget.charge(1 + steps / STEPS_PER_UNIT);
            let search = Search {
                network,
                late: self.late,
                worth: &worth,
                remembers,
                onward: &onward,
                ahead: Ahead::Walks(&completion),
                given: Given::All(prices.iter().sum()),
                wanted: self.wanted,
                slack: slack * share.max(SLACK_SHARE_MIN),
            };
            let Some(found) = search.run(if round == 0 { first } else { until }, budget) else {
                if round == 0 {
                    return false;
                }
                break;
            };
            if found.is_nothing() {
                kept.clone_from(prices);
                break;
            }
            hear(&found.walk);
            stale = if found.value < best * (1.0 - BETTER) { 0 } else { stale + 1 };
            if found.value < best {
                best = found.value;
                kept.clone_from(prices);
            }
            if stale >= self.patience {
                (share, stale) = (0.5 * share, 0);
                prices.clone_from(&kept);
                if share >= SLACK_SHARE_MIN {
                    // Labels beat each other less soon from now on: bounds before and after do not compare.
                    best = f64::INFINITY;
                }
                memory::grow(remembers, network, &found.walk, REMEMBERED_MAX);
            }
            counts.fill(0);
            for node in &found.walk {
                if let Some(count) = counts.get_mut(network.node(*node).target as usize) {
                    *count += 1;
                }
            }
            if share < self.least || !step(prices, &counts, share * (found.value - self.reached)) {
                break;
            }
        }
        prices.clone_from(&kept);
        true
    }
}

/// For each node those of about as many `targets` that are quickly reached from it; from the start, all.
fn near(network: &Network, onward: &[Vec<u32>], targets: usize) -> Vec<Vec<u32>> {
    let most = targets * network.visits().len().div_ceil(network.targets.max(1));
    let of = |(node, others): (u32, &Vec<u32>)| {
        let mut others = others.clone();
        if node >= FIRST {
            others.sort_by_key(|other| network.leg(node, *other));
            others.truncate(most);
        }
        others
    };
    (0..).zip(onward).map(of).collect()
}

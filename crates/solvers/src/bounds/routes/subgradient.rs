//! Subgradient ascent for the multipliers, with heuristic labels: good walks, not proven best ones.
//!
//! The bound under any multipliers is valid, so they may be found heuristically: labels dominate others of slightly more profit,
//! and continue to near targets only. Each step moves multipliers along the visits of the best walk, by decreasing lengths. From
//! time to time, a target that the walk revisits joins the ng-sets between its visits.

use super::labels::{CompletionBound, Labelling, MultiplierRefund, STEPS_PER_UNIT};
use super::latest_departures::LatestDepartures;
use super::ng_sets::{self, Targets};
use super::walk_completion::WalkCompletion;
use super::walks::Layout;
use super::{reduced_profits, step};
use crate::routing::network::{FIRST, Network};
use apex_planning::solver::Budget;

/// Maximum number of steps.
const ROUNDS_MAX: u32 = 200;
/// Least relative improvement that counts as a better bound.
const BETTER: f64 = 1e-4;
/// Slack of dominance, as a share of a target's mean value.
const SLACK: f64 = 0.1;
/// The slack decreases with the step length, down to this share.
const SLACK_SHARE_MIN: f64 = 0.5;
/// Maximum size of an ng-set during the ascent.
const REMEMBERED_MAX: u32 = 12;

/// Parameters of the ascent.
pub(super) struct SubgradientAscent<'a> {
    pub(super) network: &'a Network,
    pub(super) latest_departures: &'a LatestDepartures,
    /// The nodes that may follow each node.
    pub(super) successors: &'a [Vec<u32>],
    pub(super) layout: &'a Layout,
    /// Number of nearest targets that may follow a visit.
    pub(super) near: usize,
    /// Least step length, as a share of the gap.
    pub(super) least: f64,
    /// Steps without a better bound after which their length is halved.
    pub(super) patience: u32,
    /// Profit of the best known route, and the least profit of a better one.
    pub(super) incumbent: f64,
    pub(super) cutoff: f64,
}

impl SubgradientAscent<'_> {
    /// Improves `multipliers`; the first steps have the length `share` of the gap. Passes each walk to `hear`. Returns false if the first
    /// step does not end before the budget has used `first`.
    pub(super) fn run(
        &self,
        multipliers: &mut Vec<f64>,
        ng_sets: &mut [Targets],
        mut share: f64,
        (first, until, budget): (u64, u64, &mut dyn Budget),
        hear: &mut dyn FnMut(&[u32]),
    ) -> bool {
        let network = self.network;
        let successors = near(network, self.successors, self.near);
        let visits = network.visits().len().max(1) as f64;
        let slack = SLACK * network.nodes.iter().map(|node| node.value).sum::<f64>() / visits;
        let (mut best, mut kept, mut stale) = (f64::INFINITY, multipliers.clone(), 0);
        let mut counts = vec![0_u32; network.targets];
        for round in 0..ROUNDS_MAX {
            let reduced_profit = reduced_profits(network, multipliers);
            let (completion, steps) = WalkCompletion::new(network, self.layout, self.successors, multipliers);
            budget.charge(1 + steps / STEPS_PER_UNIT);
            let search = Labelling {
                network,
                latest_departures: self.latest_departures,
                reduced_profit: &reduced_profit,
                ng_sets,
                successors: &successors,
                completion_bound: CompletionBound::Walks(&completion),
                refund: MultiplierRefund::All(multipliers.iter().sum()),
                cutoff: self.cutoff,
                slack: slack * share.max(SLACK_SHARE_MIN),
            };
            let Some(found) = search.run(if round == 0 { first } else { until }, budget) else {
                if round == 0 {
                    return false;
                }
                break;
            };
            if found.is_nothing() {
                kept.clone_from(multipliers);
                break;
            }
            hear(&found.walk);
            stale = if found.value < best * (1.0 - BETTER) { 0 } else { stale + 1 };
            if found.value < best {
                best = found.value;
                kept.clone_from(multipliers);
            }
            if stale >= self.patience {
                (share, stale) = (0.5 * share, 0);
                multipliers.clone_from(&kept);
                if share >= SLACK_SHARE_MIN {
                    // The slack is smaller from now on: bounds before and after cannot be compared.
                    best = f64::INFINITY;
                }
                ng_sets::grow(ng_sets, network, &found.walk, REMEMBERED_MAX);
            }
            counts.fill(0);
            for node in &found.walk {
                if let Some(count) = counts.get_mut(network.node(*node).target as usize) {
                    *count += 1;
                }
            }
            if share < self.least || !step(multipliers, &counts, share * (found.value - self.incumbent)) {
                break;
            }
        }
        multipliers.clone_from(&kept);
        true
    }
}

/// Returns for each node about the `targets` nearest of its successors; for the start, all of them.
fn near(network: &Network, successors: &[Vec<u32>], targets: usize) -> Vec<Vec<u32>> {
    let most = targets * network.visits().len().div_ceil(network.targets.max(1));
    let of = |(node, others): (u32, &Vec<u32>)| {
        let mut others = others.clone();
        if node >= FIRST {
            others.sort_by_key(|other| network.leg(node, *other));
            others.truncate(most);
        }
        others
    };
    (0..).zip(successors).map(of).collect()
}

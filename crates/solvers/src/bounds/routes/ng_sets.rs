//! ng-sets: for each target the visited targets that a route remembers there (Baldacci, Mingozzi and Roberti 2011).

use crate::routing::network::Network;

/// A set of targets.
pub(super) type Targets = u128;

/// Maximum number of targets in a set.
pub(crate) const TARGETS_MAX: usize = Targets::BITS as usize;

/// Returns the set that holds one target.
#[inline(always)]
pub(super) fn bit_of(target: u32) -> Targets {
    Targets::from(1_u8).checked_shl(target).unwrap_or(0)
}

/// Returns for each target the set of itself and its nearest targets, `size` in all.
pub(super) fn nearest(network: &Network, size: usize) -> Vec<Targets> {
    let mut away = vec![vec![i32::MAX; network.targets]; network.targets];
    for from in network.visits() {
        for to in network.visits().filter(|to| *to != from) {
            let (a, b) = (network.node(from).target as usize, network.node(to).target as usize);
            if let Some(away) = away.get_mut(a).and_then(|row| row.get_mut(b)) {
                *away = (*away).min(network.leg(from, to)).min(network.leg(to, from));
            }
        }
    }
    let near = |(target, row): (usize, &Vec<i32>)| {
        let mut order: Vec<usize> = (0..network.targets).filter(|other| *other != target).collect();
        order.sort_by_key(|other| (row.get(*other).copied().unwrap_or(i32::MAX), *other));
        order.truncate(size.saturating_sub(1));
        order.iter().fold(bit_of(target as u32), |set, other| set | bit_of(*other as u32))
    };
    away.iter().enumerate().map(near).collect()
}

/// Adds a revisited target to the ng-sets of the targets between its visits, unless these hold `most` targets. Returns false if
/// the walk revisits no target.
pub(super) fn grow(ng_sets: &mut [Targets], network: &Network, walk: &[u32], most: u32) -> bool {
    let targets: Vec<u32> = walk.iter().map(|node| network.node(*node).target).collect();
    let mut comes_back = false;
    for (index, target) in targets.iter().enumerate() {
        let Some(before) = targets.iter().take(index).rposition(|other| other == target) else { continue };
        comes_back = true;
        for between in targets.get(before + 1..index).unwrap_or_default() {
            if let Some(set) = ng_sets.get_mut(*between as usize).filter(|set| set.count_ones() < most) {
                *set |= bit_of(*target);
            }
        }
    }
    comes_back
}

//! Groups of near targets: for each target a chain of growing groups, from hierarchical clustering by mean travel time.
//!
//! The choice of groups affects how tight a bound is, never its validity. Bound: O(targets^3).

/// Returns for each target its groups, from the target alone to the largest group that does not hold all targets. `between` is the travel
/// time between two targets; infinite times count as `far`.
pub(super) fn chains(count: usize, between: impl Fn(usize, usize) -> f64, far: f64) -> Vec<Vec<Vec<usize>>> {
    let mut groups: Vec<Vec<usize>> = (0..count).map(|target| vec![target]).collect();
    let mut chains: Vec<Vec<Vec<usize>>> = groups.iter().map(|alone| vec![alone.clone()]).collect();
    let way = |from: usize, to: usize| 0.5 * (between(from, to).min(far) + between(to, from).min(far));
    let mean = |one: &[usize], other: &[usize]| {
        let total: f64 = one.iter().flat_map(|from| other.iter().map(|to| way(*from, *to))).sum();
        total / (one.len() * other.len()).max(1) as f64
    };
    while groups.len() > 2 {
        let mut nearest: Option<(f64, usize, usize)> = None;
        for (second, other) in groups.iter().enumerate() {
            for (first, one) in groups.iter().enumerate().take(second) {
                let apart = mean(one, other);
                if nearest.is_none_or(|(least, ..)| apart < least) {
                    nearest = Some((apart, first, second));
                }
            }
        }
        let Some((_, first, second)) = nearest else { break };
        // The group with the later index is removed first, so that the earlier index stays valid.
        let joined = groups.swap_remove(second);
        let Some(group) = groups.get_mut(first) else { break };
        group.extend(joined);
        group.sort_unstable();
        for target in group.iter() {
            if let Some(chain) = chains.get_mut(*target) {
                chain.push(group.clone());
            }
        }
    }
    chains
}

/// Returns at most `groups_max` groups of a chain, at equal intervals from the first to the last; if `groups_max` is one, the smallest.
pub(super) fn thinned(chain: &[Vec<usize>], groups_max: usize) -> Vec<Vec<usize>> {
    let last = chain.len().saturating_sub(1);
    let kept = groups_max.min(chain.len());
    let strides = kept.saturating_sub(1).max(1);
    (0..kept).filter_map(|number| chain.get(number * last / strides).cloned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_chain_keeps_its_ends_and_its_order() {
        let chain: Vec<Vec<usize>> = (1..8).map(|size| (0..size).collect()).collect();
        let sizes = |most: usize| thinned(&chain, most).iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!(sizes(usize::MAX), [1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(sizes(5), [1, 2, 4, 5, 7], "strides need not be whole");
        assert_eq!((sizes(3), sizes(2), sizes(1), sizes(0)), (vec![1, 4, 7], vec![1, 7], vec![1], vec![]));
    }

    #[test]
    fn near_targets_merge_first_and_chains_end_before_all_are_one() {
        let places: [f64; 4] = [0.0, 1.0, 10.0, 12.0];
        let chains = chains(4, |from, to| (places[from] - places[to]).abs(), 1e9);
        assert_eq!(chains[0], vec![vec![0], vec![0, 1]]);
        assert_eq!(chains[3], vec![vec![3], vec![2, 3]]);
    }

    #[test]
    fn one_target_is_its_own_group() {
        assert_eq!(chains(1, |_, _| 0.0, 1e9), vec![vec![vec![0]]]);
    }
}

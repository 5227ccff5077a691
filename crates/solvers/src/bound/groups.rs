//! Groups of near targets: each target's chain of ever larger ones, as they merge by the mean of the ways between them.
//!
//! Which groups are looked at decides how strong a bound is, never whether it holds. Bound: O(targets^3).

/// For each target its groups, from itself alone to the greatest that leaves somebody out. `between` is the time from one
/// target to another one; times beyond all bounds count as `far`.
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
        // The later one goes first, so that the earlier one stays where it is.
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

#[cfg(test)]
mod tests {
    use super::*;

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

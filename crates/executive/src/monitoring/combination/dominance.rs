//! Dominance pruning of results (M&I)
//! What: keeps, for each partner and set of bindings, the result that ends first and the one that starts first.
//! Runs: when a relation prunes the results that it keeps.
//! Reads: nothing.
//! Writes: nothing.
//! Bound: O(results x results kept).
//! PDL: Allen relations.
//! Paper: Table 1 row 11, the full set of Allen predicates.

use crate::monitoring::combination::relation::{Edge, KnownInterval, PointComparison, links};
use crate::state::monitors::monitor::Satisfaction;
use apex_model::condition::AllenRelation;
use apex_model::time::Time;
use std::collections::BTreeSet;

/// Returns true if the relation only orders end points; then one result can represent others. If end points must be equal, few results
/// can still be related, and none is pruned.
pub(crate) fn bounds_only(relation: AllenRelation) -> bool {
    links(relation).iter().all(|(_, link, _)| *link == PointComparison::Earlier)
}

/// Marks, among results with equal bindings to which one partner could be related, the one that ends first and the one that begins first;
/// no other can be the first result.
pub(crate) fn keep_best(
    settled: &[Satisfaction],
    useful: &[bool],
    partners: &[KnownInterval],
    possible: impl Fn(&Satisfaction, KnownInterval) -> bool,
) -> Vec<bool> {
    let mut best = vec![false; settled.len()];
    for partner in partners {
        // Indices of the result that ends first and of the one that begins first, for each set of bindings.
        let mut leaders: Vec<(usize, usize)> = Vec::new();
        for (index, result) in settled.iter().enumerate() {
            if !useful.get(index).copied().unwrap_or(false) || !possible(result, *partner) {
                continue;
            }
            let same = |leader: usize| settled.get(leader).is_some_and(|each| binds_alike(each, result));
            let ahead = |leader: usize, key: fn(&Satisfaction) -> (Time, Time)| {
                settled.get(leader).is_some_and(|each| key(each) <= key(result))
            };
            match leaders.iter_mut().find(|(ends_first, _)| same(*ends_first)) {
                Some((ends_first, begins_first)) => {
                    if !ahead(*ends_first, |each| (each.interval.1, each.interval.0)) {
                        *ends_first = index;
                    }
                    if !ahead(*begins_first, |each| each.interval) {
                        *begins_first = index;
                    }
                }
                None => leaders.push((index, index)),
            }
        }
        for place in leaders.into_iter().flat_map(|(a, b)| [a, b]) {
            if let Some(best) = best.get_mut(place) {
                *best = true;
            }
        }
    }
    best
}

/// Marks the results that may be related to a future one and that no other result represents. A result represents another if every such
/// future result would be related to it too, it has the same bindings, and it would be reported earlier. The start of the future result
/// is not known yet, so a result that ends first may fail where a later one holds.
pub(crate) fn keep_first_choices(
    settled: &[Satisfaction],
    best: &mut [bool],
    possible: impl Fn(&Satisfaction) -> bool,
    easier: impl Fn(&Satisfaction, &Satisfaction) -> bool,
) {
    let mut kept: Vec<&Satisfaction> = Vec::new();
    let mut order: Vec<usize> = (0..settled.len()).collect();
    order.sort_by_key(|index| settled.get(*index).map(|result| result.interval));
    for index in order {
        let (Some(result), Some(best)) = (settled.get(index), best.get_mut(index)) else { continue };
        if possible(result) && !kept.iter().any(|other| easier(other, result) && binds_alike(other, result)) {
            kept.push(result);
            *best = true;
        }
    }
}

/// Returns true if every result that can be related to `other` can also be related to `one`.
pub(crate) fn easier(relation: AllenRelation, is_left: bool, one: &Satisfaction, other: &Satisfaction) -> bool {
    // The partner is on the left of these results, or on their right.
    let own = |edge: Edge, result: &Satisfaction| match (edge, is_left) {
        (Edge::FirstStart, false) | (Edge::SecondStart, true) => Some(result.interval.0),
        (Edge::FirstEnd, false) | (Edge::SecondEnd, true) => Some(result.interval.1),
        _ => None,
    };
    links(relation).iter().all(|(earlier, _, later)| {
        let no_later = own(*earlier, one) <= own(*earlier, other);
        let no_earlier = own(*later, one) >= own(*later, other);
        no_later && no_earlier
    })
}

/// Returns true if both have equal bindings, except for tags, which are intervals.
fn binds_alike(left: &Satisfaction, right: &Satisfaction) -> bool {
    left.bindings.plain() == right.bindings.plain()
}

/// Keeps, of results with equal bindings (except for tags), the first.
pub(crate) fn one_for_each_binding(results: &mut Vec<Satisfaction>) {
    let mut seen = BTreeSet::new();
    results.retain(|result| seen.insert(result.bindings.plain()));
}

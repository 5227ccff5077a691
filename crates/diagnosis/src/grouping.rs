//! Conflicts that share failure modes, as groups that can be diagnosed separately: every candidate is the union of one set from each
//! group.
//!
//! Bound: O(conflicts x groups x words).

use crate::bits::Bits;

/// Failure modes of which at least one is present, because a test failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Conflict {
    pub(crate) test: usize,
    pub(crate) modes: Bits,
}

/// Conflicts that have no failure mode in common with others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ConflictGroup {
    /// All failure modes of the conflicts.
    pub(crate) modes: Bits,
    pub(crate) conflicts: Vec<Conflict>,
    /// Sets that are not present as a whole, since a test passed.
    pub(crate) nogoods: Vec<Bits>,
}

/// Returns the groups of these conflicts, ordered by their least failure mode. Sets of `nogoods` that no candidate can contain are left
/// out.
pub(crate) fn groups(conflicts: Vec<Conflict>, nogoods: Vec<Bits>, modes: usize) -> Vec<ConflictGroup> {
    let mut groups: Vec<ConflictGroup> = Vec::new();
    for conflict in conflicts {
        let set = conflict.modes.clone();
        join(&mut groups, set, |group| group.conflicts.push(conflict));
    }
    let mut all = Bits::new(modes);
    groups.iter().for_each(|group| all.extend(&group.modes));
    for nogood in nogoods.into_iter().filter(|nogood| nogood.is_subset(&all)) {
        join(&mut groups, nogood.clone(), |group| group.nogoods.push(nogood));
    }
    for group in &mut groups {
        group.conflicts.sort_by(|a, b| (a.test, &a.modes).cmp(&(b.test, &b.modes)));
        group.nogoods.sort();
        group.nogoods.dedup();
    }
    groups.sort_by_key(|group| group.modes.first());
    groups
}

/// Merges the groups that share modes with `set`, and passes the merged group to `add`.
fn join(groups: &mut Vec<ConflictGroup>, set: Bits, add: impl FnOnce(&mut ConflictGroup)) {
    let (mut touched, mut others): (Vec<ConflictGroup>, Vec<ConflictGroup>) =
        groups.drain(..).partition(|group| group.modes.intersects(&set));
    // The others are merged into the largest group, so that few conflicts are moved.
    touched.sort_by_key(|group| group.conflicts.len());
    let mut whole =
        touched.pop().unwrap_or(ConflictGroup { modes: set.clone(), conflicts: Vec::new(), nogoods: Vec::new() });
    whole.modes.extend(&set);
    for group in touched {
        whole.modes.extend(&group.modes);
        whole.conflicts.extend(group.conflicts);
        whole.nogoods.extend(group.nogoods);
    }
    add(&mut whole);
    others.push(whole);
    *groups = others;
}

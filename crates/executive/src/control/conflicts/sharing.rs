//! Sharing (TC)
//! What: computes the used amount of a resource and whether another use fits; a task and its ancestors share one amount.
//! Runs: contend phase.  Reads: uses, ancestors.  Writes: nothing.
//! Bound: O(u log u + u * depth) for u uses of a resource.
//! PDL: `profile`, `resource`, section 9.  Paper: section III, detecting and resolving conflicts.

use crate::state::agent::Agent;
use apex_model::task::TaskId;
use apex_model::time::Time;
use std::collections::{BTreeMap, BTreeSet};

/// Amounts are equal when they differ by less than this: sums of fractions are not exact.
pub(crate) const TOLERANCE: f64 = 1e-9;

/// A share of a resource that counts against later claimants.
#[derive(Clone)]
pub(crate) struct Use {
    /// The task.
    pub(crate) task: TaskId,
    /// Amount.
    pub(crate) amount: f64,
    /// Kind of the use.
    pub(crate) kind: UseKind,
}

/// Right by which a task uses a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UseKind {
    /// Held by an ongoing task, which can lose it.
    Held,
    /// Granted in this arbitration.
    Granted,
    /// Claimed by an earlier claimant that is itself refused, and cannot begin before this instant (`None`: unknown).
    Awaited(Option<Time>),
}

/// Kinds of notes about refused claims.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Notes {
    /// Each refused claim is noted.
    Each,
    /// Refused claims that cannot begin before one instant are noted as one; only for claimants that are not related to each other.
    ByInstant,
    /// Claims are noted only until they suffice to refuse all further claimants.
    Enough,
}

/// Returns true if `task` can use `amount` of a resource with capacity `total`. Within the amount that its ancestors hold it always can,
/// even if claims exceed the capacity.
pub(crate) fn has_room(agent: &Agent, total: f64, present: &[&Use], task: TaskId, amount: f64) -> bool {
    if present.is_empty() {
        return amount <= total + TOLERANCE;
    }
    let mut uses: Vec<(TaskId, f64)> = present.iter().map(|each| (each.task, each.amount)).collect();
    let before = used(agent, &uses);
    uses.push((task, amount));
    let after = used(agent, &uses);
    after <= total + TOLERANCE || after <= before + TOLERANCE
}

/// Returns true if one of the users is an ancestor of another. If none is, each use counts separately.
pub(crate) fn any_related(agent: &Agent, present: &[&Use]) -> bool {
    let users: BTreeSet<TaskId> = present.iter().map(|each| each.task).collect();
    let parent = |id: TaskId| agent.task(id).and_then(|task| task.parent);
    users.iter().any(|user| std::iter::successors(parent(*user), |id| parent(*id)).any(|above| users.contains(&above)))
}

/// Returns true if the used amount would be smaller without `each`.
pub(crate) fn matters(agent: &Agent, present: &[&Use], each: &Use) -> bool {
    let amounts = |uses: &mut dyn Iterator<Item = &&Use>| uses.map(|it| (it.task, it.amount)).collect::<Vec<_>>();
    let all = amounts(&mut present.iter());
    let others = amounts(&mut present.iter().filter(|other| other.task != each.task));
    used(agent, &others) + TOLERANCE < used(agent, &all)
}

/// Returns the used amount: for related tasks the greater of a task's own use and the sum of its descendants' uses, because a family does
/// not compete; unrelated uses add up.
fn used(agent: &Agent, uses: &[(TaskId, f64)]) -> f64 {
    if let [] | [_] = uses {
        return uses.iter().map(|(_, amount)| amount).sum();
    }
    let depth = |id: TaskId| agent.task(id).map_or(0, |task| task.depth);
    let mut deepest_first: Vec<(TaskId, f64)> = uses.to_vec();
    deepest_first.sort_by_key(|(task, _)| (std::cmp::Reverse(depth(*task)), *task));
    let users: BTreeMap<TaskId, usize> =
        deepest_first.iter().enumerate().map(|(index, (task, _))| (*task, index)).collect();
    let mut inside = vec![0.0_f64; deepest_first.len()];
    let mut strangers = 0.0;
    for (index, (task, amount)) in deepest_first.iter().enumerate() {
        let family = inside.get(index).copied().unwrap_or(0.0).max(*amount);
        let mut above = agent.task(*task).and_then(|task| task.parent);
        let user = loop {
            match above {
                None => break None,
                Some(id) if users.contains_key(&id) => break users.get(&id),
                Some(id) => above = agent.task(id).and_then(|task| task.parent),
            }
        };
        match user.and_then(|index| inside.get_mut(*index)) {
            Some(share) => *share += family,
            None => strangers += family,
        }
    }
    strangers
}

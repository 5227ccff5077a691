//! Threshold formulas (M&I)
//! What: decides which Boolean formulas of threshold episodes episode indexes can watch leaf by leaf, and when to report results.
//! Runs: when results of a formula were reported; when an index reports an update of one of its leaves.
//! Reads: the monitor's tree, the runs of the index.
//! Writes: the runs and settled results of its leaves.
//! Bound: O(leaves).
//! PDL: `:and`, `:or`, `:in-order`, `:not` over `:episode`s with fixed bounds.
//! Paper: section IV, creating monitors from PDL specifications.
//!
//! A formula has a new result only at an instant at which one of its leaves has a new result, or at which a sample contradicts a leaf
//! under `:not`; a run that grows or ends does not make it true. Conditions that read growing intervals (constraints, delays, relations)
//! are therefore not threshold formulas. Nor is an order, or a conjunction of alternatives with a `:not` among them: while another
//! alternative makes it true, the `:not` remains open for the next sample. A superfluous report is harmless; no instant of a report is
//! missed.

use crate::expression::EvalContext;
use crate::monitoring::episodes::threshold_episode::{self, Bankable};
use crate::monitoring::part::{ConditionFaults, remember, site};
use crate::state::episode_index::{EpisodeUpdate, IndexedRun, What};
use crate::state::monitors::monitor::{Keep, Monitor, Part, PartKind, Satisfaction};
use apex_model::event::StateVariable;
use apex_model::symbol::Symbol;

/// The leaves of a combination that episode indexes watch, in written order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Leaves(Vec<Leaf>);

#[derive(Clone, Debug)]
struct Leaf {
    variable: StateVariable,
    /// True if the leaf has an unused result; under `:not`, any result.
    counts: bool,
    /// True if the leaf is a separate alternative: the end of its runs is reported.
    alternative: bool,
    /// The result of the run that ended last, while the sample that ended it may be the newest.
    over: Option<Satisfaction>,
}

impl Leaves {
    /// Returns the variables whose samples decide the leaves.
    pub(crate) fn variables(&self) -> impl ExactSizeIterator<Item = &StateVariable> {
        self.0.iter().map(|leaf| &leaf.variable)
    }
}

/// The leaf with its part in the tree and its position.
#[derive(Clone, Copy, PartialEq)]
enum LeafRole {
    /// Only `:or`s are above it.
    Alternative,
    /// Inside `:and` or `:in-order`.
    Inside,
    /// Directly under a `:not`.
    Negated,
}

/// Calls `act` with each leaf in written order. Returns false if the tree contains another kind of part.
fn for_each_leaf<'a>(part: &'a Part, place: LeafRole, act: &mut dyn FnMut(&'a Part, LeafRole)) -> bool {
    match &part.kind {
        PartKind::Episode(_) => {
            act(part, place);
            true
        }
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            let alternatives = matches!(part.kind, PartKind::Or(_)) && place == LeafRole::Alternative;
            let inner = if alternatives { place } else { LeafRole::Inside };
            // In an order, the result of a `:not` moves with time; so does one that may be used later. Neither is a threshold formula.
            let one_of_many = matches!(part.kind, PartKind::Or(_)) && place == LeafRole::Inside;
            let ordered = matches!(part.kind, PartKind::InOrder(_));
            let moving = |part: &Part| ordered && matches!(part.kind, PartKind::Not(_)) || one_of_many && denies(part);
            composite.constraints.is_empty()
                && composite.shared.is_empty()
                && composite.parts.iter().all(|part| !moving(part) && for_each_leaf(part, inner, act))
        }
        PartKind::Not(inner) if matches!(inner.kind, PartKind::Episode(_)) => {
            act(inner, LeafRole::Negated);
            true
        }
        _ => false,
    }
}

/// Returns true if the part contains a `:not`.
fn denies(part: &Part) -> bool {
    match &part.kind {
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter().any(denies)
        }
        PartKind::Not(_) => true,
        _ => false,
    }
}

fn for_each_leaf_mut(part: &mut Part, act: &mut dyn FnMut(&mut Part)) {
    match &mut part.kind {
        PartKind::Episode(_) => act(part),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| for_each_leaf_mut(part, act));
        }
        PartKind::Not(inner) => for_each_leaf_mut(inner, act),
        _ => {}
    }
}

/// Returns true if the tags of `part` and of its parts are all different. Equal tags would require equal intervals.
fn tags_differ<'a>(part: &'a Part, seen: &mut Vec<&'a Symbol>) -> bool {
    if let Some(tag) = &part.tag {
        if seen.contains(&tag) {
            return false;
        }
        seen.push(tag);
    }
    match &part.kind {
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter().all(|part| tags_differ(part, seen))
        }
        PartKind::Not(inner) => tags_differ(inner, seen),
        _ => true,
    }
}

/// Returns the state of the leaves for episode indexes, in written order, if the monitor is a threshold formula whose results were just
/// collected.
pub(crate) fn bankable<'a>(monitor: &'a Monitor, context: &dyn EvalContext) -> Option<(Leaves, Vec<Bankable<'a>>)> {
    if matches!(monitor.root.kind, PartKind::Episode(_)) || !tags_differ(&monitor.root, &mut Vec::new()) {
        return None;
    }
    let mut parts = Vec::new();
    if !for_each_leaf(&monitor.root, LeafRole::Alternative, &mut |part, place| parts.push((part, place))) {
        return None;
    }
    let (mut leaves, mut bankables) = (Vec::new(), Vec::new());
    for (part, place) in parts {
        let PartKind::Episode(leaf) = &part.kind else { return None };
        let mut bankable = threshold_episode::of_part(part, context).filter(|_| part.keep == Keep::Every)?;
        bankable.wanted.negated = place == LeafRole::Negated;
        // An episode index would not report the first sample that contradicts it.
        if bankable.wanted.negated && bankable.run.is_none() {
            return None;
        }
        let counts = !leaf.settled.is_empty() || bankable.over.is_some() || bankable.wanted.open.is_some();
        let (variable, over) = (leaf.variable.clone()?, bankable.over.take());
        leaves.push(Leaf { variable, counts, alternative: place == LeafRole::Alternative, over });
        bankables.push(bankable);
    }
    Some((Leaves(leaves), bankables))
}

/// Moves the state of the leaves into the episode indexes that watch them.
pub(crate) fn lie_down(monitor: &mut Monitor) {
    for_each_leaf_mut(&mut monitor.root, &mut |part| {
        if let PartKind::Episode(leaf) = &mut part.kind {
            leaf.runs.clear();
        }
    });
}

/// Moves the state that episode indexes have kept back into the leaves, in written order.
pub(crate) fn stand_up(
    monitor: &mut Monitor,
    leaves: &mut Leaves,
    seen: Vec<Option<IndexedRun>>,
    context: &dyn EvalContext,
) {
    let mut each = leaves.0.iter_mut().zip(seen);
    let mut troubles = ConditionFaults::none(context);
    for_each_leaf_mut(&mut monitor.root, &mut |part| {
        let site = site(part);
        let (PartKind::Episode(leaf), Some((state, seen))) = (&mut part.kind, each.next()) else { return };
        threshold_episode::give_back(leaf, seen);
        // The run that the newest sample ended is still stored, with its result.
        let before = leaf.runs.values().next().and_then(|run| run.found.as_ref()).map(|found| found.interval.0);
        let still_there = |result: &mut Satisfaction| before != Some(result.interval.0);
        if let Some(result) = state.over.take_if(still_there) {
            remember(&mut leaf.settled, result, site, &mut troubles);
        }
    });
    troubles.tell(monitor);
}

/// Updates the leaves after the results of the formula were collected. If any was reported, the results of its leaves are used up.
pub(crate) fn harvested(monitor: &Monitor, leaves: &mut Leaves, told: bool) {
    let alternatives = matches!(monitor.root.kind, PartKind::Or(_));
    let mut each = leaves.0.iter_mut();
    for_each_leaf(&monitor.root, LeafRole::Alternative, &mut |part, place| {
        let (PartKind::Episode(_), Some(state)) = (&part.kind, each.next()) else { return };
        // Each alternative uses its results separately: those of the others still count.
        if told && !alternatives && place != LeafRole::Negated {
            state.counts = false;
        }
    });
}

/// Takes the report of an episode index about leaf number `leaf`. Returns true if the formula must be evaluated at this instant.
pub(crate) fn told(
    monitor: &mut Monitor,
    leaves: &mut Leaves,
    leaf: u32,
    told: &EpisodeUpdate,
    context: &dyn EvalContext,
) -> bool {
    let Some(state) = leaves.0.get_mut(leaf as usize) else { return true };
    match told.what {
        What::Found => state.counts = true,
        What::Contradicted => {}
        What::Over => {
            let alternative = state.alternative;
            let (mut number, mut troubles) = (0, ConditionFaults::none(context));
            for_each_leaf_mut(&mut monitor.root, &mut |part| {
                let site = site(part);
                if let PartKind::Episode(episode) = &mut part.kind
                    && number == leaf
                {
                    if let Some(before) = state.over.take() {
                        remember(&mut episode.settled, before, site, &mut troubles);
                    }
                    state.over = threshold_episode::told_of(episode, told);
                }
                number += 1;
            });
            troubles.tell(monitor);
            return alternative;
        }
    }
    let mut each = leaves.0.iter();
    may_be_true(&monitor.root, &mut each)
}

/// Returns true if the results of the leaves permit a new result.
fn may_be_true<'a>(part: &Part, leaves: &mut impl Iterator<Item = &'a Leaf>) -> bool {
    match &part.kind {
        // Every part takes its own leaves, even if the answer is known before.
        PartKind::And(composite) | PartKind::InOrder(composite) => {
            let untrue = composite.parts.iter().filter(|part| !may_be_true(part, leaves)).count();
            untrue == 0
        }
        PartKind::Or(composite) => composite.parts.iter().filter(|part| may_be_true(part, leaves)).count() > 0,
        PartKind::Not(inner) => !may_be_true(inner, leaves),
        _ => leaves.next().is_none_or(|leaf| leaf.counts),
    }
}

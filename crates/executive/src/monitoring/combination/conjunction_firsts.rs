//! First results of conjunctions (M&I)
//! What: keeps, of the results of each part of an `:and`, the first for each set of bindings, where no other can be reported.
//! Runs: whenever the verdict of a monitor is requested whose whole condition is such an `:and`, or alternatives of which one is.
//! Reads: the parts' results.
//! Writes: removes results from the parts.
//! Bound: O(1) per result, amortised: a sweep over all n kept results, O(n log n), each time they have doubled.
//! PDL: `:and`.
//! Paper: Table 1, row 11.
//!
//! Of the combinations with equal bindings, only the first is required. Without constraints, its parts are the first results of the parts:
//! any other result could be exchanged for the first one with equal bindings, and the combination would be recognised no later.

use crate::expression::EvalContext;
use crate::monitoring::basic::measurement::variable_of;
use crate::monitoring::combination::{conjunction_pairs, point_sweep};
use crate::monitoring::memory::retention;
use crate::monitoring::reported_results::Used;
use crate::state::monitors::monitor::{Composite, Part, PartKind, Satisfaction};
use apex_model::condition::{Condition, ConditionKind};
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use std::collections::BTreeSet;

/// Number of kept results from which on a sweep is worthwhile. It is small, so that short tests also sweep.
pub(crate) const SWEEP_AT_LEAST: usize = 8;

/// Returns true if no two tags have one name, and none that of a variable in `names`, so that intervals of tags never decide whether two
/// results agree.
pub(crate) fn tags_are_distinct(parts: &[Condition], names: &BTreeSet<&Symbol>) -> bool {
    let mut tags = Vec::new();
    parts.iter().for_each(|part| collect_tags(part, &mut tags));
    let mut seen = BTreeSet::new();
    tags.into_iter().all(|tag| seen.insert(tag) && !names.contains(tag))
}

fn collect_tags<'a>(condition: &'a Condition, tags: &mut Vec<&'a Symbol>) {
    tags.extend(&condition.tag);
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| collect_tags(part, tags));
        }
        ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| collect_tags(part, tags)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => collect_tags(part, tags),
        ConditionKind::Probing { condition, .. } => collect_tags(condition, tags),
        ConditionKind::Measurement(_)
        | ConditionKind::Episode(_)
        | ConditionKind::Event { .. }
        | ConditionKind::TaskEnded(_)
        | ConditionKind::TaskState { .. }
        | ConditionKind::Timestamp(..)
        | ConditionKind::Delay(..)
        | ConditionKind::Cyclic(_)
        | ConditionKind::Function(_) => {}
    }
}

/// Drops results that no reported result needs any longer. `used` are results of combinations that were reported already.
pub(crate) fn sweep(part: &mut Part, used: Option<&Used>, context: &dyn EvalContext) {
    match &mut part.kind {
        PartKind::Or(composite) => composite.parts.iter_mut().for_each(|part| sweep(part, used, context)),
        PartKind::And(composite) if composite.sweep_at.is_some() => {
            sweep_conjunction(composite, used, context);
            composite.parts.iter_mut().for_each(|part| sweep(part, used, context));
        }
        PartKind::InOrder(_) => point_sweep::sweep(part, used, context),
        _ => {}
    }
}

fn sweep_conjunction(composite: &mut Composite, used: Option<&Used>, context: &dyn EvalContext) {
    let mut kept = 0;
    composite.parts.iter_mut().for_each(|part| each_list(part, used, context, &mut |_, list, _, _| kept += list.len()));
    if composite.sweep_at.is_none_or(|sweep_at| kept < sweep_at) {
        return;
    }
    kept = conjunction_pairs::sweep(composite, used, context.now());
    let paired: Vec<bool> = (0..composite.parts.len()).map(|number| composite.is_paired(number)).collect();
    for (part, _) in composite.parts.iter_mut().zip(paired).filter(|(_, paired)| !paired) {
        each_list(part, used, context, &mut |place, list, used, is_final| {
            if list.is_sorted_by_key(|result| result.recognised_at) {
                let newest = list.len().saturating_sub(1);
                let (mut index, mut seen) = (0, BTreeSet::new());
                list.retain(|result| {
                    index += 1;
                    let counts = used.is_none_or(|used| !used.contains(place, result));
                    // The newest settled result is kept: it shows that the part has held. A result that a late sample may withdraw is kept,
                    // as is the first one behind it.
                    (counts && seen.insert(result.bindings.plain())) || index > newest || !is_final(result)
                });
            }
            kept += list.len();
        });
    }
    composite.sweep_at = Some(kept.saturating_mul(2).max(SWEEP_AT_LEAST));
}

/// Returns true if no late sample can withdraw a result any longer, or come before it.
type IsFinal<'f> = dyn Fn(&Satisfaction) -> bool + 'f;

/// An action on the settled results of the part at a place, with the results that were used.
type ActOnResults<'a, 'f> = dyn FnMut(Place, &mut Vec<Satisfaction>, Option<&'a Used>, &IsFinal<'_>) + 'f;

/// Calls `act` with the settled results of samples and messages of the part, of its alternatives, and of the part that it negates, which
/// counts all results, reported or not.
fn each_list<'a>(part: &mut Part, used: Option<&'a Used>, context: &dyn EvalContext, act: &mut ActOnResults<'a, '_>) {
    let place = part.place;
    match &mut part.kind {
        PartKind::Or(composite) if composite.constraints.is_empty() => {
            composite.parts.iter_mut().for_each(|part| each_list(part, used, context, act));
        }
        PartKind::Not(inner) => each_list(inner, None, context, act),
        PartKind::Measurement(leaf) => {
            let pattern = &leaf.condition.variable;
            let declared = context.library().state_variables.get(&pattern.attribute);
            let named = leaf.variable.is_some() || matches!(pattern.object, Pattern::Variable(_));
            let late = declared.and_then(retention::lateness).unwrap_or_default();
            if let Some(seen) = leaf.seen.as_mut().filter(|_| named) {
                // Late samples were added behind newer ones.
                if late > Duration::ZERO {
                    seen.settled.sort_by_key(|result| result.recognised_at);
                }
                let newest = &seen.newest;
                let known =
                    |result: &Satisfaction| variable_of(result).and_then(|variable| newest.get(&variable.object));
                let is_final =
                    |result: &Satisfaction| known(result).is_some_and(|known| known.at - result.interval.0 > late);
                act(place, &mut seen.settled, used, &is_final);
            }
        }
        PartKind::Event(leaf) => act(place, &mut leaf.settled, used, &|_| true),
        _ => {}
    }
}

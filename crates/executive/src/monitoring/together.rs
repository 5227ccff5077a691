//! Parts together (M&I)
//! What: from when to when all parts of an `:and` have been there, without making the combinations of their results.
//! Runs: whenever an absence looks at an `:and` whose parts need not agree about anything.
//! Reads: what the parts have found, histories, surroundings.
//! Writes: takes final results out of the parts, but for messages; of them, only how far they reach is kept.
//! Bound: O(new results + objects + messages) per look.
//! PDL: `(:absent (:and ..) :for D)`.
//! Paper: Table 1 row 10 (not); `monitoring.md` rule 14.
//!
//! Results that go together in any way overlap or touch: each combination shares a part with one that shares its other parts
//! with the next. So where all parts have been there, the combinations cover all of the time from the first start to the last
//! end, and absence, which asks only what is covered, needs no more than these two.

use super::extents::{self, Extent, Extents};
use super::{Asking, Truth, logic, replay};
use apex_model::bindings::Bindings;
use apex_model::evidence_list::EvidenceList;
use apex_model::limits::MONITOR_RESULTS_MAX;
use apex_model::monitor::{AbsentPart, Part, PartKind, Reached, Satisfaction};
use apex_model::time::Time;

/// Are these parts whose results all go together, each an interval that stays?
pub(super) fn is_together(part: &Part) -> bool {
    let stays = |part: &Part| matches!(part.kind, PartKind::Measurement(_) | PartKind::Episode(_) | PartKind::Event(_));
    matches!(&part.kind, PartKind::And(composite) if !composite.combines && composite.parts.iter().all(stays))
}

/// What the parts have found together: one result, as far as it reaches.
pub(super) fn take(absent: &mut AbsentPart, asking: &mut Asking<'_>) -> Extents {
    let mut together = Extents::default();
    // What came later than the newest sample may be looked at again without it: a sample may still come late.
    let newest = replay::newest_known(&absent.part, u64::MAX, asking.surroundings).unwrap_or(Time::BEGINNING);
    let PartKind::And(composite) = &mut absent.part.kind else { return together };
    absent.reached.resize_with(composite.parts.len(), Reached::default);
    let (mut hull, mut recognised_at) = (None, Time::BEGINNING);
    let (mut all, mut open, mut doubt) = (Truth::True, false, false);
    for (each, reached) in composite.parts.iter_mut().zip(&mut absent.reached) {
        let found = found(each, asking);
        reached.coming.extend(found.settled.iter().map(|result| (result.recognised_at, result.interval)));
        let full = reached.coming.len() > MONITOR_RESULTS_MAX;
        let is_known = |at: Time, until: Time| at <= until || full;
        let certain = reached.coming.iter().filter(|(at, _)| is_known(*at, newest.min(asking.now)));
        reached.hull = certain.fold(reached.hull, |hull, (_, interval)| joined(hull, *interval));
        reached.coming.retain(|(at, _)| !is_known(*at, newest.min(asking.now)));
        let passing = found.passing.iter().map(|extent| (extent.result.recognised_at, extent.result.interval));
        let now = reached.coming.iter().copied().chain(passing).filter(|(at, _)| *at <= asking.now);
        let own = now.fold(reached.hull, |hull, (at, interval)| {
            recognised_at = recognised_at.max(at);
            joined(hull, interval)
        });
        let truth = if own.is_some() { Truth::True } else { logic::truth(each, asking) };
        all = all.min(truth);
        hull = own.map_or(hull, |own| joined(hull, own));
        open |= found.passing.iter().any(|extent| extent.open && extent.result.recognised_at <= asking.now);
        doubt |= found.doubt;
        together.changes_at = together.changes_at.into_iter().chain(found.changes_at).min();
    }
    together.doubt = match all {
        Truth::False => false,
        Truth::Unknown => true,
        // What was found stays true; whether it goes on, only its episodes can say.
        Truth::True => doubt,
    };
    if let Some(interval) = hull.filter(|_| all == Truth::True) {
        let evidence = EvidenceList::default();
        let result = Satisfaction { interval, recognised_at, bindings: Bindings::new(), evidence };
        together.passing.push(Extent { result, open });
    }
    together
}

/// What a part has found. Messages stay with it: no history need remember them, so who looks at the past again asks the part.
fn found(part: &mut Part, asking: &mut Asking<'_>) -> Extents {
    let PartKind::Event(leaf) = &part.kind else { return extents::take_final(part, asking) };
    let passing = leaf.settled.iter().map(|result| Extent { result: result.clone(), open: false }).collect();
    Extents { passing, ..Extents::default() }
}

fn joined(hull: Option<(Time, Time)>, (start, end): (Time, Time)) -> Option<(Time, Time)> {
    Some(hull.map_or((start, end), |(first, last)| (first.min(start), last.max(end))))
}

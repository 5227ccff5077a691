//! Parts together (M&I)
//! What: from when to when all parts of an `:and` have been there, without making the combinations of their results.
//! Runs: whenever an absence looks at an `:and` whose parts need not agree about anything.
//! Reads: what the parts have found, histories, surroundings.
//! Writes: takes final results out of the parts, except for messages; of them, only how far they reach is kept.
//! Bound: O(new results + objects + messages) per look.
//! PDL: `(:absent (:and ..) :for D)`.
//! Paper: Table 1 row 10 (not); `monitoring.md` rule 14.
//!
//! Results that go together in any way overlap or touch: each combination shares a part with one that shares its other parts
//! with the next. So where all parts have been there, the combinations cover all of the time from the first start to the last
//! end, and absence, which asks only what is covered, needs no more than these two.

use crate::monitoring::asking::Asking;
use crate::monitoring::combination::extents::{self, Extent, Extents};
use crate::monitoring::combination::logic;
use crate::monitoring::part::Truth;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{AbsentPart, Part, PartKind, Satisfaction};
use apex_model::evidence_list::EvidenceList;
use apex_model::time::Time;

/// Are these parts whose results all go together, each an interval that stays?
pub(crate) fn is_together(part: &Part) -> bool {
    let stays = |part: &Part| matches!(part.kind, PartKind::Measurement(_) | PartKind::Episode(_) | PartKind::Event(_));
    matches!(&part.kind, PartKind::And(composite) if !composite.combines && composite.parts.iter().all(stays))
}

/// What the parts have found together: one result, as far as it reaches.
pub(crate) fn take(absent: &mut AbsentPart, asking: &mut Asking<'_>) -> Extents {
    let mut together = Extents::default();
    let PartKind::And(composite) = &mut absent.part.kind else { return together };
    absent.reached.resize(composite.parts.len(), None);
    let (mut hull, mut all, mut open, mut doubt) = (None, Truth::True, false, false);
    for (each, reached) in composite.parts.iter_mut().zip(&mut absent.reached) {
        let found = found(each, asking);
        // What is final was known by the newest sample, before which no instant is looked at again.
        debug_assert!(found.settled.iter().all(|result| result.recognised_at <= asking.now), "known before it came");
        *reached = found.settled.iter().fold(*reached, |hull, result| joined(hull, result.interval));
        let own = found.passing.iter().fold(*reached, |hull, extent| joined(hull, extent.result.interval));
        let truth = match &each.kind {
            _ if own.is_some() => Truth::True,
            // Messages that came after this instant are there already.
            PartKind::Event(leaf) => Truth::of(false, leaf.blind),
            _ => logic::truth(each, asking),
        };
        all = all.min(truth);
        hull = own.map_or(hull, |own| joined(hull, own));
        open |= found.passing.iter().any(|extent| extent.open);
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
        let (recognised_at, evidence) = (asking.now, EvidenceList::default());
        let result = Satisfaction { interval, recognised_at, bindings: Bindings::new(), evidence };
        together.passing.push(Extent { result, open });
    }
    together
}

/// What a part has found up to this instant. Messages stay with it: no history need remember them, so who looks at the past again
/// asks the part.
fn found(part: &mut Part, asking: &mut Asking<'_>) -> Extents {
    let now = asking.now;
    let mut found = match &part.kind {
        PartKind::Event(leaf) => {
            let all = leaf.settled.iter().map(|result| Extent { result: result.clone(), open: false });
            Extents { passing: all.collect(), ..Extents::default() }
        }
        _ => extents::take_final(part, asking),
    };
    found.passing.retain(|extent| extent.result.recognised_at <= now);
    found
}

fn joined(hull: Option<(Time, Time)>, (start, end): (Time, Time)) -> Option<(Time, Time)> {
    Some(hull.map_or((start, end), |(first, last)| (first.min(start), last.max(end))))
}

//! Span of a conjunction (M&I)
//! What: computes the interval in which all parts of an `:and` have results, without combining those results.
//! Runs: whenever an absence evaluates an `:and` whose parts share no variables.
//! Reads: results of the parts, histories, evaluation context.
//! Writes: removes final results from the parts, except for messages; keeps only their span.
//! Bound: O(new results + objects + messages) per evaluation.
//! PDL: `(:absent (:and ..) :for D)`.
//! Paper: Table 1 row 10 (not); `condition-rules.md`, rule 14.
//!
//! Combinations of results overlap or touch: each combination shares a result with one that shares its other results with the next. Once
//! all parts have a result, the combinations cover all of the time from the first start to the last end. Absence needs only the covered
//! time, so these two instants suffice.

use crate::monitoring::basic::time_conditions::{self, TimeForm};
use crate::monitoring::combination::logic;
use crate::monitoring::combination::part_results::{self, PartResults, TentativeResult};
use crate::monitoring::part::Truth;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{AbsentPart, Part, PartKind, Satisfaction};
use apex_model::evidence_list::EvidenceList;
use apex_model::time::Time;

/// Returns true if every combination of the parts' results is valid, and each result is an interval that remains.
pub(crate) fn is_together(part: &Part) -> bool {
    let stays = |part: &Part| {
        use PartKind::{Delay, Episode, Event, Measurement, Timestamp};
        matches!(part.kind, Measurement(_) | Episode(_) | Event(_) | Delay(_) | Timestamp(_))
    };
    matches!(&part.kind, PartKind::And(composite) if !composite.combines && composite.parts.iter().all(stays))
}

/// Returns the common result of the parts: one interval that grows.
pub(crate) fn take(absent: &mut AbsentPart, query: &mut VerdictQuery<'_>) -> PartResults {
    let mut together = PartResults::default();
    let PartKind::And(composite) = &mut absent.part.kind else { return together };
    absent.reached.resize(composite.parts.len(), None);
    let (mut hull, mut all, mut open, mut doubt) = (None, Truth::True, false, false);
    for (each, reached) in composite.parts.iter_mut().zip(&mut absent.reached) {
        let found = found(each, query);
        // A final result was known by the newest sample, before which no instant is evaluated again.
        debug_assert!(found.settled.iter().all(|result| result.recognised_at <= query.now), "known before it came");
        *reached = found.settled.iter().fold(*reached, |hull, result| joined(hull, result.interval));
        let own = found.passing.iter().fold(*reached, |hull, extent| joined(hull, extent.result.interval));
        let truth = match &each.kind {
            _ if own.is_some() => Truth::True,
            // Messages later than this instant may already be stored, so a stored message does not make this part true now.
            PartKind::Event(leaf) => Truth::of(false, leaf.blind),
            // An instant later than this one may already be reached, because the past is evaluated again.
            PartKind::Delay(leaf) | PartKind::Timestamp(leaf) => Truth::of(false, leaf.span.is_none()),
            _ => logic::truth(each, query),
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
        // The found result remains true; whether it continues depends on its episodes.
        Truth::True => doubt,
    };
    if let Some(interval) = hull.filter(|_| all == Truth::True) {
        let (recognised_at, evidence) = (query.now, EvidenceList::default());
        let result = Satisfaction { interval, recognised_at, bindings: Bindings::new(), evidence };
        together.passing.push(TentativeResult { result, open });
    }
    together
}

/// Returns the results of a part up to this instant. The part keeps its messages: a history need not remember them, so a later evaluation
/// of the past reads the part.
fn found(part: &mut Part, query: &mut VerdictQuery<'_>) -> PartResults {
    let now = query.now;
    let mut found = match &part.kind {
        PartKind::Event(leaf) => {
            let all = leaf.settled.iter().map(|result| TentativeResult { result: result.clone(), open: false });
            PartResults { passing: all.collect(), ..PartResults::default() }
        }
        PartKind::Delay(leaf) => reached(time_conditions::result(leaf, TimeForm::Delay, part.window.start)),
        PartKind::Timestamp(leaf) => reached(time_conditions::result(leaf, TimeForm::Timestamp, part.window.start)),
        _ => part_results::take_final(part, query),
    };
    found.passing.retain(|extent| extent.result.recognised_at <= now);
    found
}

/// Returns the instant of a delay or a timestamp as a result.
fn reached(instant: Option<Satisfaction>) -> PartResults {
    let passing = instant.into_iter().map(|result| TentativeResult { result, open: false }).collect();
    PartResults { passing, ..PartResults::default() }
}

fn joined(hull: Option<(Time, Time)>, (start, end): (Time, Time)) -> Option<(Time, Time)> {
    Some(hull.map_or((start, end), |(first, last)| (first.min(start), last.max(end))))
}

//! Absence (M&I)
//! What: did a whole window of this length pass without the part?
//! Runs: whenever the verdict is asked, and at the instant at which the window is over.
//! Reads: what the part has found, surroundings.
//! Writes: the absent part of a monitor.
//! Bound: O(new results) per look; O(1) memory where the first window is enough.
//! PDL: `(:absent C :for D)`.
//! Paper: Table 1 row 10 (not); `monitoring.md` rule 14.

use super::{Asking, Site, Troubles, Truth, extents, remember, unmet};
use crate::expression::arithmetic::duration;
use crate::expression::{EvaluationError, Surroundings, evaluate};
use apex_model::because::Evidence;
use apex_model::bindings::Bindings;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::monitor::{AbsentPart, Keep, Part, PartKind, Satisfaction};
use apex_model::time::{Duration, Time};

/// The part, not yet looked back. The length is evaluated now.
///
/// # Errors
/// When it cannot be.
pub(super) fn create(
    part: Part,
    length: &Expr,
    start: Time,
    surroundings: &dyn Surroundings,
) -> Result<AbsentPart, EvaluationError> {
    let value = evaluate(length, surroundings)?;
    let length = duration(&value).map_err(|message| EvaluationError { message, place: length.place })?;
    Ok(AbsentPart {
        part,
        length,
        since: start,
        unknown: false,
        told: None,
        found: Vec::new(),
        decides_at: Some(start + length),
    })
}

/// Starts again.
pub(super) fn forget(part: &mut AbsentPart, site: Site) {
    part.found.clear();
    part.since = site.window.start;
    (part.unknown, part.told) = (false, None);
    part.decides_at = Some(part.since + part.length);
}

/// Nothing more is wanted of it.
pub(super) fn is_done(part: &AbsentPart, site: Site) -> bool {
    site.keep == Keep::First && !part.found.is_empty()
}

/// Looks at what the part has found, after it has caught up with the present. The window is open at its start: it
/// begins after the last result; what happens at the very instant at which it would be over prevents it.
pub(super) fn advance(part: &mut AbsentPart, site: Site, surroundings: &dyn Surroundings, troubles: &mut Troubles) {
    if is_done(part, site) {
        return;
    }
    let mut asking = Asking::new(surroundings);
    let extents = extents::take(&mut part.part, &mut asking);
    let passing = extents.passing.iter().map(|extent| extent.result.interval);
    let found: Vec<(Time, Time)> = extents.settled.iter().map(|result| result.interval).chain(passing).collect();
    let goes_on = extents.passing.iter().any(|extent| extent.open);
    part.unknown = goes_on || extents.doubt || is_blind(&part.part);
    let begins = found.iter().map(|(start, _)| *start).filter(|start| *start > part.since).min();
    if !part.unknown && begins.is_some_and(|begins| part.since + part.length < begins) {
        // It is known only now that nothing was there before.
        note(part, asking.now);
    }
    part.since = found.iter().map(|(_, end)| *end).chain([part.since]).max().unwrap_or(part.since);
    let over = part.since + part.length;
    if !part.unknown && over <= asking.now {
        note(part, asking.now);
    }
    let waits = Some(over).filter(|over| *over > asking.now);
    part.decides_at =
        waits.into_iter().chain(extents.changes_at).chain(asking.wake).filter(|at| *at > asking.now).min();
    for trouble in asking.troubles.0 {
        if !troubles.0.contains(&trouble) {
            troubles.0.push(trouble);
        }
    }
}

/// Is there less remembered than the part's window asks for?
fn is_blind(part: &Part) -> bool {
    match &part.kind {
        PartKind::Measurement(leaf) => leaf.blind,
        PartKind::Event(leaf) => leaf.blind,
        _ => false,
    }
}

/// The window that began when the part was last there has passed without it.
fn note(part: &mut AbsentPart, now: Time) {
    if part.told != Some(part.since) {
        part.told = Some(part.since);
        let interval = (part.since, part.since + part.length);
        remember(&mut part.found, result(&part.part, interval, now));
    }
}

fn result(part: &Part, interval: (Time, Time), now: Time) -> Satisfaction {
    let evidence = Evidence::Absence { what: unmet::text(part), at: now };
    Satisfaction { interval, recognised_at: now, bindings: Bindings::new(), evidence: EvidenceList::one(evidence) }
}

/// Satisfied; not known, when the data do not say whether the part holds; else not.
pub(super) fn truth(part: &AbsentPart) -> Truth {
    Truth::of(!part.found.is_empty(), part.unknown)
}

/// How long the part has been absent at `now`, and when that is long enough.
pub(super) fn state(part: &AbsentPart, now: Time) -> (Duration, Time) {
    (now - part.since, part.since + part.length)
}

//! Absence (M&I)
//! What: did a whole window of this length pass without the part?
//! Runs: whenever the verdict is asked, and at the instant at which the window is over.
//! Reads: what the part has found, surroundings.
//! Writes: the absent part of a monitor.
//! Bound: O(new results) per look; O(1) memory where the first window is enough.
//! PDL: `(:absent C :for D)`.
//! Paper: Table 1 row 10 (not); `monitoring.md` rule 14.

use super::{Asking, Site, Troubles, Truth, extents, logic, remember, unmet};
use crate::expression::arithmetic::duration;
use crate::expression::{EvaluationError, Surroundings, evaluate};
use apex_model::because::Evidence;
use apex_model::bindings::Bindings;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::monitor::AbsentPart;
use apex_model::monitor::{Keep, Part, Satisfaction};
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
    let passing = extents.passing.iter().map(|extent| extent.result.interval.1);
    let newest = extents.settled.iter().map(|result| result.interval.1).chain(passing).max();
    part.since = part.since.max(newest.unwrap_or(part.since));
    let goes_on = extents.passing.iter().any(|extent| extent.open);
    part.unknown = goes_on || extents.silent || logic::truth(&part.part, &mut asking) == Truth::Unknown;
    let over = part.since + part.length;
    if !part.unknown && over <= asking.now && part.told != Some(part.since) {
        part.told = Some(part.since);
        let interval = (part.since, over);
        remember(&mut part.found, result(&part.part, interval, asking.now));
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

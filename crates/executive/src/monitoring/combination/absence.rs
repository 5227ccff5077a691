//! Absence (M&I)
//! What: detects that a window of the required length passed in which the part did not hold.
//! Runs: whenever the verdict is requested, and at the instant at which the window is over.
//! Reads: what the part has found, evaluation context.
//! Writes: the absent part of a monitor.
//! Bound: O(new results) per evaluation; while the part is undecided, memory for its results that are at least one window apart.
//! PDL: `(:absent C :for D)`.
//! Paper: Table 1 row 10 (not); `condition-rules.md`, rule 14.

use crate::expression::arithmetic::duration;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::combination::{conjunction_span, logic, order_span, part_results, unmet};
use crate::monitoring::part::{ConditionFaults, PartContext, Truth, remember};
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{AbsentPart, Keep, Part, PartKind, Satisfaction};
use apex_model::because::Evidence;
use apex_model::estimate::Estimator;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::time::{Duration, Time};

/// Returns the part; it has not processed remembered evidence yet. The length is evaluated now.
///
/// # Errors
/// When the length cannot be evaluated.
pub(crate) fn create(
    part: Part,
    length: &Expr,
    start: Time,
    context: &dyn EvalContext,
) -> Result<AbsentPart, EvaluationError> {
    let value = evaluate(length, context)?;
    let length = duration(&value).map_err(|message| EvaluationError { message, place: length.place })?;
    Ok(AbsentPart {
        part,
        length,
        since: start,
        since_final: start,
        taken_back: None,
        reached: Vec::new(),
        order: None,
        goes_on: false,
        unknown: false,
        broken: None,
        told: None,
        seen: Vec::new(),
        found: Vec::new(),
        decides_at: Some(start + length),
    })
}

/// Forgets the results of the part and the windows found so far; the part itself is cleared separately.
pub(crate) fn forget(part: &mut AbsentPart, site: PartContext) {
    part.found.clear();
    part.seen.clear();
    part.reached.clear();
    part.order.iter_mut().for_each(|order| order_span::forget(order));
    (part.since, part.since_final) = (site.window.start, site.window.start);
    (part.goes_on, part.unknown) = (false, false);
    (part.broken, part.told, part.taken_back) = (None, None, None);
    part.decides_at = Some(part.since + part.length);
}

/// Prepares the evaluation of everything since `known` again, because a late sample arrived; `at` is its instant if that lies in the
/// window. Absences whose window includes `at`, or that were found since `known`, are withdrawn.
pub(crate) fn take_back(part: &mut AbsentPart, at: Option<Time>, known: Time) {
    if part.broken.is_some_and(|since| since >= known) {
        part.broken = None;
    }
    let Some(at) = at else { return };
    let stays = |window: &Satisfaction| window.interval.1 < at && window.recognised_at < known;
    let gone = part.found.iter().filter(|window| !stays(window)).map(|window| window.interval.0);
    let first = gone.chain([at - part.length]).min();
    part.taken_back = part.taken_back.into_iter().chain(first).min();
    part.found.retain(stays);
    part.since = part.since_final;
}

/// Returns true if the part can no longer change.
pub(crate) fn is_done(part: &AbsentPart, site: PartContext) -> bool {
    site.keep == Keep::First && !part.found.is_empty()
}

/// Evaluates the present results of the part. An absence begins just after the last result; a result at the instant at which it would be
/// complete prevents it.
pub(crate) fn advance(
    part: &mut AbsentPart,
    site: PartContext,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if is_done(part, site) {
        return;
    }
    let mut query = VerdictQuery::new(context);
    let extents = if part.order.is_some() {
        of_order(part, &mut query)
    } else if conjunction_span::is_together(&part.part) {
        conjunction_span::take(part, &mut query)
    } else {
        part_results::take_final(&mut part.part, &mut query)
    };
    let at_instants = holds_at_instants(&part.part);
    let lasts = |extent: &part_results::TentativeResult| {
        extent.open
            || expires(&extent.result).is_some_and(|over| over > query.now)
            || at_instants && rests_on_now(&part.part, &extent.result, query.now)
    };
    let goes_on = extents.passing.iter().any(lasts) && !planted::is(Bug::AbsentWhileItGoesOn);
    // While the part holds, its absence is false; while the part is undecided, so is its absence.
    part.goes_on = goes_on;
    part.unknown = !goes_on && (extents.doubt || is_blind(&part.part));
    let quiet = !goes_on && !part.unknown;
    // Between two evaluations the state is that of the earlier one, because every change is noticed. A state that lasted only during the
    // present instant does not count.
    if quiet && part.broken.is_some_and(|since| since < query.now) {
        part.since_final = part.since_final.max(query.now);
    }
    part.broken = (at_instants && !quiet).then(|| part.broken.unwrap_or(query.now));
    if part.broken.is_some() {
        part.seen.clear();
    } else if quiet {
        pass(part, &extents, site, &mut query);
    } else {
        see(part, site, extents.settled.iter().map(lasting).collect(), &mut query.troubles);
    }
    let over = part.since + part.length;
    let waits = extents.passing.iter().filter_map(|extent| expires(&extent.result)).chain([over]);
    // A part that holds at instants is evaluated at the instant at which it becomes undecided, because that interrupts its absence.
    let silent = if at_instants { part_results::silent_after(&part.part, query.now) } else { None };
    let waits = waits.chain(silent);
    part.decides_at = waits.chain(extents.changes_at).chain(query.wake).filter(|at| *at > query.now).min();
    troubles.append(query.troubles);
}

/// Returns the time that the chains of an order cover, and whether it is unknown that there are none.
fn of_order(part: &mut AbsentPart, query: &mut VerdictQuery<'_>) -> part_results::PartResults {
    let before = query.troubles.limits_reached;
    let (settled, passing) = order_span::take(part, query);
    part.part.forgotten |= query.troubles.limits_reached > before;
    let PartKind::InOrder(composite) = &part.part.kind else { return part_results::PartResults::default() };
    let parts = composite.parts.iter().filter(|part| !matches!(part.kind, PartKind::Delay(_)));
    let held = part.order.iter().flat_map(|order| &order.steps).map(|step| step.held);
    let truths = parts.zip(held).map(|(part, held)| if held { Truth::True } else { logic::truth(part, query) });
    let doubt = match truths.min().unwrap_or(Truth::True) {
        Truth::False => false,
        Truth::Unknown => true,
        // Points that were dropped at a limit might belong to a chain.
        Truth::True => part.part.forgotten && part.order.as_ref().is_some_and(|order| !order.found),
    };
    let passing = passing.into_iter().map(|result| part_results::TentativeResult { result, open: false }).collect();
    part_results::PartResults { settled, passing, doubt, ..part_results::PartResults::default() }
}

/// Records the windows that have passed up to now. Only now may it be known that there was no result before or between the known ones.
fn pass(part: &mut AbsentPart, extents: &part_results::PartResults, site: PartContext, query: &mut VerdictQuery<'_>) {
    let mut settled = std::mem::take(&mut part.seen);
    settled.extend(extents.settled.iter().map(lasting));
    let last = settled.iter().map(|(_, end)| *end).max();
    let mut all = settled;
    all.extend(extents.passing.iter().map(|extent| lasting(&extent.result)));
    all.sort_unstable();
    part.since = part.since_final;
    for (start, end) in all {
        if part.since + part.length < start {
            note(part, site, query);
        }
        part.since = part.since.max(end);
    }
    if part.since + part.length <= query.now {
        note(part, site, query);
    }
    part.since_final = part.since_final.max(last.unwrap_or(part.since_final));
}

/// Keeps results that are evaluated once all results before them are known. Results closer together than the window's length are merged;
/// at the limit, the newest results are merged, and the limit is reported.
fn see(part: &mut AbsentPart, site: PartContext, found: Vec<(Time, Time)>, troubles: &mut ConditionFaults) {
    let mut seen = std::mem::take(&mut part.seen);
    seen.extend(found);
    seen.sort_unstable();
    for (start, end) in seen {
        let full = part.seen.len() >= troubles.results_max;
        match part.seen.last_mut() {
            Some((_, last)) if *last + part.length >= start => *last = end.max(*last),
            Some((_, last)) if full => {
                troubles.too_many_results(site.place);
                *last = end.max(*last);
            }
            _ => part.seen.push((start, end)),
        }
    }
}

/// Returns the interval of a result, extended to the instant at which its persisted values expire: absence begins there.
fn lasting(result: &Satisfaction) -> (Time, Time) {
    let (start, end) = result.interval;
    (start, expires(result).filter(|over| *over > end + TICK).unwrap_or(end))
}

/// Returns the first instant at which some persisted value of a result is not valid any longer.
fn expires(result: &Satisfaction) -> Option<Time> {
    let persisted = result.evidence.iter().filter_map(|evidence| match evidence {
        Evidence::Estimate(estimate) if estimate.estimator == Estimator::Persistence => Some(estimate.extent.1),
        _ => None,
    });
    persisted.min()
}

/// Returns true if the part holds only at instants, so that the next evaluation may end its result.
pub(crate) fn holds_at_instants(part: &Part) -> bool {
    match &part.kind {
        PartKind::Not(_) | PartKind::Function(_) | PartKind::Regression(_) => true,
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter().any(holds_at_instants)
        }
        // Results of these kinds remain.
        _ => false,
    }
}

/// Returns true if the result contains evidence that holds at this instant and may not hold at the next.
fn rests_on_now(part: &Part, result: &Satisfaction, now: Time) -> bool {
    result.evidence.iter().any(|evidence| match evidence {
        Evidence::Absence { what, at } => *at == now && !is_window_without(part, what),
        Evidence::Function { at, .. } => *at == now,
        Evidence::Estimate(estimate) => estimate.estimator == Estimator::LinearRegression,
        _ => false,
    })
}

/// Returns true if `what` is the part of an inner `:absent`; its absence remains.
fn is_window_without(part: &Part, what: &str) -> bool {
    let mut is = matches!(&part.kind, PartKind::Absent(inner) if unmet::text(&inner.part) == what);
    part_results::for_each_inner(part, &mut |inner| is |= is_window_without(inner, what));
    is
}

/// Returns true if less is remembered than the part's window requires.
fn is_blind(part: &Part) -> bool {
    match &part.kind {
        PartKind::Measurement(leaf) => leaf.blind,
        PartKind::Event(leaf) => leaf.blind,
        _ => false,
    }
}

/// Records that the window since the last result of the part has passed without another one.
fn note(part: &mut AbsentPart, site: PartContext, query: &mut VerdictQuery<'_>) {
    let (since, over) = (part.since, part.since + part.length);
    let again = part.taken_back.is_some_and(|first| first <= since)
        && !part.found.iter().any(|window| window.interval.0 == since);
    if again || part.told.is_none_or(|told| told < since) {
        part.told = part.told.max(Some(since));
        let found = result(&part.part, (since, over), query.now);
        remember(&mut part.found, found, site, &mut query.troubles);
    }
}

fn result(part: &Part, interval: (Time, Time), now: Time) -> Satisfaction {
    let evidence = Evidence::Absence { what: unmet::text(part), at: now };
    Satisfaction { interval, recognised_at: now, bindings: Bindings::new(), evidence: EvidenceList::one(evidence) }
}

/// Returns satisfied; unknown if the data do not decide whether the part holds; otherwise not satisfied.
pub(crate) fn truth(part: &AbsentPart) -> Truth {
    Truth::of(!part.found.is_empty(), part.unknown)
}

/// Returns the time for which the part has been absent at `now`, and the instant at which that is long enough.
pub(crate) fn state(part: &AbsentPart, now: Time) -> (Duration, Time) {
    (now - part.since, part.since + part.length)
}

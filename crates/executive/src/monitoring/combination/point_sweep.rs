//! Sweeps of point orders (M&I)
//! What: drops the samples and messages that no chain of an order needs any longer.
//! Runs: with each verdict of an order of points.
//! Reads: the parts' results, evaluation context.
//! Writes: removes results from the parts of the order.
//! Bound: O(log n) per new point; a sweep over all n kept results each time they have doubled.
//! PDL: `:in-order`, `:delay`, `:constraint`.
//! Paper: Table 1, row 11.

use crate::expression::EvalContext;
use crate::monitoring::combination::point_steps::{
    OrderedPart, PointRole, count, is_used, points, settled, settled_mut, span_of, steps,
};
use crate::monitoring::reported_results::Used;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::{Bindings, PlainBindings, joined};
use crate::state::monitors::monitor::{Composite, Part, PartKind, PointLimit, PointOrder, Satisfaction};
use apex_model::time::{Duration, Time};
use std::collections::{BTreeMap, BTreeSet};

/// Number of kept results from which on a sweep is worthwhile. It is small, so that short tests also sweep. A sweep is linear in the kept
/// results, and the next one follows when their number has doubled.
pub(crate) const SWEEP_AT_LEAST: usize = 8;

/// Drops results that no chain needs any longer. Points that arrived without a preceding point are checked at each call, the others when
/// their number has doubled. `used` are results of chains that were reported already.
pub(crate) fn sweep(part: &mut Part, used: Option<&Used>, context: &dyn EvalContext) {
    let start = part.window.start;
    let PartKind::InOrder(composite) = &mut part.kind else { return };
    let Some(mut order) = composite.order.take() else { return };
    let mut query = VerdictQuery::new(context);
    let kept: usize = composite.parts.iter().map(count).sum();
    let whole = kept >= order.sweep_at;
    if whole {
        order.checked.iter_mut().for_each(|checked| *checked = 0);
    }
    let points = points(composite);
    // Each point is swept against the preceding one, which was swept already, then against the following one.
    for (number, point) in points.iter().enumerate() {
        let checked = order.checked.get(number).copied().unwrap_or_default();
        // The newest settled result is kept: it shows that the part has held.
        let newest = composite.parts.get(point.0).map_or(0, |part| settled(part, point.1).len()).saturating_sub(1);
        if checked >= newest {
            continue;
        }
        let gone = gone_without_predecessor((composite, &order.limits), (number, checked), start, used, &mut query);
        remove(composite, *point, &gone, order.checked.get_mut(number));
    }
    if whole {
        for (number, point) in points.iter().enumerate().rev() {
            let gone = gone_without_successor((composite, &order), number, start, used, &mut query);
            remove(composite, *point, &gone, order.checked.get_mut(number));
        }
        for limit in &order.far {
            let gone = gone_beyond(composite, &order.limits, limit, &mut query);
            let Some(point) = points.get(limit.first) else { continue };
            remove(composite, *point, &gone, order.checked.get_mut(limit.first));
            for (number, point) in points.iter().enumerate().take(limit.second).skip(limit.first + 1) {
                let gone = gone_between(composite, &order.limits, (limit, number), &mut query);
                remove(composite, *point, &gone, order.checked.get_mut(number));
            }
        }
        for part in &mut composite.parts {
            if let PartKind::Episode(leaf) = &mut part.kind {
                leaf.points.iter_mut().for_each(|points| points.drop_runs());
            }
        }
        let kept: usize = composite.parts.iter().map(count).sum();
        order.sweep_at = kept.saturating_mul(2).max(SWEEP_AT_LEAST);
    }
    composite.order = Some(order);
}

/// Returns true if a point precedes this result of step `number`. The first step is compared with the start of the order.
fn is_preceded(
    steps: &[OrderedPart<'_>],
    number: usize,
    result: &Satisfaction,
    start: Time,
    used: Option<&Used>,
) -> bool {
    let Some(step) = steps.get(number) else { return false };
    let Some(before) = number.checked_sub(1).and_then(|before| steps.get(before)) else {
        let (from, to) = step.following(start);
        return from <= result.interval.0 && result.interval.0 <= to;
    };
    let precedes =
        |each: &Satisfaction| !is_used(before, each, used) && joined(&each.bindings, &result.bindings).is_some();
    before.within(step.preceding(result.interval.0)).any(precedes)
}

/// Returns the places of results of step `number`, from place `from` on, that no earlier point precedes, or that were used.
fn gone_without_predecessor(
    (composite, limits): (&Composite, &[(Duration, Duration)]),
    (number, from): (usize, usize),
    start: Time,
    used: Option<&Used>,
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    let Some((steps, _)) = steps(composite, limits, query) else { return Vec::new() };
    let Some(step) = steps.get(number) else { return Vec::new() };
    let newest = step.kept.len().saturating_sub(1);
    let before = number.checked_sub(1).and_then(|before| steps.get(before));
    let useless = |result: &Satisfaction| {
        let last = step.preceding(result.interval.0).1;
        let may_come = before.is_some_and(|before| {
            before.watermark(&result.bindings, query.now).is_none_or(|watermark| watermark <= last)
        });
        is_used(step, result, used) || !may_come && !is_preceded(&steps, number, result, start, used)
    };
    let unchecked = step.kept.iter().enumerate().take(newest).skip(from);
    unchecked.filter(|(_, result)| useless(result)).map(|(place, _)| place).collect()
}

/// The chains that end in the points of one step: for each set of bindings the instants of these points, in order.
type ChainEnds = Vec<(Bindings, Vec<Time>)>;

/// Returns the places in `ends` of the chains that `result` of `step` can extend, with the bindings of the extended chains.
fn extended(ends: &ChainEnds, step: &OrderedPart<'_>, result: &Satisfaction) -> Vec<Bindings> {
    let (from, to) = step.preceding(result.interval.0);
    let any = |times: &[Time]| times.get(times.partition_point(|at| *at < from)).is_some_and(|at| *at <= to);
    let together = |(bindings, times): &(Bindings, Vec<Time>)| {
        if any(times) { joined(bindings, &result.bindings) } else { None }
    };
    ends.iter().filter_map(together).collect()
}

/// Returns the chains that end in points of step `number`.
fn chain_ends(steps: &[OrderedPart<'_>], number: usize, start: Time, used: Option<&Used>) -> ChainEnds {
    let mut ends: ChainEnds = vec![(Bindings::new(), vec![start])];
    for step in steps.iter().take(number + 1) {
        let mut next = ChainEnds::new();
        let mut places: BTreeMap<PlainBindings, usize> = BTreeMap::new();
        for result in step.within((Time::BEGINNING, Time(i64::MAX))).filter(|each| !is_used(step, each, used)) {
            for bindings in extended(&ends, step, result) {
                let place = *places.entry(bindings.plain()).or_insert(next.len());
                match next.get_mut(place) {
                    Some((_, times)) => times.push(result.interval.1),
                    None => next.push((bindings, vec![result.interval.1])),
                }
            }
        }
        ends = next;
    }
    ends
}

/// Returns the indices of results of step `number` that no future point can follow, or that earlier results represent.
fn gone_without_successor(
    (composite, order): (&Composite, &PointOrder),
    number: usize,
    start: Time,
    used: Option<&Used>,
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    let Some((steps, delay)) = steps(composite, &order.limits, query) else { return Vec::new() };
    let Some(step) = steps.get(number) else { return Vec::new() };
    let next = steps.get(number + 1);
    if let Some(next) = next.filter(|next| next.gap.most != Duration::MAX) {
        return gone_behind(step, next, used, query);
    }
    // With a greatest duration, a later beginning permits ends that an earlier one does not permit.
    if let Some(end) = next.filter(|_| step.role == PointRole::Start) {
        return gone_beginnings(&steps, (number, end), start, used);
    }
    // Chains without a delay at the end are over with their last point.
    if next.is_none() && delay.is_none() {
        return Vec::new();
    }
    // A later point permits ends that a greatest time from a point before excludes for an earlier one.
    let open = |limit: &PointLimit| limit.first <= number && number < limit.second && limit.most != Duration::MAX;
    if order.far.iter().any(open) {
        return Vec::new();
    }
    if order.far.iter().any(|limit| limit.second <= number) {
        return if order.binds { Vec::new() } else { gone_after_chain((&steps, order), number, start, used) };
    }
    let ends = match number.checked_sub(1) {
        Some(before) => chain_ends(&steps, before, start, used),
        None => vec![(Bindings::new(), vec![start])],
    };
    let mut first_of: BTreeSet<PlainBindings> = BTreeSet::new();
    let mut useless = |result: &Satisfaction| {
        if is_used(step, result, used) {
            return false;
        }
        let chains = extended(&ends, step, result);
        let known = chains.iter().filter(|bindings| !first_of.insert(bindings.plain())).count();
        // If no part binds a variable, one chain suffices, whatever else may come.
        known > 0 && known == chains.len() && (!order.binds || !gains(&steps, number, result, query))
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().filter(|(place, result)| useless(result) && *place < newest);
    gone.map(|(place, _)| place).collect()
}

/// Returns the indices of results of `step` after which the greatest delay of `next` has passed without a result.
fn gone_behind(
    step: &OrderedPart<'_>,
    next: &OrderedPart<'_>,
    used: Option<&Used>,
    query: &VerdictQuery<'_>,
) -> Vec<usize> {
    let useless = |result: &Satisfaction| {
        let span = next.following(result.interval.1);
        let over = next.watermark(&result.bindings, query.now).is_some_and(|watermark| watermark > span.1);
        !is_used(step, result, used)
            && over
            && !next.within(span).any(|each| joined(&result.bindings, &each.bindings).is_some())
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().take(newest).filter(|(_, result)| useless(result));
    gone.map(|(place, _)| place).collect()
}

/// Returns the indices of the first results of a limit between points that are not neighbours, if its greatest time has passed without a
/// second one.
fn gone_beyond(
    composite: &Composite,
    limits: &[(Duration, Duration)],
    limit: &PointLimit,
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    let Some((steps, _)) = steps(composite, limits, query) else { return Vec::new() };
    let (Some(step), Some(second)) = (steps.get(limit.first), steps.get(limit.second)) else { return Vec::new() };
    let useless = |result: &Satisfaction| {
        let (from, to) = span_of(limit, result.interval.0);
        let over = second.watermark(&result.bindings, query.now).is_some_and(|watermark| watermark > to);
        over && !second
            .within((from.max(result.interval.0), to))
            .any(|each| joined(&result.bindings, &each.bindings).is_some())
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().take(newest).filter(|(_, result)| useless(result));
    gone.map(|(place, _)| place).collect()
}

/// Returns the indices of the results of step `number` that can no longer lie between the two points of a limit: since the newest first
/// point before them the greatest time has passed, and no second point has followed. The newest first point permits the latest second ones.
fn gone_between(
    composite: &Composite,
    limits: &[(Duration, Duration)],
    (limit, number): (&PointLimit, usize),
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    let Some((steps, _)) = steps(composite, limits, query) else { return Vec::new() };
    let Some(step) = steps.get(number) else { return Vec::new() };
    let (Some(first), Some(second)) = (steps.get(limit.first), steps.get(limit.second)) else { return Vec::new() };
    let useless = |result: &Satisfaction| {
        let agrees = |each: &&Satisfaction| joined(&result.bindings, &each.bindings).is_some();
        // Another first point may still come before this one.
        let complete = first.watermark(&result.bindings, query.now).is_some_and(|at| at > result.interval.0);
        let before = first.within((Time::BEGINNING, result.interval.0)).filter(agrees).last();
        let Some(before) = before.filter(|_| complete) else { return false };
        let to = span_of(limit, before.interval.0).1;
        let over = second.watermark(&result.bindings, query.now).is_some_and(|watermark| watermark > to);
        over && !second.within((result.interval.0, to)).any(|each| agrees(&each))
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().take(newest).filter(|(_, result)| useless(result));
    gone.map(|(place, _)| place).collect()
}

/// Returns the indices of results of step `number` behind the first one in which a chain ends, if no part binds a variable.
fn gone_after_chain(
    (steps, order): (&[OrderedPart<'_>], &PointOrder),
    number: usize,
    start: Time,
    used: Option<&Used>,
) -> Vec<usize> {
    let Some(step) = steps.get(number) else { return Vec::new() };
    let newest = step.kept.len().saturating_sub(1);
    let unused = || step.kept.iter().enumerate().take(newest).filter(|(_, result)| !is_used(step, result, used));
    let mut ends = unused()
        .filter(|(_, result)| is_reached((steps, order), start, used, &mut Vec::new(), (number, result.interval.0)));
    let Some((first, _)) = ends.next() else { return Vec::new() };
    unused().map(|(place, _)| place).filter(|place| *place > first).collect()
}

/// Returns true if a chain with the points `chain` at its beginning ends in the point of step `number` at `last`.
fn is_reached(
    (steps, order): (&[OrderedPart<'_>], &PointOrder),
    start: Time,
    used: Option<&Used>,
    chain: &mut Vec<Time>,
    (number, last): (usize, Time),
) -> bool {
    let place = chain.len();
    let Some(step) = steps.get(place) else { return false };
    let (mut from, mut to) = step.following(chain.last().copied().unwrap_or(start));
    for limit in order.far.iter().filter(|limit| limit.second == place) {
        let Some(before) = chain.get(limit.first) else { continue };
        let span = span_of(limit, *before);
        (from, to) = (from.max(span.0), to.min(span.1));
    }
    if place == number {
        return from <= last && last <= to;
    }
    for result in step.within((from, to.min(last))).filter(|each| !is_used(step, each, used)) {
        chain.push(result.interval.0);
        let reached = is_reached((steps, order), start, used, chain, (number, last));
        chain.pop();
        if reached {
            return true;
        }
    }
    false
}

/// Returns true if a chain with other bindings may still be found that ends in this result.
fn gains(steps: &[OrderedPart<'_>], number: usize, result: &Satisfaction, query: &VerdictQuery<'_>) -> bool {
    let complete = |step: &OrderedPart<'_>| {
        step.watermark(&result.bindings, query.now).is_some_and(|watermark| watermark > result.interval.0)
    };
    !steps.iter().take(number).all(complete)
}

/// Returns the indices of beginnings of an episode that no end follows, or that an earlier one of the same run represents: it permits every
/// end that the later one permits.
fn gone_beginnings(
    steps: &[OrderedPart<'_>],
    (number, end): (usize, &OrderedPart<'_>),
    start: Time,
    used: Option<&Used>,
) -> Vec<usize> {
    let Some(step) = steps.get(number) else { return Vec::new() };
    let mut represented = None;
    let mut useless = |result: &Satisfaction| {
        let run = end.preceding(result.interval.0).0;
        if represented == Some(run) || step.ends_never(end, result.interval.0) {
            return true;
        }
        if is_preceded(steps, number, result, start, used) {
            represented = Some(run);
        }
        false
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().take(newest).filter(|(_, result)| useless(result));
    gone.map(|(place, _)| place).collect()
}

/// Removes the points at the sorted indices `gone`, and records that the remaining ones were checked.
fn remove(composite: &mut Composite, (index, role): (usize, PointRole), gone: &[usize], checked: Option<&mut usize>) {
    let Some(list) = composite.parts.get_mut(index).and_then(|part| settled_mut(part, role)) else { return };
    if let Some(first) = gone.first() {
        let (mut place, mut next) = (*first, gone.iter().copied().peekable());
        let mut tail = list.split_off((*first).min(list.len()));
        tail.retain(|_| {
            place += 1;
            next.next_if_eq(&(place - 1)).is_none()
        });
        list.append(&mut tail);
    }
    if let Some(checked) = checked {
        *checked = list.len().saturating_sub(1);
    }
}

/// Resets the state after all results were used up: nothing is examined yet.
pub(crate) fn begin_again(composite: &mut Composite) {
    if let Some(order) = &mut composite.order {
        order.sweep_at = SWEEP_AT_LEAST;
        order.checked.iter_mut().for_each(|checked| *checked = 0);
    }
}

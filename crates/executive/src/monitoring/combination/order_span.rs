//! Spans of orders (M&I)
//! What: computes the time that chains of samples and messages cover, without combining all results.
//! Runs: whenever an absence evaluates an `:in-order` of points that binds no variable.
//! Reads: results of the parts, evaluation context.
//! Writes: removes final results from the parts; keeps the instants that later chains may need.
//! Bound: O(log n) per sample, amortised, for n kept instants: those within the greatest delays, or one for each part without one.
//! PDL: `(:absent (:in-order ..) :for D)`.
//! Paper: Table 1 row 10 (not); `condition-rules.md`, rule 14.
//!
//! Absence needs the time that chains cover, not the chains. All chains that end in a point are covered by the one that starts first. Its
//! start is that of the first preceding point that ends a chain, because points of one part arrive in order of time. A point is decided
//! when that preceding point is known, or when no earlier one can come any longer. Points are decided in order of time.

use crate::monitoring::combination::point_steps::{OrderedPart, points, settled_mut, steps};
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{
    AbsentPart, Composite, CoveredSpan, MeasurementPart, OrderSpan, Part, PartKind, PointOrder, Satisfaction, SpanStep,
};
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::{Expr, ExprKind};
use apex_model::source::Place;
use apex_model::time::{Duration, Time};
use std::collections::VecDeque;

/// Returns the state for `part`, an order of points that binds no variable, if it has only messages and samples of named objects without
/// `:lateness`, and its delays do not change.
pub(crate) fn create(part: &Part, order: PointOrder) -> Option<Box<OrderSpan>> {
    let PartKind::InOrder(composite) = &part.kind else { return None };
    let fixed = |expr: &Expr| matches!(expr.kind, ExprKind::Constant(_) | ExprKind::Variable { .. });
    let is_point = |part: &Part| match &part.kind {
        PartKind::Measurement(leaf) => leaf.variable.is_some(),
        PartKind::Event(_) => true,
        PartKind::Delay(leaf) => fixed(&leaf.from) && leaf.to.as_ref().is_none_or(fixed),
        _ => false,
    };
    let steps = vec![SpanStep::default(); order.limits.len()];
    let fits = order.far.is_empty() && composite.parts.iter().all(is_point);
    fits.then(|| Box::new(OrderSpan { limits: order.limits, steps, covered: VecDeque::new(), found: false }))
}

/// Starts again.
pub(crate) fn forget(order: &mut OrderSpan) {
    order.steps.iter_mut().for_each(|step| *step = SpanStep::default());
    order.covered.clear();
    order.found = false;
}

/// Returns the time that the chains of the absent order cover: the part that cannot change any longer, listed once, and the rest.
pub(crate) fn take(absent: &mut AbsentPart, query: &mut VerdictQuery<'_>) -> (Vec<Satisfaction>, Vec<Satisfaction>) {
    let start = absent.part.window.start;
    let (Some(order), PartKind::InOrder(composite)) = (absent.order.as_deref_mut(), &mut absent.part.kind) else {
        return (Vec::new(), Vec::new());
    };
    let known = known_until(composite, query.now);
    collect(composite, order, known, query);
    let mut passing = Vec::new();
    if let Some((steps, delay)) = steps(composite, &order.limits, query) {
        let delay = delay.unwrap_or(Duration::ZERO);
        decide(order, &steps, (start, delay), known);
        let (complete, later) = complete(order, delay, known, query);
        passing = Overlay { order, steps: &steps, delay, start }.spans(query);
        passing.extend(later);
        order.found |= !complete.is_empty() || !passing.is_empty();
        complete.into_iter().for_each(|span| cover(order, span, absent.length, absent.part.place, query));
    }
    let settled = final_spans(composite, order, known);
    passing.extend(order.covered.iter().map(|span| covered(span.interval, span.noted_at)));
    (settled, passing)
}

/// Returns the instant before which no instant is evaluated again. A late sample causes a new evaluation from the newest sample on, so
/// messages that came after that are not final.
fn known_until(composite: &Composite, now: Time) -> Time {
    let newest = |part: &Part| match &part.kind {
        PartKind::Measurement(leaf) => newest_of(leaf),
        _ => None,
    };
    let samples = composite.parts.iter().any(|part| matches!(part.kind, PartKind::Measurement(_)));
    let known = composite.parts.iter().filter_map(newest).max().unwrap_or(Time::BEGINNING);
    if samples { known.min(now) } else { now }
}

/// Moves the results up to `known` that no sample can replace any longer out of the parts.
fn collect(composite: &mut Composite, order: &mut OrderSpan, known: Time, query: &mut VerdictQuery<'_>) {
    for ((index, role), step) in points(composite).into_iter().zip(&mut order.steps) {
        let Some(part) = composite.parts.get_mut(index) else { continue };
        let place = part.place;
        let Some(list) = settled_mut(part, role) else { continue };
        for result in list.extract_if(.., |result| result.recognised_at <= known) {
            let at = result.interval.0;
            step.held = true;
            let after = step.pending.partition_point(|before| *before <= at);
            step.pending.insert(after, at);
            if step.pending.len() > query.troubles.results_max {
                query.troubles.too_many_results(place);
                step.pending.drain(..query.troubles.results_max / 4);
            }
        }
    }
}

/// Decides for the collected points whether chains end in them, and drops the points that no later one can follow.
fn decide(order: &mut OrderSpan, steps: &[OrderedPart<'_>], (start, delay): (Time, Duration), known: Time) {
    // Points of the preceding step before this instant are decided, and no more of them come.
    let mut decided = Time::BEGINNING;
    for (number, step) in steps.iter().enumerate() {
        let (before, here) = order.steps.split_at_mut(number);
        let (mut preceding, Some(own)) = (before.last_mut(), here.first_mut()) else { continue };
        let lasting = steps.get(number + 1).is_some_and(|next| next.gap.most == Duration::MAX);
        while let Some(at) = own.pending.front().copied() {
            let chain = match &preceding {
                None => within(step.following(start), at).then_some(at),
                Some(preceding) => {
                    let (from, to) = step.preceding(at);
                    let first = first_end(&preceding.ends, (from, to));
                    if first.is_none() && decided <= to {
                        break;
                    }
                    first
                }
            };
            own.pending.pop_front();
            // Without a greatest delay behind it, the first end allows every chain that a later one allows.
            if let Some(chain) = chain.filter(|_| !lasting || own.ends.is_empty()) {
                own.ends.push_back((at, chain));
            }
        }
        // Of the last points that lack a preceding one, the newest covers what the others cover.
        if number + 1 == steps.len() && step.gap.most == Duration::MAX && delay == Duration::ZERO {
            own.pending.drain(..own.pending.len().saturating_sub(1));
        }
        let watermark = step.watermark(&Bindings::new(), known).map_or(Time::BEGINNING, |at| at.min(known));
        decided = own.pending.front().map_or(watermark, |first| watermark.min(*first));
        if let Some(preceding) = &mut preceding {
            let gone = preceding.ends.partition_point(|(at, _)| step.following(*at).1 < decided);
            preceding.ends.drain(..gone);
        }
    }
}

fn within((from, to): (Time, Time), at: Time) -> bool {
    from <= at && at <= to
}

/// Returns the start of the chain that ends in the first of `ends` within the closed span.
fn first_end(ends: &VecDeque<(Time, Time)>, (from, to): (Time, Time)) -> Option<Time> {
    let first = ends.partition_point(|(at, _)| *at < from);
    ends.get(first).filter(|(at, _)| *at <= to).map(|(_, start)| *start)
}

/// Returns the spans of the complete chains whose delay at the end is over: those up to `known`, which it takes out, and the later ones.
/// Requests a wake for the next one.
fn complete(
    order: &mut OrderSpan,
    delay: Duration,
    known: Time,
    query: &mut VerdictQuery<'_>,
) -> (Vec<(Time, Time)>, Vec<Satisfaction>) {
    let Some(last) = order.steps.last_mut() else { return (Vec::new(), Vec::new()) };
    let over = |until: Time| last.ends.partition_point(|(end, _)| *end + delay <= until);
    let (settled, later) = (over(known), over(query.now));
    if let Some((end, _)) = last.ends.get(later) {
        query.wake_at(*end + delay);
    }
    let span = |(end, start): &(Time, Time)| covered((*start, *end), *end + delay);
    let passing = last.ends.range(settled..later.max(settled));
    let passing = passing.map(span).collect();
    (last.ends.drain(..settled).map(|(end, start)| (start, end)).collect(), passing)
}

/// Adds a span that chains cover. Spans are joined if no window of `length` lies between them; at the limit, the newest ones.
fn cover(
    order: &mut OrderSpan,
    (start, end): (Time, Time),
    length: Duration,
    place: Place,
    query: &mut VerdictQuery<'_>,
) {
    let mut new = CoveredSpan { interval: (start, end), noted_at: query.now };
    while let Some(last) = order.covered.back() {
        let full = order.covered.len() >= query.troubles.results_max;
        if last.interval.1 + length < new.interval.0 && !full {
            break;
        }
        if full {
            query.troubles.too_many_results(place);
        }
        if last.interval.0 <= new.interval.0 {
            new.noted_at = last.noted_at;
        }
        new.interval = (new.interval.0.min(last.interval.0), new.interval.1.max(last.interval.1));
        order.covered.pop_back();
    }
    order.covered.push_back(new);
}

/// Takes out the spans before which no window can be withdrawn any longer. A late sample withdraws windows that end behind it, and those
/// that were found since the newest sample.
fn final_spans(composite: &Composite, order: &mut OrderSpan, known: Time) -> Vec<Satisfaction> {
    let newest = |part: &Part| match &part.kind {
        PartKind::Measurement(leaf) => Some(newest_of(leaf).unwrap_or(Time::BEGINNING)),
        _ => None,
    };
    let first_late = composite.parts.iter().filter_map(newest).min();
    let known = if first_late.is_some() { known } else { Time::END };
    let is_final = |span: &CoveredSpan| first_late.is_none_or(|first| span.interval.1 < first) && span.noted_at < known;
    let count = order.covered.iter().take_while(|span| is_final(span)).count();
    order.covered.drain(..count).map(|span| covered(span.interval, span.noted_at)).collect()
}

fn newest_of(leaf: &MeasurementPart) -> Option<Time> {
    leaf.seen.as_ref()?.newest.samples().map(|sample| sample.at).max()
}

fn covered(interval: (Time, Time), recognised_at: Time) -> Satisfaction {
    Satisfaction { interval, recognised_at, bindings: Bindings::new(), evidence: EvidenceList::default() }
}

/// Chains that contain a point which is not final: a newest sample, which another one of its instant may replace, a message after all
/// samples, or a point that is not decided.
struct Overlay<'a> {
    order: &'a OrderSpan,
    steps: &'a [OrderedPart<'a>],
    delay: Duration,
    /// The start of the window.
    start: Time,
}

impl Overlay<'_> {
    /// Returns the spans that these chains cover. The first such point of a chain is one that its part still keeps, because points that
    /// are not decided follow no decided one.
    fn spans(&self, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
        let mut spans = Vec::new();
        for (number, step) in self.steps.iter().enumerate() {
            let ends = number.checked_sub(1).and_then(|before| self.order.steps.get(before)).map(|step| &step.ends);
            for at in self.kept(number, (Time::BEGINNING, Time::END), query.now) {
                let start = match ends {
                    None => within(step.following(self.start), at).then_some(at),
                    Some(ends) => first_end(ends, step.preceding(at)),
                };
                let mut failed = vec![Time(i64::MAX); self.steps.len()];
                let end = start.and_then(|_| self.last_end(number, at, &mut failed, query));
                if let Some(interval) = start.zip(end) {
                    spans.push(covered(interval, interval.1 + self.delay));
                }
            }
        }
        spans
    }

    /// Returns the points within the span that the part of a step still keeps.
    fn kept(&self, number: usize, span: (Time, Time), now: Time) -> Vec<Time> {
        let Some(step) = self.steps.get(number) else { return Vec::new() };
        let known = step.within(span).filter(|result| result.recognised_at <= now);
        known.map(|result| result.interval.0).collect()
    }

    /// Returns the last end of the chains that contain this point, if their delay is over. `failed` contains for each step the first of the
    /// instants that were tried without one; points are tried from the last to the first, so that later ones were tried before.
    fn last_end(&self, number: usize, at: Time, failed: &mut [Time], query: &mut VerdictQuery<'_>) -> Option<Time> {
        let Some(next) = self.steps.get(number + 1) else {
            let over = at + self.delay;
            if over > query.now {
                query.wake_at(over);
                return None;
            }
            return Some(at);
        };
        let (from, mut to) = next.following(at);
        to = to.min(failed.get(number + 1).map_or(to, |failed| Time(failed.0.saturating_sub(TICK.0))));
        if number + 2 == self.steps.len() {
            to = self.over_by(number + 1, (from, to), query);
        }
        let pending = self.order.steps.get(number + 1).map(|step| &step.pending)?;
        let first = pending.partition_point(|each| *each < from);
        let after = pending.partition_point(|each| *each <= to);
        let kept = self.kept(number + 1, (from, to), query.now).into_iter().rev();
        for each in kept.chain(pending.range(first..after.max(first)).rev().copied()) {
            if let Some(end) = self.last_end(number + 1, each, failed, query) {
                return Some(end);
            }
            if let Some(failed) = failed.get_mut(number + 1) {
                *failed = (*failed).min(each);
            }
        }
        None
    }

    /// Returns the end of the span in which the delay behind a last point is over; requests a wake for the first later point.
    fn over_by(&self, last: usize, (from, to): (Time, Time), query: &mut VerdictQuery<'_>) -> Time {
        let over = Time(query.now.0.saturating_sub(self.delay.0));
        let waits = self.order.steps.get(last).map(|step| &step.pending);
        let after = from.max(over + TICK);
        let waiting = waits.and_then(|all| all.get(all.partition_point(|at| *at < after)).copied());
        let kept = self.kept(last, (after, to), query.now);
        if let Some(first) = waiting.into_iter().chain(kept).min().filter(|first| *first <= to) {
            query.wake_at(first + self.delay);
        }
        to.min(over)
    }
}

//! Orders of points (M&I)
//! What: finds the first chain of samples and messages that follow one another, and drops those that no chain needs.
//! Runs: whenever the verdict of a monitor is asked whose whole condition is such an order.
//! Reads: the parts' results, evaluation context.
//! Writes: removes results from the parts of the order.
//! Bound: O(log n) per sample for parts that bind no variable; a sweep over all n kept results each time they have doubled.
//! PDL: `:in-order`, `:delay`, `:constraint`.
//! Paper: Table 1, row 11.
//!
//! Points with equal bindings arrive in order of time. Of two points, the earlier one therefore allows every chain that the later one
//! allows, except those that a greatest delay excludes. This decides which points are kept:
//!
//! - a point without a preceding point is dropped once every earlier part has received samples up to the time of a possible one;
//! - a point is dropped if samples of the next part are later than its greatest delay, and no kept point follows it;
//! - without a greatest delay, a point is dropped if the chains that end in it have the bindings of chains that end earlier.
//!
//! A delay at the end lets a chain be recognised later, and does not change which one is first.

use crate::expression::EvalContext;
use crate::monitoring::combination::logic::joined;
use crate::monitoring::combination::order_constraints;
use crate::monitoring::combination::point_steps::{OrderedPart, PointRole, count, points, settled, settled_mut, steps};
use crate::monitoring::episodes::episode::durations;
use crate::monitoring::episodes::run_update::pair_of;
use crate::monitoring::memory::retention;
use crate::monitoring::reported_results::Used;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::{Bindings, PlainBindings};
use crate::state::monitors::monitor::{Composite, PairPoints, Part, PartKind, PointOrder, Satisfaction};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::evidence_list::EvidenceList;
use apex_model::pattern::Pattern;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Number of kept results from which on a sweep is worthwhile. It is small, so that short tests also sweep. A sweep is linear in the kept
/// results, and the next one follows when their number has doubled.
const SWEEP_AT_LEAST: usize = 8;

/// Returns bookkeeping for `composite` if it is an order of points: measurements of named or bound objects without `:lateness`, messages,
/// and, where no part binds a variable, episodes of any two samples, with delays between them or after them, and with constraints on the
/// time between neighbours. `binds` is true if it contains a pattern variable.
pub(crate) fn create(composite: &Composite, binds: bool, context: &dyn EvalContext) -> Option<Box<PointOrder>> {
    let is_point = |part: &Part| match &part.kind {
        PartKind::Measurement(leaf) => {
            let pattern = &leaf.condition.variable;
            let declared = context.library().state_variables.get(&pattern.attribute);
            let named = leaf.variable.is_some() || matches!(pattern.object, Pattern::Variable(_));
            named && declared.and_then(retention::lateness).is_none()
        }
        PartKind::Event(_) | PartKind::Delay(_) => true,
        PartKind::Episode(leaf) => {
            let timing = &leaf.condition.timing;
            let declared = context.library().state_variables.get(&leaf.condition.variable.attribute);
            let punctual = leaf.variable.is_some() && declared.and_then(retention::lateness).is_none();
            let any_time = timing.start.is_empty() && timing.end.is_empty();
            leaf.any_pair && punctual && !binds && any_time && durations(leaf).is_some()
        }
        _ => false,
    };
    let mut tags = BTreeSet::new();
    let distinct = composite.parts.iter().filter_map(|part| part.tag.as_ref()).all(|tag| tags.insert(tag));
    let any_point = composite.parts.iter().any(|part| !matches!(part.kind, PartKind::Delay(_)));
    let fits = distinct && any_point && composite.parts.iter().all(is_point);
    let limits = order_constraints::limits(composite).filter(|_| fits)?;
    Some(Box::new(PointOrder { sweep_at: SWEEP_AT_LEAST, checked: vec![0; limits.len()], binds, limits }))
}

/// Lets a part of an order of points keep the instants of samples instead of pairs of them.
pub(crate) fn keep_points(part: &mut Part) {
    if let PartKind::Episode(leaf) = &mut part.kind {
        leaf.points = durations(leaf).map(|durations| Box::new(PairPoints::lasting(durations)));
    }
}

/// Returns the first chain for each set of bindings; the first chain of all if no part binds a variable.
pub(crate) fn results(
    part: &Part,
    composite: &Composite,
    order: &PointOrder,
    query: &mut VerdictQuery<'_>,
) -> Vec<Satisfaction> {
    let Some((steps, delay)) = steps(composite, &order.limits, query) else { return Vec::new() };
    let Some(extents) = extents(&steps) else { return Vec::new() };
    let mut search = ChainSearch {
        steps: &steps,
        extents: &extents,
        binds: order.binds,
        looks: 0,
        failed: vec![Time::BEGINNING; steps.len()],
        chain: Vec::new(),
        found: Vec::new(),
        bound: BTreeSet::new(),
    };
    search.extend(part.window.start, &Bindings::new(), query);
    if search.looks > query.context.limits().of(Limit::MonitorCombinations) {
        query.troubles.reached(Limit::MonitorCombinations, query.context, part.place);
    }
    let mut found = search.found;
    if let Some(delay) = delay {
        found.retain_mut(|result| is_over(result, delay, query));
    }
    found.sort_by_key(|result| result.recognised_at);
    found
}

/// Returns the first and last instant of the points of each step that points of all later steps may follow; `None` if there are none.
fn extents(steps: &[OrderedPart<'_>]) -> Option<Vec<(Time, Time)>> {
    let mut extents = Vec::with_capacity(steps.len());
    let mut span = (Time::BEGINNING, Time(i64::MAX));
    for step in steps.iter().rev() {
        let (first, last) = step.extent(span)?;
        extents.push((first, last));
        span = (step.preceding(first).0, step.preceding(last).1);
    }
    extents.reverse();
    Some(extents)
}

/// Returns true if the time after the last point has passed, and adds that to the result; otherwise requests a wake. No other chain with
/// these bindings ends earlier than the first.
fn is_over(result: &mut Satisfaction, delay: Duration, query: &mut VerdictQuery<'_>) -> bool {
    let end = result.interval.1;
    let over = end + delay;
    if over > query.now {
        query.wake_at(over);
        return false;
    }
    result.recognised_at = result.recognised_at.max(over);
    let instant = EvidenceList::one(Evidence::Instant { since: Some(end), at: over });
    result.evidence = result.evidence.joined(&instant);
    true
}

/// Depth-first search for chains in order of their first points.
struct ChainSearch<'a> {
    steps: &'a [OrderedPart<'a>],
    extents: &'a [(Time, Time)],
    binds: bool,
    looks: u64,
    /// For each step, the latest instant of a point that no chain to the end contains, if no part binds a variable. Points that are tried
    /// later are not earlier than those tried before, because the spans in which points may follow move with the preceding points.
    failed: Vec<Time>,
    chain: Vec<&'a Satisfaction>,
    found: Vec<Satisfaction>,
    bound: BTreeSet<PlainBindings>,
}

impl<'a> ChainSearch<'a> {
    /// Extends the chain, whose last point ends at `end`. Returns true when the search is over.
    fn extend(&mut self, end: Time, bindings: &Bindings, query: &mut VerdictQuery<'_>) -> bool {
        let number = self.chain.len();
        let (steps, extents) = (self.steps, self.extents);
        let Some(step) = steps.get(number) else { return self.complete(bindings) };
        let (mut from, mut to) = step.following(end);
        // Points that no point of the next part follows are skipped.
        let Some((first, last)) = extents.get(number) else { return false };
        (from, to) = (from.max(*first), to.min(*last));
        if let Some(failed) = self.failed.get(number).filter(|failed| **failed >= from) {
            from = *failed + TICK;
        }
        for result in step.within((from, to)) {
            self.looks += 1;
            if self.looks > query.context.limits().of(Limit::MonitorCombinations) {
                return true;
            }
            if is_used(step, result, query.used.as_ref()) {
                continue;
            }
            let together = if self.binds { joined(bindings, &result.bindings) } else { Some(Bindings::new()) };
            let Some(together) = together else { continue };
            self.chain.push(result);
            let over = self.extend(result.interval.1, &together, query);
            self.chain.pop();
            if over {
                return true;
            }
            if let Some(failed) = self.failed.get_mut(number).filter(|_| !self.binds) {
                *failed = result.interval.0;
            }
        }
        false
    }

    fn complete(&mut self, bindings: &Bindings) -> bool {
        if !self.bound.insert(bindings.plain()) {
            return false;
        }
        let mut all = bindings.clone();
        let mut evidence = EvidenceList::default();
        let mut before: Option<&Satisfaction> = None;
        for (step, result) in self.steps.iter().zip(&self.chain) {
            let start = if step.role == PointRole::End { before } else { None }.unwrap_or(result);
            let interval = (start.interval.0, result.interval.1);
            match (&step.part.kind, step.role) {
                (PartKind::Episode(leaf), PointRole::End) => {
                    evidence = pair_of(leaf, interval).map_or(evidence.clone(), |pair| evidence.joined(&pair.evidence));
                }
                _ => evidence = evidence.joined(&result.evidence),
            }
            if let Some(tag) = step.part.tag.as_ref().filter(|_| step.role != PointRole::Start) {
                all.set(tag.clone(), Value::Interval(interval.0, interval.1));
            }
            before = Some(result);
        }
        let first = self.chain.first().map_or(Time::ZERO, |each| each.interval.0);
        let last = self.chain.last().map_or(first, |each| each.interval.1);
        let recognised_at = self.chain.iter().map(|each| each.recognised_at).max().unwrap_or(last);
        self.found.push(Satisfaction { interval: (first, last), recognised_at, bindings: all, evidence });
        !self.binds
    }
}

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
            let gone = gone_without_successor((composite, &order.limits), number, start, used, &mut query);
            remove(composite, *point, &gone, order.checked.get_mut(number));
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

fn is_used(step: &OrderedPart<'_>, result: &Satisfaction, used: Option<&Used>) -> bool {
    // An episode itself removes the points that belong to a reported result.
    step.role == PointRole::Whole && used.is_some_and(|used| used.contains(step.part.place, result))
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
    (composite, limits): (&Composite, &[(Duration, Duration)]),
    number: usize,
    start: Time,
    used: Option<&Used>,
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    let Some((steps, delay)) = steps(composite, limits, query) else { return Vec::new() };
    let Some(step) = steps.get(number) else { return Vec::new() };
    let next = steps.get(number + 1);
    // With a greatest duration, a later beginning permits ends that an earlier one does not permit.
    if let Some(end) = next.filter(|next| step.role == PointRole::Start && next.gap.most == Duration::MAX) {
        return gone_beginnings(&steps, (number, end), start, used);
    }
    // Chains without a delay at the end are over with their last point.
    if next.is_none() && delay.is_none() {
        return Vec::new();
    }
    let ends = match (number.checked_sub(1), next) {
        (_, Some(next)) if next.gap.most != Duration::MAX => ChainEnds::new(),
        (Some(before), _) => chain_ends(&steps, before, start, used),
        (None, _) => vec![(Bindings::new(), vec![start])],
    };
    let mut first_of: BTreeSet<PlainBindings> = BTreeSet::new();
    let mut useless = |result: &Satisfaction| {
        if is_used(step, result, used) {
            return false;
        }
        let Some(next) = next.filter(|next| next.gap.most != Duration::MAX) else {
            let chains = extended(&ends, step, result);
            let known = chains.iter().filter(|bindings| !first_of.insert(bindings.plain())).count();
            return known > 0 && known == chains.len() && !gains(&steps, number, result, query);
        };
        let span = next.following(result.interval.1);
        let over = next.watermark(&result.bindings, query.now).is_some_and(|watermark| watermark > span.1);
        over && !next.within(span).any(|each| joined(&result.bindings, &each.bindings).is_some())
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().filter(|(place, result)| useless(result) && *place < newest);
    gone.map(|(place, _)| place).collect()
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

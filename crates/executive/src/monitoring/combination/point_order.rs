//! Orders of points (M&I)
//! What: finds the first chain of samples and messages that follow one another, and drops those that no chain needs.
//! Runs: whenever the verdict of a monitor is asked whose whole condition is such an order.
//! Reads: the parts' results, evaluation context.
//! Writes: removes results from the parts of the order.
//! Bound: O(log n) per sample for parts that bind no variable; a sweep over all n kept results each time they have doubled.
//! PDL: `:in-order`, `:delay`.
//! Paper: Table 1, row 11.
//!
//! Points with equal bindings arrive in order of time. Of two points, the earlier one therefore allows every chain that the later one
//! allows, except those that a greatest delay excludes. This decides which points are kept:
//!
//! - a point without a preceding point is dropped once every earlier part has received samples up to the time of a possible one;
//! - a point is dropped if samples of the next part are later than its greatest delay, and no kept point follows it;
//! - without a greatest delay, only the first point with equal bindings is kept.

use crate::expression::EvalContext;
use crate::monitoring::basic::measurement;
use crate::monitoring::basic::time_conditions::delays;
use crate::monitoring::combination::logic::joined;
use crate::monitoring::memory::retention;
use crate::monitoring::reported_results::Used;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Composite, Part, PartKind, PointOrder, Satisfaction};
use apex_model::agent_limits::Limit;
use apex_model::evidence_list::EvidenceList;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeSet;

/// Number of kept results from which on a sweep is worthwhile. It is small, so that short tests also sweep. A sweep is linear in the kept
/// results, and the next one follows when their number has doubled.
const SWEEP_AT_LEAST: usize = 8;

/// Returns bookkeeping for `composite` if it is an order of points: measurements of named or bound objects without `:lateness`, and
/// messages, with delays but without constraints between them. `binds` is true if it contains a pattern variable.
pub(crate) fn create(composite: &Composite, binds: bool, context: &dyn EvalContext) -> Option<Box<PointOrder>> {
    let is_point = |part: &Part| match &part.kind {
        PartKind::Measurement(leaf) => {
            let pattern = &leaf.condition.variable;
            let declared = context.library().state_variables.get(&pattern.attribute);
            let named = leaf.variable.is_some() || matches!(pattern.object, Pattern::Variable(_));
            named && declared.and_then(retention::lateness).is_none()
        }
        PartKind::Event(_) | PartKind::Delay(_) => true,
        _ => false,
    };
    let mut tags = BTreeSet::new();
    let distinct = composite.parts.iter().filter_map(|part| part.tag.as_ref()).all(|tag| tags.insert(tag));
    let ends_in_point = composite.parts.last().is_some_and(|part| !matches!(part.kind, PartKind::Delay(_)));
    let fits = distinct && ends_in_point && composite.constraints.is_empty() && composite.parts.iter().all(is_point);
    fits.then(|| Box::new(PointOrder { sweep_at: SWEEP_AT_LEAST, checked: vec![0; composite.parts.len()], binds }))
}

/// The limits of the time from the end of the part before to a point.
#[derive(Clone, Copy)]
struct Gap {
    least: Duration,
    most: Duration,
}

/// A part of the order that is not a delay.
struct OrderedPart<'a> {
    part: &'a Part,
    /// Its place among the parts.
    index: usize,
    /// Results that the part keeps, in the order in which they became final.
    kept: &'a [Satisfaction],
    /// The earlier ones of all results in order of time.
    first: &'a [Satisfaction],
    /// The later ones, which follow `first`.
    rest: Vec<&'a Satisfaction>,
    gap: Gap,
}

/// Returns the parts except for the delays; `None` if a delay has no value.
fn steps<'a>(composite: &'a Composite, query: &mut VerdictQuery<'_>) -> Option<Vec<OrderedPart<'a>>> {
    let mut steps: Vec<OrderedPart<'a>> = Vec::with_capacity(composite.parts.len());
    let mut delay: Option<Gap> = None;
    for (index, part) in composite.parts.iter().enumerate() {
        let (first, rest) = match &part.kind {
            PartKind::Delay(leaf) => {
                let (least, most) = match delays(leaf, query.context) {
                    Ok(delays) => delays,
                    Err(error) => {
                        query.troubles.add(error);
                        return None;
                    }
                };
                let before = delay.unwrap_or(Gap { least: Duration::ZERO, most: Duration::ZERO });
                delay = Some(Gap { least: before.least + least, most: before.most + most });
                continue;
            }
            PartKind::Measurement(leaf) if leaf.variable.is_some() => {
                let newest = leaf.seen.iter().flat_map(|seen| seen.newest.samples());
                (settled(part), newest.filter_map(|newest| newest.result.as_ref()).collect())
            }
            PartKind::Measurement(leaf) => (&[][..], measurement::ordered(leaf)),
            PartKind::Event(leaf) if leaf.settled.is_sorted_by_key(|each| each.interval.0) => {
                (settled(part), Vec::new())
            }
            PartKind::Event(leaf) => {
                let mut rest: Vec<&Satisfaction> = leaf.settled.iter().collect();
                rest.sort_by_key(|each| each.interval.0);
                (&[][..], rest)
            }
            _ => return None,
        };
        // The first part may come at any time; without a stated delay the next one must come later than the preceding one.
        let least = if steps.is_empty() { Duration(i64::MIN) } else { TICK };
        let gap = delay.take().unwrap_or(Gap { least, most: Duration::MAX });
        steps.push(OrderedPart { part, index, kept: settled(part), first, rest, gap });
    }
    Some(steps)
}

/// Returns the first and last instant at which a point may follow one that ends at `end`.
fn following(end: Time, gap: Gap) -> (Time, Time) {
    (Time(end.0.saturating_add(gap.least.0)), Time(end.0.saturating_add(gap.most.0)))
}

/// Returns the first and last instant at which a point may precede one at `start`.
fn preceding(start: Time, gap: Gap) -> (Time, Time) {
    (Time(start.0.saturating_sub(gap.most.0)), Time(start.0.saturating_sub(gap.least.0)))
}

impl<'a> OrderedPart<'a> {
    /// Results within the closed span, in order.
    fn within(&self, (from, to): (Time, Time)) -> impl Iterator<Item = &Satisfaction> {
        let first = self.first.get(self.first.partition_point(|each| each.interval.0 < from)..).unwrap_or_default();
        let rest = self.rest.get(self.rest.partition_point(|each| each.interval.0 < from)..).unwrap_or_default();
        first.iter().chain(rest.iter().copied()).take_while(move |each| each.interval.0 <= to)
    }

    /// Returns the first and last instant of its results.
    fn extent(&self) -> Option<(Time, Time)> {
        let first = self.first.first().or(self.rest.first().copied())?;
        let last = self.rest.last().copied().or(self.first.last())?;
        Some((first.interval.0, last.interval.0))
    }

    /// Returns an instant before which no further result with these bindings comes; `None` if one may come at any time.
    fn watermark(&self, bindings: &Bindings) -> Option<Time> {
        let PartKind::Measurement(leaf) = &self.part.kind else { return None };
        let newest = &leaf.seen.as_ref()?.newest;
        if leaf.variable.is_some() {
            return newest.samples().map(|sample| sample.at).max();
        }
        let Pattern::Variable(name) = &leaf.condition.variable.object else { return None };
        newest.get(bindings.get(name)?).map(|sample| sample.at)
    }
}

/// Returns the first chain for each set of bindings; the first chain of all if no part binds a variable.
pub(crate) fn results(
    part: &Part,
    composite: &Composite,
    order: &PointOrder,
    query: &mut VerdictQuery<'_>,
) -> Vec<Satisfaction> {
    let Some(steps) = steps(composite, query) else { return Vec::new() };
    let extents: Vec<_> = steps.iter().map(OrderedPart::extent).collect();
    if extents.iter().any(Option::is_none) {
        return Vec::new();
    }
    let extents: Vec<(Time, Time)> = extents.into_iter().flatten().collect();
    let mut search = ChainSearch {
        steps: &steps,
        extents: &extents,
        binds: order.binds,
        looks: 0,
        chain: Vec::new(),
        found: Vec::new(),
        bound: BTreeSet::new(),
    };
    search.extend(part.window.start, &Bindings::new(), query);
    if search.looks > query.context.limits().of(Limit::MonitorCombinations) {
        query.troubles.reached(Limit::MonitorCombinations, query.context, part.place);
    }
    let mut found = search.found;
    found.sort_by_key(|result| result.recognised_at);
    found
}

/// Depth-first search for chains in order of their first points.
struct ChainSearch<'a> {
    steps: &'a [OrderedPart<'a>],
    extents: &'a [(Time, Time)],
    binds: bool,
    looks: u64,
    chain: Vec<&'a Satisfaction>,
    found: Vec<Satisfaction>,
    bound: BTreeSet<Vec<(Symbol, Value)>>,
}

impl<'a> ChainSearch<'a> {
    /// Extends the chain, whose last point ends at `end`. Returns true when the search is over.
    fn extend(&mut self, end: Time, bindings: &Bindings, query: &mut VerdictQuery<'_>) -> bool {
        let number = self.chain.len();
        let (steps, extents) = (self.steps, self.extents);
        let Some(step) = steps.get(number) else { return self.complete(bindings) };
        let (mut from, mut to) = following(end, step.gap);
        // Points that no point of the next part follows are skipped.
        if let (Some(next), Some((first, last))) = (steps.get(number + 1), extents.get(number + 1)) {
            from = from.max(preceding(*first, next.gap).0);
            to = to.min(preceding(*last, next.gap).1);
        }
        for result in step.within((from, to)) {
            self.looks += 1;
            if self.looks > query.context.limits().of(Limit::MonitorCombinations) {
                return true;
            }
            if query.used.as_ref().is_some_and(|used| used.contains(step.part.place, result)) {
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
        }
        false
    }

    fn complete(&mut self, bindings: &Bindings) -> bool {
        if !self.bound.insert(plain(bindings)) {
            return false;
        }
        let mut all = bindings.clone();
        for (step, result) in self.steps.iter().zip(&self.chain) {
            if let Some(tag) = &step.part.tag {
                all.set(tag.clone(), Value::Interval(result.interval.0, result.interval.1));
            }
        }
        let first = self.chain.first().map_or(Time::ZERO, |each| each.interval.0);
        let last = self.chain.last().map_or(first, |each| each.interval.1);
        let recognised_at = self.chain.iter().map(|each| each.recognised_at).max().unwrap_or(last);
        let evidence = self.chain.iter().fold(EvidenceList::default(), |all, each| all.joined(&each.evidence));
        self.found.push(Satisfaction { interval: (first, last), recognised_at, bindings: all, evidence });
        !self.binds
    }
}

/// Returns the bindings without tags.
fn plain(bindings: &Bindings) -> Vec<(Symbol, Value)> {
    let values = bindings.iter().filter(|(_, value)| !matches!(value, Value::Interval(..)));
    values.map(|(name, value)| (name.clone(), value.clone())).collect()
}

/// Drops results that no chain needs any longer. Points that arrived without a preceding point are checked at each call, the others when
/// their number has doubled. `used` are results of chains that were reported already.
pub(crate) fn sweep(part: &mut Part, used: Option<&Used>, context: &dyn EvalContext) {
    let start = part.window.start;
    let PartKind::InOrder(composite) = &mut part.kind else { return };
    let Some(mut order) = composite.order.take() else { return };
    let mut query = VerdictQuery::new(context);
    let kept: usize = composite.parts.iter().map(|part| settled(part).len()).sum();
    let whole = kept >= order.sweep_at;
    if whole {
        order.checked.iter_mut().for_each(|checked| *checked = 0);
    }
    // Each part is swept against the preceding one, which was swept already, then against the following one.
    for number in 0..composite.parts.len() {
        let checked = order.checked.get(number).copied().unwrap_or_default();
        let gone = gone_without_predecessor(composite, (number, checked), start, used, &mut query);
        remove(composite, number, &gone, &mut order);
    }
    if whole {
        for number in (0..composite.parts.len()).rev() {
            let gone = gone_without_successor(composite, number, start, used, &mut query);
            remove(composite, number, &gone, &mut order);
        }
        let kept: usize = composite.parts.iter().map(|part| settled(part).len()).sum();
        order.sweep_at = kept.saturating_mul(2).max(SWEEP_AT_LEAST);
    }
    composite.order = Some(order);
}

fn settled(part: &Part) -> &[Satisfaction] {
    match &part.kind {
        PartKind::Measurement(leaf) => leaf.seen.as_ref().map(|seen| seen.settled.as_slice()).unwrap_or_default(),
        PartKind::Event(leaf) => &leaf.settled,
        _ => &[],
    }
}

fn is_used(step: &OrderedPart<'_>, result: &Satisfaction, used: Option<&Used>) -> bool {
    used.is_some_and(|used| used.contains(step.part.place, result))
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
        let (from, to) = following(start, step.gap);
        return from <= result.interval.0 && result.interval.0 <= to;
    };
    let precedes =
        |each: &Satisfaction| !is_used(before, each, used) && joined(&each.bindings, &result.bindings).is_some();
    before.within(preceding(result.interval.0, step.gap)).any(precedes)
}

/// Returns the places of results of part `index`, from place `from` on, that no earlier point precedes, or that were used.
fn gone_without_predecessor(
    composite: &Composite,
    (index, from): (usize, usize),
    start: Time,
    used: Option<&Used>,
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    // The newest settled result is kept: it shows that the part has held.
    let newest = composite.parts.get(index).map_or(0, |part| settled(part).len()).saturating_sub(1);
    if from >= newest {
        return Vec::new();
    }
    let Some(steps) = steps(composite, query) else { return Vec::new() };
    let Some(number) = steps.iter().position(|step| step.index == index) else { return Vec::new() };
    let Some(step) = steps.get(number) else { return Vec::new() };
    let before = number.checked_sub(1).and_then(|before| steps.get(before));
    let useless = |result: &Satisfaction| {
        let last = preceding(result.interval.0, step.gap).1;
        let may_come =
            before.is_some_and(|before| before.watermark(&result.bindings).is_none_or(|watermark| watermark <= last));
        is_used(step, result, used) || !may_come && !is_preceded(&steps, number, result, start, used)
    };
    let unchecked = step.kept.iter().enumerate().take(newest).skip(from);
    unchecked.filter(|(_, result)| useless(result)).map(|(place, _)| place).collect()
}

/// Returns the indices of results of part `index` that no future point can follow, or that an earlier result represents.
fn gone_without_successor(
    composite: &Composite,
    index: usize,
    start: Time,
    used: Option<&Used>,
    query: &mut VerdictQuery<'_>,
) -> Vec<usize> {
    let Some(steps) = steps(composite, query) else { return Vec::new() };
    let Some(number) = steps.iter().position(|step| step.index == index) else { return Vec::new() };
    let (Some(step), Some(next)) = (steps.get(number), steps.get(number + 1)) else { return Vec::new() };
    let mut first_of: BTreeSet<Vec<(Symbol, Value)>> = BTreeSet::new();
    let mut useless = |result: &Satisfaction| {
        if is_used(step, result, used) {
            return false;
        }
        if next.gap.most == Duration::MAX {
            return is_preceded(&steps, number, result, start, used) && !first_of.insert(plain(&result.bindings));
        }
        let span = following(result.interval.1, next.gap);
        let over = next.watermark(&result.bindings).is_some_and(|watermark| watermark > span.1);
        over && !next.within(span).any(|each| joined(&result.bindings, &each.bindings).is_some())
    };
    let newest = step.kept.len().saturating_sub(1);
    let gone = step.kept.iter().enumerate().filter(|(place, result)| useless(result) && *place < newest);
    gone.map(|(place, _)| place).collect()
}

/// Removes the results at the sorted indices `gone`, and records that the remaining ones were checked.
fn remove(composite: &mut Composite, index: usize, gone: &[usize], order: &mut PointOrder) {
    let Some(part) = composite.parts.get_mut(index) else { return };
    let list = match &mut part.kind {
        PartKind::Measurement(leaf) => leaf.seen.as_mut().map(|seen| &mut seen.settled),
        PartKind::Event(leaf) => Some(&mut leaf.settled),
        _ => None,
    };
    let Some(list) = list else { return };
    if !gone.is_empty() {
        let (mut place, mut next) = (0, gone.iter().copied().peekable());
        list.retain(|_| {
            place += 1;
            next.next_if_eq(&(place - 1)).is_none()
        });
    }
    if let Some(checked) = order.checked.get_mut(index) {
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

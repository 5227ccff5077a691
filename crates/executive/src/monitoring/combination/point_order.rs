//! Orders of points (M&I)
//! What: finds the first chain of samples and messages that follow one another, and drops those that no chain needs.
//! Runs: whenever the verdict of a monitor is requested whose whole condition is such an order.
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
use crate::monitoring::combination::order_constraints;
use crate::monitoring::combination::point_steps::{OrderedPart, PointRole, is_used, span_of, steps};
use crate::monitoring::combination::point_sweep::SWEEP_AT_LEAST;
use crate::monitoring::episodes::episode::durations;
use crate::monitoring::episodes::run_update::pair_of;
use crate::monitoring::memory::retention;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::{Bindings, PlainBindings, joined};
use crate::state::monitors::monitor::{Composite, PairPoints, Part, PartKind, PointLimit, PointOrder, Satisfaction};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::evidence_list::EvidenceList;
use apex_model::pattern::Pattern;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeSet;

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
    let (limits, far) = order_constraints::limits(composite).filter(|_| fits)?;
    // The first beginning of a run does not represent later ones where limits reach farther.
    let runs = composite.parts.iter().any(|part| matches!(part.kind, PartKind::Episode(_)));
    let order = PointOrder { sweep_at: SWEEP_AT_LEAST, checked: vec![0; limits.len()], binds, limits, far };
    (order.far.is_empty() || !runs).then(|| Box::new(order))
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
        order,
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
    order: &'a PointOrder,
    looks: u64,
    /// For each step, the latest instant of a point that no chain to the end contains, if no part binds a variable and no limit reaches
    /// over the step. Points that are tried later are not earlier than those tried before, because the spans in which points may follow
    /// move with the preceding points.
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
        for limit in self.order.far.iter().filter(|limit| limit.second == number) {
            let Some(before) = self.chain.get(limit.first) else { continue };
            let span = span_of(limit, before.interval.0);
            (from, to) = (from.max(span.0), to.min(span.1));
        }
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
            let together = if self.order.binds { joined(bindings, &result.bindings) } else { Some(Bindings::new()) };
            let Some(together) = together else { continue };
            self.chain.push(result);
            let over = self.extend(result.interval.1, &together, query);
            self.chain.pop();
            if over {
                return true;
            }
            let remembers = !self.order.binds && !reaches_over(&self.order.far, number);
            if let Some(failed) = self.failed.get_mut(number).filter(|_| remembers) {
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
        !self.order.binds
    }
}

/// Returns true if a limit between a point before this step and one behind it exists.
fn reaches_over(far: &[PointLimit], number: usize) -> bool {
    far.iter().any(|limit| limit.first < number && number < limit.second)
}

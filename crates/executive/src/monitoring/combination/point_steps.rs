//! Steps of point orders (M&I)
//! What: lists the parts of an order of points with their results and the times allowed between them.
//! Runs: with every search for chains and every sweep.
//! Reads: the parts' results, evaluation context.
//! Writes: nothing.
//! Bound: O(parts); O(n log n) in the n results of a part whose results are not in order of time.
//! PDL: `:in-order`, `:delay`.
//! Paper: Table 1, row 11.

use crate::monitoring::basic::measurement;
use crate::monitoring::basic::time_conditions::delays;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Composite, Part, PartKind, Satisfaction};
use apex_model::pattern::Pattern;
use apex_model::time::{Duration, Time};

/// The limits of the time from the end of the part before to a point.
#[derive(Clone, Copy)]
pub(crate) struct Gap {
    pub(crate) least: Duration,
    pub(crate) most: Duration,
}

/// A part of the order that is not a delay.
pub(crate) struct OrderedPart<'a> {
    pub(crate) part: &'a Part,
    /// Its place among the parts.
    pub(crate) index: usize,
    /// Results that the part keeps, in the order in which they became final.
    pub(crate) kept: &'a [Satisfaction],
    /// All results in order of time: the earlier ones.
    first: &'a [Satisfaction],
    /// The later ones, which continue `first`.
    rest: Vec<&'a Satisfaction>,
    pub(crate) gap: Gap,
}

/// Returns the parts except for the delays, and the least delay after the last of them; `None` if a delay has no value.
pub(crate) fn steps<'a>(
    composite: &'a Composite,
    query: &mut VerdictQuery<'_>,
) -> Option<(Vec<OrderedPart<'a>>, Option<Duration>)> {
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
    Some((steps, delay.map(|after| after.least)))
}

/// Returns the first and last instant at which a point may follow one that ends at `end`.
pub(crate) fn following(end: Time, gap: Gap) -> (Time, Time) {
    (Time(end.0.saturating_add(gap.least.0)), Time(end.0.saturating_add(gap.most.0)))
}

/// Returns the first and last instant at which a point may precede one at `start`.
pub(crate) fn preceding(start: Time, gap: Gap) -> (Time, Time) {
    (Time(start.0.saturating_sub(gap.most.0)), Time(start.0.saturating_sub(gap.least.0)))
}

impl<'a> OrderedPart<'a> {
    /// Returns the results within the closed span, in order.
    pub(crate) fn within(&self, (from, to): (Time, Time)) -> impl Iterator<Item = &Satisfaction> {
        let first = self.first.get(self.first.partition_point(|each| each.interval.0 < from)..).unwrap_or_default();
        let rest = self.rest.get(self.rest.partition_point(|each| each.interval.0 < from)..).unwrap_or_default();
        first.iter().chain(rest.iter().copied()).take_while(move |each| each.interval.0 <= to)
    }

    /// Returns the first and last instant of its results.
    pub(crate) fn extent(&self) -> Option<(Time, Time)> {
        let first = self.first.first().or(self.rest.first().copied())?;
        let last = self.rest.last().copied().or(self.first.last())?;
        Some((first.interval.0, last.interval.0))
    }

    /// Returns an instant before which no further result with these bindings comes; `None` if one may come at any time.
    pub(crate) fn watermark(&self, bindings: &Bindings) -> Option<Time> {
        let PartKind::Measurement(leaf) = &self.part.kind else { return None };
        let newest = &leaf.seen.as_ref()?.newest;
        if leaf.variable.is_some() {
            return newest.samples().map(|sample| sample.at).max();
        }
        let Pattern::Variable(name) = &leaf.condition.variable.object else { return None };
        newest.get(bindings.get(name)?).map(|sample| sample.at)
    }
}

/// Returns the settled results of a part.
pub(crate) fn settled(part: &Part) -> &[Satisfaction] {
    match &part.kind {
        PartKind::Measurement(leaf) => leaf.seen.as_ref().map(|seen| seen.settled.as_slice()).unwrap_or_default(),
        PartKind::Event(leaf) => &leaf.settled,
        _ => &[],
    }
}

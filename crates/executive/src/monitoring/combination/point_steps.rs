//! Steps of point orders (M&I)
//! What: lists the points of an order with their results and the times allowed between them; an episode is two of them, the first and the
//! last sample of its interval, which lie in one run.
//! Runs: with every search for chains and every sweep.
//! Reads: the parts' results, evaluation context.
//! Writes: nothing.
//! Bound: O(parts); O(n log n) in the n results of a part whose results are not in order of time.
//! PDL: `:in-order`, `:delay`, `:constraint`.
//! Paper: Table 1, row 11.

use crate::monitoring::basic::measurement;
use crate::monitoring::basic::time_conditions::delays;
use crate::monitoring::reported_results::Used;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{Composite, Part, PartKind, PointLimit, Satisfaction};
use apex_model::pattern::Pattern;
use apex_model::time::{Duration, Time};

/// The limits of the time from the end of the part before to a point.
#[derive(Clone, Copy)]
pub(crate) struct Gap {
    pub(crate) least: Duration,
    pub(crate) most: Duration,
}

/// Points of a part.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum PointRole {
    /// The results of a part whose results are points.
    Whole,
    /// The first samples of the intervals of an episode.
    Start,
    /// The last samples of these intervals.
    End,
}

/// A part of the order that is not a delay, or one end of its intervals.
pub(crate) struct OrderedPart<'a> {
    pub(crate) part: &'a Part,
    pub(crate) role: PointRole,
    /// Results that the part keeps, in the order in which they became final.
    pub(crate) kept: &'a [Satisfaction],
    /// All results in order of time: the earlier ones.
    first: &'a [Satisfaction],
    /// The later ones, which continue `first`.
    rest: Vec<&'a Satisfaction>,
    pub(crate) gap: Gap,
}

/// Returns the parts except for the delays, and the least delay after the last of them; `None` if a delay has no value. `limits` are those
/// of [`PointOrder::limits`].
pub(crate) fn steps<'a>(
    composite: &'a Composite,
    limits: &[(Duration, Duration)],
    query: &mut VerdictQuery<'_>,
) -> Option<(Vec<OrderedPart<'a>>, Option<Duration>)> {
    let mut steps: Vec<OrderedPart<'a>> = Vec::with_capacity(composite.parts.len());
    let mut delay: Option<Gap> = None;
    // The first part may come at any time; without a stated delay the next one must come later than the preceding one.
    let gap_before = |delay: &mut Option<Gap>, first: bool| {
        let least = if first { Duration(i64::MIN) } else { TICK };
        delay.take().unwrap_or(Gap { least, most: Duration::MAX })
    };
    for part in &composite.parts {
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
                (settled(part, PointRole::Whole), newest.filter_map(|newest| newest.result.as_ref()).collect())
            }
            PartKind::Measurement(leaf) => (&[][..], measurement::ordered(leaf)),
            PartKind::Event(leaf) if leaf.settled.is_sorted_by_key(|each| each.interval.0) => {
                (settled(part, PointRole::Whole), Vec::new())
            }
            PartKind::Event(leaf) => {
                let mut rest: Vec<&Satisfaction> = leaf.settled.iter().collect();
                rest.sort_by_key(|each| each.interval.0);
                (&[][..], rest)
            }
            PartKind::Episode(leaf) => {
                let points = leaf.points.as_ref()?;
                let newest = points.newest.as_ref().and_then(|newest| newest.start.as_ref());
                let (first, rest) = (points.starts.as_slice(), newest.into_iter().collect());
                let gap = gap_before(&mut delay, steps.is_empty());
                steps.push(OrderedPart { part, role: PointRole::Start, kept: first, first, rest, gap });
                let (first, rest) = (points.ends.as_slice(), points.newest_end().into_iter().collect());
                let (least, most) = points.durations;
                let gap = Gap { least, most };
                steps.push(OrderedPart { part, role: PointRole::End, kept: first, first, rest, gap });
                continue;
            }
            _ => return None,
        };
        let gap = gap_before(&mut delay, steps.is_empty());
        steps.push(OrderedPart {
            part,
            role: PointRole::Whole,
            kept: settled(part, PointRole::Whole),
            first,
            rest,
            gap,
        });
    }
    for (step, (least, most)) in steps.iter_mut().zip(limits) {
        step.gap = Gap { least: step.gap.least.max(*least), most: step.gap.most.min(*most) };
    }
    Some((steps, delay.map(|after| after.least)))
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
    /// Returns the first and last instant at which a point of this part may follow one of the preceding part at `end`.
    pub(crate) fn following(&self, end: Time) -> (Time, Time) {
        let (from, to) = following(end, self.gap);
        (from, self.run_of(end).map_or(to, |(_, last)| to.min(last)))
    }

    /// Returns the first and last instant at which a point of the preceding part may precede one of this part at `start`.
    pub(crate) fn preceding(&self, start: Time) -> (Time, Time) {
        let (from, to) = preceding(start, self.gap);
        (self.run_of(start).map_or(from, |(first, _)| from.max(first)), to)
    }

    /// Returns the run that contains the instant, if the point is the end of an interval, which begins in the same run.
    fn run_of(&self, at: Time) -> Option<(Time, Time)> {
        match (&self.part.kind, self.role) {
            (PartKind::Episode(leaf), PointRole::End) => leaf.points.as_ref().map(|points| points.run_of(at)),
            _ => None,
        }
    }

    /// Returns true if the interval that begins with a point of this part at `start` ends with no kept point and with none to come.
    pub(crate) fn ends_never(&self, end: &OrderedPart<'_>, start: Time) -> bool {
        let PartKind::Episode(leaf) = &self.part.kind else { return false };
        let over = leaf.points.as_ref().is_some_and(|points| points.is_over(points.run_of(start).1));
        over && end.within(end.following(start)).next().is_none()
    }

    /// Returns the results within the closed span, in order.
    pub(crate) fn within(&self, (from, to): (Time, Time)) -> impl Iterator<Item = &Satisfaction> {
        let first = self.first.get(self.first.partition_point(|each| each.interval.0 < from)..).unwrap_or_default();
        let rest = self.rest.get(self.rest.partition_point(|each| each.interval.0 < from)..).unwrap_or_default();
        first.iter().chain(rest.iter().copied()).take_while(move |each| each.interval.0 <= to)
    }

    /// Returns the first and last instant of its results within the closed span.
    pub(crate) fn extent(&self, (from, to): (Time, Time)) -> Option<(Time, Time)> {
        let first_of = |list: &[Satisfaction]| list.partition_point(|each| each.interval.0 < from);
        let after = |list: &[Satisfaction]| list.partition_point(|each| each.interval.0 <= to);
        let first = self.first.get(first_of(self.first)..after(self.first)).unwrap_or_default();
        let rest_from = self.rest.partition_point(|each| each.interval.0 < from);
        let rest =
            self.rest.get(rest_from..self.rest.partition_point(|each| each.interval.0 <= to)).unwrap_or_default();
        let earliest = first.first().or(rest.first().copied())?;
        let latest = rest.last().copied().or(first.last())?;
        Some((earliest.interval.0, latest.interval.0))
    }

    /// Returns an instant before which no further result with these bindings comes; `None` if one may come at any time. Messages come in
    /// order of time.
    pub(crate) fn watermark(&self, bindings: &Bindings, now: Time) -> Option<Time> {
        watermark(self.part, bindings, now)
    }
}

/// Returns an instant before which no further result of the part with these bindings comes; `None` if one may come at any time.
pub(crate) fn watermark(part: &Part, bindings: &Bindings, now: Time) -> Option<Time> {
    match &part.kind {
        PartKind::Event(_) => Some(now),
        PartKind::Episode(leaf) => leaf.runs.values().map(|run| run.newest.at).max(),
        PartKind::Measurement(leaf) => {
            let newest = &leaf.seen.as_ref()?.newest;
            if leaf.variable.is_some() {
                return newest.samples().map(|sample| sample.at).max();
            }
            let Pattern::Variable(name) = &leaf.condition.variable.object else { return None };
            newest.get(bindings.get(name)?).map(|sample| sample.at)
        }
        _ => None,
    }
}

/// Returns the number of settled points of a part.
pub(crate) fn count(part: &Part) -> usize {
    match &part.kind {
        PartKind::Episode(leaf) => leaf.points.as_ref().map_or(0, |points| points.starts.len() + points.ends.len()),
        _ => settled(part, PointRole::Whole).len(),
    }
}

/// Returns the points of the parts of an order, in order: the place of the part and the role.
pub(crate) fn points(composite: &Composite) -> Vec<(usize, PointRole)> {
    let roles = |part: &Part| match part.kind {
        PartKind::Delay(_) => &[][..],
        PartKind::Episode(_) => &[PointRole::Start, PointRole::End][..],
        _ => &[PointRole::Whole][..],
    };
    let parts = composite.parts.iter().enumerate();
    parts.flat_map(|(index, part)| roles(part).iter().map(move |role| (index, *role))).collect()
}

/// Returns the settled points of a part.
pub(crate) fn settled(part: &Part, role: PointRole) -> &[Satisfaction] {
    match &part.kind {
        PartKind::Measurement(leaf) => leaf.seen.as_ref().map(|seen| seen.settled.as_slice()).unwrap_or_default(),
        PartKind::Event(leaf) => &leaf.settled,
        PartKind::Episode(leaf) => {
            let Some(points) = &leaf.points else { return &[] };
            if role == PointRole::Start { &points.starts } else { &points.ends }
        }
        _ => &[],
    }
}

/// Returns the settled points of a part, mutably.
pub(crate) fn settled_mut(part: &mut Part, role: PointRole) -> Option<&mut Vec<Satisfaction>> {
    match &mut part.kind {
        PartKind::Measurement(leaf) => leaf.seen.as_mut().map(|seen| &mut seen.settled),
        PartKind::Event(leaf) => Some(&mut leaf.settled),
        PartKind::Episode(leaf) => {
            let points = leaf.points.as_mut()?;
            Some(if role == PointRole::Start { &mut points.starts } else { &mut points.ends })
        }
        _ => None,
    }
}

/// Returns true if the result belongs to a reported chain. An episode itself removes such points.
pub(crate) fn is_used(step: &OrderedPart<'_>, result: &Satisfaction, used: Option<&Used>) -> bool {
    step.role == PointRole::Whole && used.is_some_and(|used| used.contains(step.part.place, result))
}

/// Returns the first and last instant that the limit permits for its second point, given its first one.
pub(crate) fn span_of(limit: &PointLimit, first: Time) -> (Time, Time) {
    (Time(first.0.saturating_add(limit.least.0)), Time(first.0.saturating_add(limit.most.0)))
}

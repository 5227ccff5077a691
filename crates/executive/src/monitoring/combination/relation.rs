//! Relations of intervals (M&I)
//! What: decides whether two intervals are in a relation, are not, or depend on the end of an open run.
//! Runs: for pairs of results of related parts.
//! Reads: nothing.
//! Writes: nothing.
//! Bound: O(1).
//! PDL: Allen relations, `:tolerance`.
//! Paper: Table 1 row 11, the full set of Allen predicates.

use apex_model::condition::AllenRelation;
use apex_model::time::{Duration, Time};

/// An end point of an interval, as far as known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum EndPoint {
    /// Known: this instant.
    Known(Time),
    /// The end of an open run: the first instant if no sample continues it, otherwise later than the second.
    Growing(Time, Time),
    /// End point of a future result: this instant or later.
    Coming(Time),
}

/// An interval with known or open end points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KnownInterval {
    pub(crate) start: EndPoint,
    pub(crate) end: EndPoint,
}

impl KnownInterval {
    /// Returns the interval of a result that cannot grow.
    pub(crate) fn of((start, end): (Time, Time)) -> KnownInterval {
        KnownInterval { start: EndPoint::Known(start), end: EndPoint::Known(end) }
    }

    /// Returns the interval of an open run, which samples after `after` may continue.
    pub(crate) fn growing((start, end): (Time, Time), after: Time) -> KnownInterval {
        KnownInterval { start: EndPoint::Known(start), end: EndPoint::Growing(end, after) }
    }

    /// Returns the interval of any future result: it begins at `from` or later.
    pub(crate) fn coming(from: Time) -> KnownInterval {
        KnownInterval { start: EndPoint::Coming(from), end: EndPoint::Coming(from) }
    }
}

/// Knowledge of a relation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Decision {
    /// The relation can no longer hold.
    Fails,
    /// Decided by later inputs.
    Open,
    /// The relation holds, regardless of later input.
    Holds,
}

/// A comparison of two end points that a relation requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointComparison {
    /// The first is earlier.
    Earlier,
    /// The end points are equal.
    Same,
}

/// An end point of the first or the second interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edge {
    /// Start of the first.
    FirstStart,
    /// End of the first.
    FirstEnd,
    /// Start of the second.
    SecondStart,
    /// End of the second.
    SecondEnd,
}

/// Returns the comparisons that define a relation; all must hold. An interval may be a point, so a point that meets an interval also
/// starts it.
pub(crate) fn links(relation: AllenRelation) -> &'static [(Edge, PointComparison, Edge)] {
    use Edge::{FirstEnd, FirstStart, SecondEnd, SecondStart};
    use PointComparison::{Earlier, Same};
    match relation {
        AllenRelation::Before => &[(FirstEnd, Earlier, SecondStart)],
        AllenRelation::After => &[(SecondEnd, Earlier, FirstStart)],
        AllenRelation::Meets => &[(FirstEnd, Same, SecondStart)],
        AllenRelation::MetBy => &[(SecondEnd, Same, FirstStart)],
        AllenRelation::Overlaps => {
            &[(FirstStart, Earlier, SecondStart), (SecondStart, Earlier, FirstEnd), (FirstEnd, Earlier, SecondEnd)]
        }
        AllenRelation::OverlappedBy => {
            &[(SecondStart, Earlier, FirstStart), (FirstStart, Earlier, SecondEnd), (SecondEnd, Earlier, FirstEnd)]
        }
        AllenRelation::Starts => &[(FirstStart, Same, SecondStart), (FirstEnd, Earlier, SecondEnd)],
        AllenRelation::StartedBy => &[(FirstStart, Same, SecondStart), (SecondEnd, Earlier, FirstEnd)],
        AllenRelation::Finishes => &[(SecondStart, Earlier, FirstStart), (FirstEnd, Same, SecondEnd)],
        AllenRelation::FinishedBy => &[(FirstStart, Earlier, SecondStart), (FirstEnd, Same, SecondEnd)],
        AllenRelation::During => &[(SecondStart, Earlier, FirstStart), (FirstEnd, Earlier, SecondEnd)],
        AllenRelation::Contains => &[(FirstStart, Earlier, SecondStart), (SecondEnd, Earlier, FirstEnd)],
        AllenRelation::Cotemporal => &[(FirstStart, Same, SecondStart), (FirstEnd, Same, SecondEnd)],
    }
}

/// Decides whether `first` is in `relation` to `second`.
pub(crate) fn decide(
    relation: AllenRelation,
    tolerance: Duration,
    first: KnownInterval,
    second: KnownInterval,
) -> Decision {
    let all = links(relation).iter().map(|link| decide_link(*link, tolerance, first, second));
    all.min().unwrap_or(Decision::Holds)
}

/// Decides whether one of the comparisons holds.
pub(crate) fn decide_link(
    (left, link, right): (Edge, PointComparison, Edge),
    tolerance: Duration,
    first: KnownInterval,
    second: KnownInterval,
) -> Decision {
    let point = |edge| match edge {
        Edge::FirstStart => first.start,
        Edge::FirstEnd => first.end,
        Edge::SecondStart => second.start,
        Edge::SecondEnd => second.end,
    };
    match link {
        PointComparison::Earlier => earlier(point(left), point(right), tolerance),
        PointComparison::Same => same(point(left), point(right), tolerance),
    }
}

/// Returns the earliest and the latest instant of a point; `None` if the latest one has no bound.
fn bounds(point: EndPoint) -> (Time, Option<Time>) {
    match point {
        EndPoint::Known(at) => (at, Some(at)),
        EndPoint::Growing(at, _) | EndPoint::Coming(at) => (at, None),
    }
}

/// Decides whether `a` is earlier than `b` by more than the tolerance.
fn earlier(left: EndPoint, right: EndPoint, tolerance: Duration) -> Decision {
    let ((left_least, left_most), (right_least, right_most)) = (bounds(left), bounds(right));
    if left_most.is_some_and(|most| right_least - most > tolerance) {
        Decision::Holds
    } else if right_most.is_none_or(|most| most - left_least > tolerance) {
        Decision::Open
    } else {
        Decision::Fails
    }
}

/// Decides whether both differ by at most the tolerance.
fn same(left: EndPoint, right: EndPoint, tolerance: Duration) -> Decision {
    let near = |a: Time, b: Time| (a - b).0.saturating_abs() <= tolerance.0;
    let (known, other) = match (left, right) {
        (EndPoint::Known(a), EndPoint::Known(b)) => return if near(a, b) { Decision::Holds } else { Decision::Fails },
        (EndPoint::Known(known), other) | (other, EndPoint::Known(known)) => (known, other),
        _ => return Decision::Open,
    };
    let possible = match other {
        EndPoint::Growing(at, after) => near(at, known) || known + tolerance > after,
        EndPoint::Coming(from) | EndPoint::Known(from) => known + tolerance >= from,
    };
    if possible { Decision::Open } else { Decision::Fails }
}

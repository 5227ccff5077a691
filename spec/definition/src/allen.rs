//! Allen's thirteen relations between intervals with end points that may still move (rule 15).

use crate::condition::{Allen, Span, Time};
use crate::ways::Way;

/// An end point: exactly at an instant, or at that instant or later.
#[derive(Clone, Copy)]
struct Point {
    at: Time,
    moves: bool,
}

/// Returns true if the relation holds between the two, regardless of later arrivals.
pub(crate) fn decided(relation: Allen, first: &Way, second: &Way, tolerance: Span) -> bool {
    let (Some(first_hull), Some(second_hull)) = (first.hull, second.hull) else { return false };
    let ends = |way: &Way, (start, end)| (Point { at: start, moves: false }, Point { at: end, moves: way.open });
    let (a, b) = (ends(first, first_hull), ends(second, second_hull));
    let less = |left: Point, right: Point| !left.moves && left.at < right.at - tolerance;
    let same = |left: Point, right: Point| !left.moves && !right.moves && (left.at - right.at).abs() <= tolerance;
    let relation_of = |a: (Point, Point), b: (Point, Point)| match relation {
        Allen::Before | Allen::After => less(a.1, b.0),
        Allen::Meets | Allen::MetBy => same(a.1, b.0),
        Allen::Overlaps | Allen::OverlappedBy => less(a.0, b.0) && less(b.0, a.1) && less(a.1, b.1),
        Allen::Starts | Allen::StartedBy => same(a.0, b.0) && less(a.1, b.1),
        Allen::Finishes | Allen::FinishedBy => less(b.0, a.0) && same(a.1, b.1),
        Allen::During | Allen::Contains => less(b.0, a.0) && less(a.1, b.1),
        Allen::Cotemporal => same(a.0, b.0) && same(a.1, b.1),
    };
    match relation {
        Allen::After | Allen::MetBy | Allen::OverlappedBy | Allen::StartedBy | Allen::FinishedBy | Allen::Contains => {
            relation_of(b, a)
        }
        _ => relation_of(a, b),
    }
}

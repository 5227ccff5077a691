//! Sliding window (M&I)
//! What: holds the numbers of the latest interval of fixed length, with their moments, as samples enter and leave.
//! Runs: from statistics, on every sample.
//! Reads: nothing.
//! Writes: the window.
//! Bound: amortised O(1) a sample: each is moved between the stacks once. No sum is reduced by subtraction, so no digits are lost.
//! PDL: `:stats` and `:trend` with a `:duration` and no `:value`.
//! Paper: Table 1, row 8.

use crate::state::monitors::moments::{HeldMoments, Moments};
use crate::state::monitors::numbers::{Point, SlidingWindow};
use apex_model::time::{Duration, Time};

/// Content of a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Contents {
    pub(crate) moments: Moments,
    pub(crate) held: HeldMoments,
    /// Numbers that are in the stacks and before the window's start.
    pub(crate) left: Vec<f64>,
    /// The instant of the oldest sample in the window.
    pub(crate) first: Option<Time>,
    /// True if the value of that sample satisfies the constraint on the first value.
    pub(crate) first_holds: bool,
}

/// Adds a sample that is younger than all others.
pub(crate) fn push(window: &mut SlidingWindow, point: Point) {
    add(&mut window.back_moments, &mut window.back_held, point);
    window.back.push(point);
}

fn add(moments: &mut Moments, held: &mut HeldMoments, point: Point) {
    let Some(number) = point.number else { return };
    moments.add(point.at, number);
    held.add(number, point.held);
}

/// Drops the numbers before `start`; `leaves` receives each. Weights over time are kept if `holds` is true.
pub(crate) fn drop_before(window: &mut SlidingWindow, start: Time, holds: bool, mut leaves: impl FnMut(f64)) {
    loop {
        if window.front.is_empty() {
            if window.back.first().is_none_or(|oldest| oldest.at >= start) {
                return;
            }
            turn_over(window, holds);
        }
        while window.front.last().is_some_and(|(oldest, _)| oldest.at < start) {
            window.front_held.pop();
            if let Some((point, _)) = window.front.pop() {
                point.number.into_iter().for_each(&mut leaves);
                window.edge = Some(point);
            }
        }
        if !window.front.is_empty() {
            return;
        }
    }
}

/// Moves the younger stack onto the older one, so that the oldest number is on top.
fn turn_over(window: &mut SlidingWindow, holds: bool) {
    let mut moments = Moments::default();
    let mut held = HeldMoments::default();
    for point in std::mem::take(&mut window.back).into_iter().rev() {
        add(&mut moments, &mut held, point);
        window.front.push((point, moments));
        if holds {
            window.front_held.push(held);
        }
    }
    window.back_moments = Moments::default();
    window.back_held = HeldMoments::default();
}

/// Returns the content of the window from `start` on. It changes nothing, so that the number of calls does not matter.
pub(crate) fn contents(window: &SlidingWindow, start: Time) -> Contents {
    let mut contents = Contents::default();
    let mut edge = window.edge;
    let mut first: Option<Point> = None;
    let gone = window.front.iter().rev().take_while(|(point, _)| point.at < start);
    let mut left = 0;
    for (point, _) in gone {
        left += 1;
        contents.left.extend(point.number);
        edge = Some(*point);
    }
    match window.front.len().checked_sub(left + 1).and_then(|index| Some((index, window.front.get(index)?))) {
        Some((index, (point, moments))) => {
            first = Some(*point);
            contents.moments = *moments;
            contents.held = window.front_held.get(index).copied().unwrap_or_default();
            contents.moments.merge(&window.back_moments);
            contents.held.merge(&window.back_held);
        }
        None if window.back.first().is_some_and(|oldest| oldest.at < start) => {
            for point in &window.back {
                if point.at < start {
                    contents.left.extend(point.number);
                    edge = Some(*point);
                } else {
                    first = first.or(Some(*point));
                    add(&mut contents.moments, &mut contents.held, *point);
                }
            }
        }
        None => {
            first = window.back.first().copied();
            contents.moments = window.back_moments;
            contents.held = window.back_held;
        }
    }
    // The number before the window is valid up to the first one in it, or up to the newest sample.
    if let Some(Point { at, number: Some(number), held, .. }) = edge {
        let until = at + held;
        let from = start.max(at);
        contents.held.add(number, first.map_or(until, |first| first.at.min(until)) - from);
    }
    contents.first = first.map(|first| first.at);
    contents.first_holds = first.is_some_and(|first| first.may_be_first);
    contents
}

/// Returns the instants at which numbers leave a window of this length, after one instant and up to another, at most `count`.
pub(crate) fn leaving(
    window: &SlidingWindow,
    length: Duration,
    (after, until): (Time, Time),
    count: usize,
) -> impl Iterator<Item = Time> {
    let points = window.front.iter().rev().map(|(point, _)| point).chain(&window.back);
    let instants = points.map(move |point| point.at + length + Duration(1));
    instants.skip_while(move |at| *at <= after).take_while(move |at| *at <= until).take(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_window_holds_what_lies_in_it(steps in proptest::collection::vec((1..6_i64, -50..50_i32), 1..80), length in 0..20_i64, ahead in 0..25_i64) {
            let mut window = SlidingWindow::default();
            let mut all: Vec<Point> = Vec::new();
            let mut at = 0;
            for (pause, number) in steps {
                at += pause;
                if let Some(last) = all.last_mut() {
                    last.held = Time(at) - last.at;
                    push(&mut window, *last);
                    drop_before(&mut window, Time(at - length), true, |_| {});
                }
                all.push(Point { at: Time(at), number: (number % 7 != 0).then_some(f64::from(number)), held: Duration::ZERO, may_be_first: true });
                for start in [at - length, at - length + ahead] {
                    let inside: Vec<Point> = all[..all.len() - 1].iter().copied().filter(|point| point.at.0 >= start).collect();
                    let found = contents(&window, Time(start));
                    prop_assert_eq!(found.first, inside.first().map(|point| point.at));
                    let mut plain = Moments::default();
                    inside.iter().for_each(|point| point.number.into_iter().for_each(|number| plain.add(point.at, number)));
                    prop_assert_eq!(found.moments.count(), plain.count());
                    let near = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(a == b, |(a, b)| (a - b).abs() <= 1e-9 * b.abs().max(1.0));
                    prop_assert!(near(found.moments.variance(), plain.variance()));
                    let slope = |moments: &Moments| moments.slope_per_s().map(|slope| slope / 1e9);
                    prop_assert!(near(slope(&found.moments), slope(&plain)));
                    let mut held = HeldMoments::default();
                    for point in &all[..all.len() - 1] {
                        let end = point.at + point.held;
                        point.number.into_iter().for_each(|number| held.add(number, end.min(Time(at)) - point.at.max(Time(start))));
                    }
                    prop_assert!(near(found.held.mean(), held.mean()), "{:?} {:?} of {:?} from {}", found.held, held, all, start);
                }
            }
        }
    }
}

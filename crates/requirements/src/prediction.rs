//! Time to violation along a route.

use crate::route::{Route, RouteState};

/// Least step of the search, in seconds: a violation that is shorter may be missed.
pub const STEP_S_MIN: f64 = 1.0;
/// Tolerance in seconds of the instant that is found.
pub const EXACT_S: f64 = 0.01;

/// The first violation along a route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Violation {
    /// Seconds from now; 0 if the requirement is violated now.
    pub after_s: f64,
    /// State on the route.
    pub state: RouteState,
}

/// The part of a route in which a requirement counts, in seconds from now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteSpan {
    /// First instant.
    pub from_s: f64,
    /// Last instant.
    pub until_s: f64,
}

/// Returns the first instant in `span` at which `margin` is negative; `None` if there is none before the span or the route ends.
///
/// `change_per_s` bounds how fast the margin can fall along the route: the search advances by the time in which the margin cannot become
/// negative, and by at least [`STEP_S_MIN`]. For a distance in metres the bound is [`Route::speed_mps_max`]. With an infinite bound the
/// steps are [`STEP_S_MIN`].
pub fn first_violation(
    route: &Route,
    span: RouteSpan,
    change_per_s: f64,
    mut margin: impl FnMut(&RouteState) -> f64,
) -> Option<Violation> {
    let until_s = span.until_s.min(route.end_s());
    let mut kept_s = None;
    let mut at_s = span.from_s.max(0.0);
    loop {
        if at_s > until_s {
            return None;
        }
        let state = route.at(at_s)?;
        let found = margin(&state);
        if found < 0.0 {
            return Some(bisect(route, kept_s, state, &mut margin));
        }
        if at_s >= until_s {
            return None;
        }
        kept_s = Some(at_s);
        let lasts_s = if change_per_s > 0.0 { found / change_per_s } else { f64::INFINITY };
        at_s = (at_s + lasts_s.max(STEP_S_MIN)).min(until_s);
    }
}

/// Returns the instant of the change of sign between `kept_s` and the violated `state`.
fn bisect(
    route: &Route,
    kept_s: Option<f64>,
    mut state: RouteState,
    margin: &mut impl FnMut(&RouteState) -> f64,
) -> Violation {
    let Some(mut kept_s) = kept_s else { return Violation { after_s: state.after_s, state } };
    while state.after_s - kept_s > EXACT_S {
        let Some(middle) = route.at(0.5 * (kept_s + state.after_s)) else { break };
        if margin(&middle) < 0.0 {
            state = middle;
        } else {
            kept_s = middle.after_s;
        }
    }
    Violation { after_s: state.after_s, state }
}

/// Returns the part of a route in which the vehicle can meet something that is active from `from_s` to `until_s`. The part begins now, at
/// `now_s` of mission time, or later. The active time is extended by `before_s` at both ends, and by the spread of arrival times that a
/// relative speed error `speed_error` (less than 1) causes. `None` if the vehicle cannot meet it between now and `look_ahead_s`.
pub fn active_span(
    (from_s, until_s): (f64, f64),
    now_s: f64,
    before_s: f64,
    speed_error: f64,
    look_ahead_s: f64,
) -> Option<RouteSpan> {
    let begin_s = (from_s - before_s - now_s) / (1.0 + speed_error);
    let end_s = (until_s + before_s - now_s) / (1.0 - speed_error);
    let span = RouteSpan { from_s: begin_s.max(0.0), until_s: end_s.min(look_ahead_s) };
    (span.from_s <= span.until_s).then_some(span)
}

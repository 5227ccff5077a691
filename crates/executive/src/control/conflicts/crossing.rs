//! Crossings of priorities (TC)
//! What: finds the instant at which a waiting task beats a task in its way through the passing of time alone.
//! Runs: contend phase, for claimants that were refused.  Reads: priorities, interrupt costs.  Writes: nothing.
//! Bound: at most `PRIORITY_SEARCH_MAX` evaluations of all contests of one refusal together.
//! PDL: `priority`, `interrupt-cost`, section 9.  Paper: section III, priority of competitors.
//!
//! Priorities are enclosed between bounds over spans of time. A contest is excluded from a span if the challenger's upper bound is not
//! above the defender's lower bound. Spans with remaining contests are halved, the earlier half first, down to a microsecond. This finds
//! the first crossing of all contests, however often the priorities cross. If an expression has no bounds, or the evaluations are used
//! up, priorities are compared again at the end of the span in which they were last known not to cross.

use crate::control::conflicts::curve::Curve;
use crate::control::conflicts::priority::{self, priority};
use crate::control::conflicts::value_intervals::Bounds;
use crate::state::agent::Agent;
use apex_model::limits::{PRIORITY_LOOK_AGAIN_MS, PRIORITY_SEARCH_MAX};
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};
use std::cell::Cell;

/// Shortest span that is halved: a shorter advantage of the challenger may be missed.
const FINEST: Duration = Duration(1_000);
/// Horizon of the search: some 36 years.
const FARTHEST: Duration = Duration(1 << 60);
/// Shortest unknown span that is divided further.
const COARSEST_UNKNOWN: Duration = Duration(100_000_000);
const FIRST_LOOK: Duration = Duration(1_000_000_000);

/// A task that blocks the waiting task.
pub(crate) struct Defender<'a> {
    curve: Curve<'a>,
    /// The blocking task if it holds the contested resource: its interrupt cost then counts too.
    holder: Option<TaskId>,
    cost_moves: bool,
    cost_now: f64,
}

impl<'a> Defender<'a> {
    /// Creates the defender for `rival`. `holder` is the same task if it has the contested resource.
    pub(crate) fn new(agent: &'a Agent, rival: TaskId, holder: Option<TaskId>, now: Time) -> Defender<'a> {
        Defender {
            curve: Curve::new(agent, rival, now),
            holder,
            cost_moves: holder.is_some_and(|holder| priority::cost_moves(agent, holder)),
            cost_now: holder.map_or(0.0, |holder| priority::interrupt_cost_at(agent, holder, now)),
        }
    }

    fn bounds(&self, agent: &Agent, from: Time, to: Time) -> Bounds {
        let own = self.curve.bounds(from, to);
        match self.holder {
            Some(holder) if self.cost_moves => own.plus(priority::cost_bounds(agent, holder, from, to)),
            _ => own.plus(Bounds { low: self.cost_now, high: self.cost_now }),
        }
    }
}

/// A task whose priority counts for the waiting task, and a task in its way.
type Contest<'s, 'a> = (&'s Curve<'a>, &'s Defender<'a>);

/// Returns the instant at which the passing of time requires a new comparison of priorities; `None` if it changes nothing.
pub(crate) fn next_look(
    agent: &Agent,
    challengers: &[Curve<'_>],
    defenders: &[Defender<'_>],
    now: Time,
) -> Option<Time> {
    let all = defenders.iter().flat_map(|defender| challengers.iter().map(move |challenger| (challenger, defender)));
    let mut contests: Vec<Contest<'_, '_>> = all.filter(|contest| may_cross(contest, now)).collect();
    let search = CrossingSearch { agent, now, looks: Cell::new(PRIORITY_SEARCH_MAX), given_up: Cell::new(None) };
    let mut from = now;
    let mut span = FIRST_LOOK;
    let mut found = None;
    while span < FARTHEST && !contests.is_empty() && found.is_none() && !search.is_over(from) {
        found = search.first_in(from, from + span, &contests);
        from = from + span;
        span = Duration(span.0.saturating_mul(2));
        let settled =
            |(own, other): &Contest<'_, '_>| own.is_settled(from) && other.curve.is_settled(from) && !other.cost_moves;
        contests.retain(|contest| !settled(contest));
    }
    [found, search.given_up.get()].into_iter().flatten().min()
}

/// Returns false if the passing of time alone cannot bring a crossing.
fn may_cross((own, other): &Contest<'_, '_>, now: Time) -> bool {
    let moving = own.moves() || other.curve.moves() || other.cost_moves;
    // A challenger that is ahead already was refused because of other tasks: comparing again would repeat at once and forever.
    let is_ahead = own.value_now > other.curve.value_now + other.cost_now;
    moving && !is_ahead && !own.never_exceeds(&other.curve, now)
}

struct CrossingSearch<'a> {
    agent: &'a Agent,
    now: Time,
    looks: Cell<u32>,
    /// Instant of the next comparison if a span could not be searched.
    given_up: Cell<Option<Time>>,
}

impl CrossingSearch<'_> {
    /// Records that nothing is known after `at`: priorities are then compared again, but not earlier than after
    /// [`PRIORITY_LOOK_AGAIN_MS`].
    fn give_up(&self, at: Time) {
        let at = at.max(self.now + Duration(PRIORITY_LOOK_AGAIN_MS.saturating_mul(1_000_000)));
        self.given_up.set(Some(self.given_up.get().map_or(at, |before| before.min(at))));
    }

    /// Returns true if all priorities are compared again before `at` anyway.
    fn is_over(&self, at: Time) -> bool {
        self.given_up.get().is_some_and(|again| again <= at)
    }

    /// Returns true if the challenger beats the defender at `at`.
    fn ahead(&self, (own, other): &Contest<'_, '_>, at: Time) -> bool {
        let cost = match other.holder {
            Some(holder) if other.cost_moves => priority::interrupt_cost_at(self.agent, holder, at),
            _ => other.cost_now,
        };
        priority(self.agent, own.id, at) > priority(self.agent, other.curve.id, at) + cost
    }

    /// Returns true if the challenger could be ahead at some instant of the span; `None` if that is not known.
    fn may_be_ahead(&self, contest: &Contest<'_, '_>, from: Time, to: Time) -> Option<bool> {
        let (own, other) = (contest.0.bounds(from, to), contest.1.bounds(self.agent, from, to));
        if own.high == f64::INFINITY || other.low == f64::NEG_INFINITY {
            return None;
        }
        let fixed = own.low == own.high && other.low == other.high;
        Some(own.high > other.low && (!fixed || self.ahead(contest, from)))
    }

    /// Returns the first instant after `from` and not after `to` at which a challenger is ahead.
    fn first_in(&self, from: Time, to: Time, contests: &[Contest<'_, '_>]) -> Option<Time> {
        if self.is_over(from) {
            return None;
        }
        if self.looks.get() == 0 {
            self.give_up(from);
            return None;
        }
        self.looks.set(self.looks.get() - 1);
        let mut open = Vec::new();
        for contest in contests {
            match self.may_be_ahead(contest, from, to) {
                Some(false) => {}
                None if to - from <= COARSEST_UNKNOWN => self.give_up(from),
                Some(true) | None => open.push(*contest),
            }
        }
        if open.is_empty() {
            return None;
        }
        if to - from <= FINEST {
            let won = open.iter().filter(|contest| self.ahead(contest, to));
            return won.map(|contest| self.first(contest, from, to)).min();
        }
        let middle = from + Duration((to - from).0 / 2);
        self.first_in(from, middle, &open).or_else(|| self.first_in(middle, to, &open))
    }

    /// Returns the first instant in `(low, high]` at which the challenger is ahead; it is ahead at `high`.
    fn first(&self, contest: &Contest<'_, '_>, mut low: Time, mut high: Time) -> Time {
        while (high - low).0 > 1 {
            let middle = low + Duration((high - low).0 / 2);
            if self.ahead(contest, middle) { high = middle } else { low = middle }
        }
        high
    }
}

//! Crossings of priorities (TC)
//! What: finds the instant at which a waiting task would beat one in its way by nothing but the passing of time.
//! Runs: contend phase, for claimants that were refused.  Reads: priorities, interrupt costs.  Writes: nothing.
//! Bound: at most `PRIORITY_SEARCH_MAX` looks at both priorities for each rival.
//! PDL: `priority`, `interrupt-cost`, section 9.  Paper: section III, priority of competitors.
//!
//! Priorities are enclosed between bounds over spans of time. A span in which the challenger's greatest is not above the
//! defender's least holds no crossing; every other one is halved, the earlier half first, down to a microsecond. So the
//! first crossing is found, however often the priorities cross. Where nothing is known of an expression, or two
//! priorities run so close together that the search gives up, the next look is taken when they were last known apart.

use crate::control::moving::Bounds;
use crate::control::priority::{self, priority};
use apex_model::agent::Agent;
use apex_model::limits::{PRIORITY_LOOK_AGAIN_MS, PRIORITY_SEARCH_MAX};
use apex_model::task::TaskId;
use apex_model::time::{Duration, Time};

/// Spans are not divided further than this: a shorter advantage may be missed.
const FINEST: Duration = Duration(1_000);
/// As far as anybody looks ahead: some 34 years.
const FARTHEST: Duration = Duration(1 << 60);
/// Where nothing is known of a span of this length, dividing it further is of no use.
const COARSEST_UNKNOWN: Duration = Duration(100_000_000);
const FIRST_LOOK: Duration = Duration(1_000_000_000);

/// Two priorities that count where two tasks want the same.
pub(crate) struct Contest<'a> {
    /// The agent.
    pub(crate) agent: &'a Agent,
    /// Whose priority counts for the task that waits.
    pub(crate) challenger: TaskId,
    /// Whose priority counts for the task in its way.
    pub(crate) rival: TaskId,
    /// The task in its way, if it has what both want: its interrupt cost counts too.
    pub(crate) holder: Option<TaskId>,
}

enum Found {
    Nothing,
    At(Time),
    /// Until then there is nothing; what comes then was not looked at.
    GivenUp(Time),
}

impl Contest<'_> {
    /// When both are to be compared again because time has passed; none when time alone changes nothing between them.
    pub(crate) fn next_look(&self, now: Time) -> Option<Time> {
        let moves = |id| priority::moves(self.agent, id, false);
        let cost_moves = self.holder.is_some_and(|holder| priority::moves(self.agent, holder, true));
        if !moves(self.challenger) && !moves(self.rival) && !cost_moves {
            return None;
        }
        if self.ahead(now) {
            // It lost because of others: to look again at once, and again, would be to stand still.
            return None;
        }
        let mut budget = PRIORITY_SEARCH_MAX;
        let mut from = now;
        let mut span = FIRST_LOOK;
        while span < FARTHEST {
            match self.search(from, from + span, &mut budget) {
                Found::Nothing => {}
                Found::At(at) => return Some(at),
                Found::GivenUp(at) => {
                    return Some(at.max(now + Duration(PRIORITY_LOOK_AGAIN_MS.saturating_mul(1_000_000))));
                }
            }
            from = from + span;
            span = Duration(span.0.saturating_mul(2));
        }
        None
    }

    /// Does the challenger beat the rival at `at`?
    fn ahead(&self, at: Time) -> bool {
        let cost = self.holder.map_or(0.0, |holder| priority::interrupt_cost_at(self.agent, holder, at));
        priority(self.agent, self.challenger, at) > priority(self.agent, self.rival, at) + cost
    }

    /// Could the challenger be ahead at some instant of this span? None when nothing is known about that.
    fn may_be_ahead(&self, from: Time, to: Time) -> Option<bool> {
        let own = priority::bounds(self.agent, self.challenger, from, to);
        let other = priority::bounds(self.agent, self.rival, from, to);
        let other = match self.holder {
            Some(holder) => other.plus(priority::cost_bounds(self.agent, holder, from, to)),
            None => other,
        };
        if own.high == f64::INFINITY || other.low == f64::NEG_INFINITY {
            return None;
        }
        let fixed = |bounds: Bounds| bounds.low == bounds.high;
        Some(own.high > other.low && !(fixed(own) && fixed(other) && !self.ahead(from)))
    }

    /// The first instant after `from` and not after `to` at which the challenger is ahead.
    fn search(&self, from: Time, to: Time, budget: &mut u32) -> Found {
        if *budget == 0 {
            return Found::GivenUp(from);
        }
        *budget -= 1;
        match self.may_be_ahead(from, to) {
            Some(false) => return Found::Nothing,
            None if to - from <= COARSEST_UNKNOWN => return Found::GivenUp(from),
            Some(true) | None => {}
        }
        if to - from <= FINEST {
            return if self.ahead(to) { Found::At(self.first(from, to)) } else { Found::Nothing };
        }
        let middle = from + Duration((to - from).0 / 2);
        match self.search(from, middle, budget) {
            Found::Nothing => self.search(middle, to, budget),
            found => found,
        }
    }

    /// The least instant in `(low, high]` at which the challenger is ahead, which it is at `high`.
    fn first(&self, mut low: Time, mut high: Time) -> Time {
        while (high - low).0 > 1 {
            let middle = low + Duration((high - low).0 / 2);
            if self.ahead(middle) { high = middle } else { low = middle }
        }
        high
    }
}

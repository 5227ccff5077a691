//! The moves of the search, one per file: insertion of missing targets and changes of an order.
//!
//! An estimate rejects most candidates: the legs that change, at the times of the present order. Only a candidate with a promising
//! estimate is evaluated as a whole, including the shifts of all later visits.

mod exchange;
mod fill;
mod leave_out;
mod rechoose;
mod relocate;
mod replace;
mod together;
mod turn;

use super::search::{Candidate, LocalSearch};
use crate::routing::schedule::{Choice, UNITS_PER_LEG};
use crate::routing::travel::PointKey;

/// Greatest error of an estimate if wind and zones change with time: a constant part, and a share of the remaining flight.
const ESTIMATE_SLACK_S: f64 = 60.0;
const ESTIMATE_SLACK_SHARE: f64 = 0.01;

impl LocalSearch<'_, '_, '_> {
    /// Applies improving moves until none is left.
    pub(super) fn descend(&mut self, current: &mut Candidate) {
        while !self.budget.exhausted()
            && (self.relocate(current)
                || self.turn_or_exchange(current)
                || self.rechoose(current)
                || self.insert(current)
                || self.replace(current)
                || self.leave_out(current))
        {}
    }

    /// Reverses the part between any two visits, or exchanges the two. Returns true if the plan improved.
    fn turn_or_exchange(&mut self, current: &mut Candidate) -> bool {
        let mut better = false;
        for from in 0..current.order.len() {
            for to in from + 1..current.order.len() {
                better |= self.turn(current, from, to);
                better |= self.exchange(current, from, to);
            }
        }
        better
    }

    /// Like `try_order` for another order of the same visits that differs only in `first..last`, but only if the estimated time of its
    /// legs is less.
    fn try_promising(&mut self, current: &mut Candidate, first: usize, last: usize, order: Vec<Choice>) -> bool {
        if self.budget.exhausted() || !self.is_promising(current, first, last, &order) {
            return false;
        }
        self.try_order(current, first, order)
    }

    fn is_promising(&mut self, current: &Candidate, first: usize, last: usize, order: &[Choice]) -> bool {
        self.budget.charge(1);
        let slack_s = self.slack_s(current, first);
        if slack_s.is_infinite() {
            return true;
        }
        let old_s: f64 = (first..=last).map(|at| arrival(current, at) - self.end_before(current, at)).sum();
        let (mut node, mut time_s) = (exit_before(current, first), self.end_before(current, first));
        let mut new_s = 0.0;
        // The legs into each visit that may have moved, and out of the last.
        for at in first..=last {
            let choice = order.get(at).filter(|_| at < last);
            let entry = match choice {
                Some(choice) => Some(PointKey::Entry(choice.target, choice.manoeuvre)),
                None => self.entry_at(current, at),
            };
            let Some(entry) = entry else { break };
            self.budget.charge(UNITS_PER_LEG);
            let Some(leg_s) = self.schedule.travel.time_s(node, entry, time_s) else { return false };
            new_s += leg_s;
            if new_s > old_s + slack_s {
                return false;
            }
            let Some(choice) = choice else { break };
            let target = self.schedule.problem.targets.get(choice.target);
            let manoeuvre = target.and_then(|target| target.manoeuvres.get(choice.manoeuvre));
            time_s += leg_s + manoeuvre.map_or(0.0, |manoeuvre| manoeuvre.duration_s);
            node = PointKey::Exit(choice.target, choice.manoeuvre);
        }
        true
    }

    /// Returns the greatest error of an estimate for the visits from `at` on: waiting may become shorter, and wind and zones may change.
    /// If values change with time, no estimate is trusted.
    fn slack_s(&self, current: &Candidate, at: usize) -> f64 {
        let targets = &self.schedule.problem.targets;
        let visits = current.judged.visits.iter().zip(&current.order).skip(at);
        let waits = visits.map(|(timed, choice)| {
            let timing = targets.get(choice.target).is_some_and(|target| !target.timing.is_empty());
            if timing { f64::INFINITY } else { timed.begin_s - timed.arrive_s }
        });
        let left_s = current.judged.end_s - self.end_before(current, at);
        ESTIMATE_SLACK_S + ESTIMATE_SLACK_SHARE * left_s + waits.sum::<f64>()
    }

    /// Returns the end of the visit before the one at `at`.
    pub(super) fn end_before(&self, current: &Candidate, at: usize) -> f64 {
        let before = at.checked_sub(1).and_then(|before| current.judged.visits.get(before));
        before.map_or(self.schedule.problem.start_s, |timed| timed.end_s)
    }

    /// Returns the entry of the visit at `at`; after the last visit the base, or `None` if the flight may end anywhere.
    pub(super) fn entry_at(&self, current: &Candidate, at: usize) -> Option<PointKey> {
        match current.order.get(at) {
            Some(choice) => Some(PointKey::Entry(choice.target, choice.manoeuvre)),
            None => self.schedule.problem.base.map(|_| PointKey::Base),
        }
    }
}

/// Returns the exit of the visit before the one at `at`.
pub(super) fn exit_before(current: &Candidate, at: usize) -> PointKey {
    let before = at.checked_sub(1).and_then(|before| current.order.get(before));
    before.map_or(PointKey::Start, |choice| PointKey::Exit(choice.target, choice.manoeuvre))
}

/// Returns the arrival at the visit at `at`; after the last, the end of the flight.
pub(super) fn arrival(current: &Candidate, at: usize) -> f64 {
    current.judged.visits.get(at).map_or(current.judged.end_s, |timed| timed.arrive_s)
}

//! The first plans: insert every target by the time that it adds, before the search compares alternatives.
//!
//! The first one estimates times by great circles; only the chosen insertion is computed with wind, turns and around zones. So the work is
//! two legs for each target, however many manoeuvres and start times exist, and the search can improve a complete plan from the beginning.
//! The second one computes the paths into the gaps that the estimates prefer: where targets are near one another, turns take longer than
//! the distances between them.
//! Bound: O(n^2) estimates and n judgements for n targets, regardless of the budget, so that every budget yields a plan; for the second
//! plan in addition at most [`PATHS_MAX`] pairs of paths for each target and insertion, within the budget.

use super::moves::{arrival, exit_before};
use super::search::{Candidate, InsertionTimes, LocalSearch, inserted};
use crate::routing::schedule::{Choice, UNITS_PER_LEG};
use crate::routing::travel::PointKey;
use std::cmp::Ordering;
use std::ops::Range;

/// Gaps of a target whose paths are computed at each look.
const PATHS_MAX: usize = 4;

/// A missing target with its best gap.
#[derive(Clone, Copy, Debug)]
struct Open {
    choice: Choice,
    worth: f64,
    duration_s: f64,
    /// Time that the target adds in its best gap.
    added_s: f64,
    at: usize,
}

impl Open {
    fn merit(&self) -> f64 {
        self.worth / self.added_s.max(1.0)
    }

    /// Returns the entry and the exit of its manoeuvre.
    fn ends(&self) -> (PointKey, PointKey) {
        let Choice { target, manoeuvre, .. } = self.choice;
        (PointKey::Entry(target, manoeuvre), PointKey::Exit(target, manoeuvre))
    }
}

impl LocalSearch<'_, '_, '_> {
    /// Inserts targets where the schedule permits it, each time the one with the highest value per added time. Returns false if the budget
    /// is exhausted before: only plans by `InsertionTimes::Flown` depend on it.
    pub(super) fn construct(&mut self, current: &mut Candidate, times: InsertionTimes) -> bool {
        let mut open: Vec<Open> = self.missing(&current.order).into_iter().filter_map(|it| self.opened(it)).collect();
        for target in &mut open {
            self.look(current, target, 0..current.order.len() + 1, times);
        }
        while let Some(next) = best_of(&open) {
            if times == InsertionTimes::Flown && self.budget.exhausted() {
                return false;
            }
            let next = open.swap_remove(next);
            self.budget.charge(open.len() as u64 + 1);
            let known = current.judged.visits.get(..next.at).unwrap_or(&[]);
            let order = inserted(&current.order, next.at, next.choice);
            let Ok(judged) = self.schedule.judge_after(known, &order, self.budget) else { continue };
            if !judged.beats(&current.judged) {
                continue;
            }
            *current = Candidate { order, judged };
            for target in &mut open {
                // The filled gap is now two gaps; the gaps behind it have moved by one.
                let mut gaps = next.at..next.at + 2;
                match target.at.cmp(&next.at) {
                    Ordering::Equal => {
                        target.added_s = f64::INFINITY;
                        gaps = 0..current.order.len() + 1;
                    }
                    Ordering::Greater => target.at += 1,
                    Ordering::Less => {}
                }
                self.look(current, target, gaps, times);
            }
        }
        true
    }

    /// Returns a target with the manoeuvre whose value less the price of its time is greatest.
    fn opened(&self, target: usize) -> Option<Open> {
        let problem = self.schedule.problem;
        let data = problem.targets.get(target)?;
        let price = self.price_per_s();
        let best = data.manoeuvres.iter().enumerate().max_by(|(_, a), (_, b)| {
            let net = |it: &apex_model::problem::Manoeuvre| data.gain(it.quality.product()) - price * it.duration_s;
            net(a).total_cmp(&net(b))
        });
        let (manoeuvre, with) = best?;
        let choice = Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY };
        let worth = data.gain(with.quality.product());
        Some(Open { choice, worth, duration_s: with.duration_s, added_s: f64::INFINITY, at: 0 })
    }

    /// Returns the value of a second of flight, if all targets had their best value within the available time.
    fn price_per_s(&self) -> f64 {
        let worth: f64 = self.usable.iter().map(|target| self.worth_max(*target)).sum();
        worth / (self.schedule.limit_s - self.schedule.problem.start_s).max(1.0)
    }

    /// Keeps the best of these gaps if it is better than the known one.
    fn look(&mut self, current: &Candidate, open: &mut Open, gaps: Range<usize>, times: InsertionTimes) {
        let mut near: Vec<(f64, usize)> = gaps.map(|at| (self.least_added_s(current, open, at), at)).collect();
        near.retain(|(least_s, _)| *least_s < open.added_s);
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let near_count = match times {
            InsertionTimes::Estimated => 1,
            InsertionTimes::Flown => PATHS_MAX,
        };
        for (least_s, at) in near.into_iter().take(near_count) {
            let added_s = match times {
                InsertionTimes::Estimated => Some(least_s),
                InsertionTimes::Flown if least_s >= open.added_s => break,
                InsertionTimes::Flown => self.flown_added_s(current, open, at),
            };
            if let Some(added_s) = added_s.filter(|added_s| *added_s < open.added_s) {
                (open.added_s, open.at) = (added_s, at);
            }
        }
    }

    /// Returns a lower bound on the time that the target adds in the gap `at`.
    fn least_added_s(&self, current: &Candidate, open: &Open, at: usize) -> f64 {
        let (entry, exit) = open.ends();
        let travel = &self.schedule.travel;
        let onward_s = self.entry_at(current, at).map_or(0.0, |next| travel.time_s_min(exit, next));
        let there_s = travel.time_s_min(exit_before(current, at), entry);
        there_s + open.duration_s + onward_s - self.direct_s(current, at)
    }

    /// Returns the time that the target adds in the gap `at`, if the vehicle leaves as early as the plan does; `None` without a path.
    fn flown_added_s(&mut self, current: &Candidate, open: &Open, at: usize) -> Option<f64> {
        let (entry, exit) = open.ends();
        let leave_s = self.end_before(current, at);
        let there_s = self.schedule.travel.time_s(exit_before(current, at), entry, leave_s);
        let onward_s = there_s.and_then(|there_s| match self.entry_at(current, at) {
            Some(next) => self.schedule.travel.time_s(exit, next, leave_s + there_s + open.duration_s),
            None => Some(0.0),
        });
        self.budget.charge(2 * UNITS_PER_LEG + self.schedule.travel.take_work());
        Some(there_s? + open.duration_s + onward_s? - self.direct_s(current, at))
    }

    /// Returns the time that the plan takes from the end of the visit before the gap to the beginning of the next one.
    fn direct_s(&self, current: &Candidate, at: usize) -> f64 {
        match self.entry_at(current, at) {
            Some(_) => arrival(current, at) - self.end_before(current, at),
            None => 0.0,
        }
    }
}

fn best_of(open: &[Open]) -> Option<usize> {
    let best = open
        .iter()
        .enumerate()
        .max_by(|(_, a), (_, b)| a.merit().total_cmp(&b.merit()).then(b.choice.target.cmp(&a.choice.target)));
    best.map(|(number, _)| number)
}

//! The first plan: inserts every target by estimated times, before the search compares alternatives.
//!
//! Great-circle times alone decide which target is inserted next, and into which gap; only the chosen insertion is computed with wind and
//! around zones. So the work is two legs for each target, however many manoeuvres and start times exist, and the search can improve a
//! complete plan from the beginning.
//! Bound: O(n^2) estimates and n judgements for n targets; does not end with the budget, so that every budget yields a plan.

use super::search::{Candidate, LocalSearch, inserted};
use crate::routing::schedule::Choice;
use crate::routing::travel::PointKey;
use std::cmp::Ordering;

/// A missing target with its best gap.
#[derive(Clone, Copy, Debug)]
struct Open {
    choice: Choice,
    worth: f64,
    duration_s: f64,
    /// Estimated time that the target adds in its best gap.
    added_s: f64,
    at: usize,
}

impl Open {
    fn merit(&self) -> f64 {
        self.worth / self.added_s.max(1.0)
    }
}

impl LocalSearch<'_, '_, '_> {
    /// Inserts targets where the schedule permits it, each time the one with the highest value per estimated time.
    pub(super) fn construct(&mut self, current: &mut Candidate) {
        let mut open: Vec<Open> = self.missing(&current.order).into_iter().filter_map(|it| self.opened(it)).collect();
        for target in &mut open {
            self.look(current, target, 0..current.order.len() + 1);
        }
        while let Some(next) = best_of(&open) {
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
                match target.at.cmp(&next.at) {
                    Ordering::Equal => {
                        target.added_s = f64::INFINITY;
                        self.look(current, target, 0..current.order.len() + 1);
                    }
                    Ordering::Greater => {
                        target.at += 1;
                        self.look(current, target, next.at..next.at + 2);
                    }
                    Ordering::Less => self.look(current, target, next.at..next.at + 2),
                }
            }
        }
    }

    /// Returns a target with the manoeuvre whose value less the price of its time is greatest.
    fn opened(&self, target: usize) -> Option<Open> {
        let problem = self.schedule.problem;
        let data = problem.targets.get(target)?;
        let price = self.price_per_s();
        let best = data.manoeuvres.iter().enumerate().max_by(|(_, a), (_, b)| {
            let net = |it: &apex_model::problem::Manoeuvre| data.value * it.quality.product() - price * it.duration_s;
            net(a).total_cmp(&net(b))
        });
        let (manoeuvre, with) = best?;
        let choice = Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY };
        let worth = data.value * with.quality.product();
        Some(Open { choice, worth, duration_s: with.duration_s, added_s: f64::INFINITY, at: 0 })
    }

    /// Returns the value of a second of flight, if all targets had their best value within the available time.
    fn price_per_s(&self) -> f64 {
        let worth: f64 = self.usable.iter().map(|target| self.worth_max(*target)).sum();
        worth / (self.schedule.limit_s - self.schedule.problem.start_s).max(1.0)
    }

    /// Keeps the best of these gaps if it is better than the known one.
    fn look(&self, current: &Candidate, open: &mut Open, gaps: std::ops::Range<usize>) {
        let Choice { target, manoeuvre, .. } = open.choice;
        let (entry, exit) = (PointKey::Entry(target, manoeuvre), PointKey::Exit(target, manoeuvre));
        let travel = &self.schedule.travel;
        for at in gaps {
            let before = super::moves::exit_before(current, at);
            let next = self.entry_at(current, at);
            let direct_s = next.map_or(0.0, |next| travel.time_s_min(before, next));
            let onward_s = next.map_or(0.0, |next| travel.time_s_min(exit, next));
            let added_s = travel.time_s_min(before, entry) + open.duration_s + onward_s - direct_s;
            if added_s < open.added_s {
                (open.added_s, open.at) = (added_s, at);
            }
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

//! Move that inserts missing targets, the one with the most value per added time first.

use super::super::search::{Candidate, LocalSearch, inserted};
use super::{arrival, exit_before};
use crate::routing::schedule::{Choice, UNITS_PER_LEG};
use crate::routing::travel::PointKey;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An insertion that may be good, the one with the highest merit first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offer {
    /// Gain per added time, blurred: an upper bound until `known`.
    merit: f64,
    known: bool,
    blur: f64,
    pub(super) at: usize,
    pub(super) choice: Choice,
}

impl Ord for Offer {
    fn cmp(&self, other: &Offer) -> Ordering {
        let place = |offer: &Offer| (offer.choice.target, offer.choice.manoeuvre, offer.at, offer.known);
        let merit = self.merit.total_cmp(&other.merit);
        let later = self.choice.not_before_s.total_cmp(&other.choice.not_before_s);
        merit.then_with(|| place(other).cmp(&place(self))).then(later.reverse())
    }
}

impl PartialOrd for Offer {
    fn partial_cmp(&self, other: &Offer) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Offer {
    fn eq(&self, other: &Offer) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Offer {}

impl LocalSearch<'_, '_, '_> {
    /// Inserts missing targets, each time the one with the most gain per added time, while the score increases. `noise` perturbs the
    /// choice so that repeated fillings differ.
    pub(in super::super) fn fill(&mut self, current: &mut Candidate, noise: f64) {
        self.fill_one_by_one(current, noise);
        while self.insert_together(current) {
            self.fill_one_by_one(current, noise);
        }
    }

    fn fill_one_by_one(&mut self, current: &mut Candidate, noise: f64) {
        let mut better = true;
        while better {
            better = false;
            let mut offers = self.offers(current, noise);
            while let Some(offer) = self.best_offer(current, &mut offers) {
                if self.try_order(current, offer.at, inserted(&current.order, offer.at, offer.choice)) {
                    better = true;
                    break;
                }
            }
        }
    }

    /// Returns all insertions that may grow the score, with upper bounds of their merits.
    pub(super) fn offers(&mut self, current: &Candidate, noise: f64) -> BinaryHeap<Offer> {
        let mut offers = BinaryHeap::new();
        let slacks_s: Vec<f64> = (0..=current.order.len()).map(|at| self.slack_s(current, at)).collect();
        for target in self.missing(&current.order) {
            let Some(data) = self.schedule.problem.targets.get(target) else { continue };
            for choice in self.choices(target) {
                let blur = 1.0 - noise * self.random.unit();
                let Some(manoeuvre) = data.manoeuvres.get(choice.manoeuvre) else { continue };
                let worth = data.gain(manoeuvre.quality.product());
                for (at, slack_s) in slacks_s.iter().enumerate() {
                    self.budget.charge(1);
                    let added_s = self.added_s_min(current, at, choice, manoeuvre.duration_s);
                    if current.judged.end_s + added_s - slack_s <= self.schedule.limit_s {
                        let merit = blur * worth / added_s.max(1.0);
                        offers.push(Offer { merit, known: false, blur, at, choice });
                    }
                }
            }
        }
        offers
    }

    /// Returns the best of `offers`: a merit is computed only while its bound exceeds the best known merit.
    pub(super) fn best_offer(&mut self, current: &Candidate, offers: &mut BinaryHeap<Offer>) -> Option<Offer> {
        while let Some(offer) = offers.pop().filter(|_| !self.budget.exhausted()) {
            if offer.known {
                return Some(offer);
            }
            if let Some(merit) = self.merit(current, offer.at, offer.choice) {
                offers.push(Offer { merit: offer.blur * merit, known: true, ..offer });
            }
        }
        None
    }

    /// Returns a lower bound on the time that inserting `choice` adds to the legs at `at`.
    fn added_s_min(&self, current: &Candidate, at: usize, choice: Choice, duration_s: f64) -> f64 {
        let entry = PointKey::Entry(choice.target, choice.manoeuvre);
        let exit = PointKey::Exit(choice.target, choice.manoeuvre);
        let travel = &self.schedule.travel;
        let onward_s = self.entry_at(current, at).map_or(0.0, |next| travel.time_s_min(exit, next));
        let least_s = travel.time_s_min(exit_before(current, at), entry) + duration_s + onward_s;
        self.end_before(current, at) + least_s - arrival(current, at)
    }

    /// Returns the gain per added time of inserting `choice`, computed from its own legs; `None` if it cannot be worthwhile.
    fn merit(&mut self, current: &Candidate, at: usize, choice: Choice) -> Option<f64> {
        let exit = PointKey::Exit(choice.target, choice.manoeuvre);
        self.budget.charge(2 * UNITS_PER_LEG + self.schedule.travel.take_work());
        let visit = self.schedule.visit(exit_before(current, at), self.end_before(current, at), choice).ok()?;
        let onward_s = match self.entry_at(current, at) {
            Some(next) => self.schedule.travel.time_s(exit, next, visit.end_s)?,
            None => 0.0,
        };
        let (added_s, end_s) = (visit.end_s + onward_s - arrival(current, at), current.judged.end_s);
        let slack_s = self.slack_s(current, at);
        if end_s + added_s - slack_s > self.schedule.limit_s {
            return None;
        }
        let least_s = (added_s - slack_s).max(0.0);
        if !current.order.is_empty() && visit.worth <= self.schedule.delay_cost(end_s, end_s + least_s) {
            return None;
        }
        let gain = visit.worth - self.schedule.delay_cost(end_s, end_s + added_s);
        Some(gain / added_s.max(1.0))
    }

    /// Inserts missing targets; returns true if at least one was inserted.
    pub(super) fn insert(&mut self, current: &mut Candidate) -> bool {
        let before = current.order.len();
        self.fill(current, 0.0);
        current.order.len() > before
    }
}

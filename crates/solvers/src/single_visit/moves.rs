//! The moves of the search: insertion of missing targets and changes of an order.
//!
//! Most candidates are turned away by an estimate: the legs that change, flown at the times known from the order as it is.
//! Only what may be better by it is judged as a whole, with all that follows later or earlier.

use super::schedule::{Choice, UNITS_PER_LEG};
use super::search::{Candidate, Search, inserted};
use super::travel::Node;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An estimate may be wrong by this where winds and zones change with the time of day.
const ESTIMATE_SLACK_S: f64 = 60.0;
/// And by this share of the flight that is left.
const ESTIMATE_SLACK_SHARE: f64 = 0.01;
/// Longest run of visits that is moved to another place.
const RUN_MAX: usize = 3;
/// Insertions judged in place of one visit taken out.
const REPLACEMENTS_MAX: usize = 12;

/// An insertion that may be good, the one with the highest merit first.
#[derive(Clone, Copy, Debug)]
struct Offer {
    /// Gain per added time, blurred: an upper bound until `known`.
    merit: f64,
    known: bool,
    blur: f64,
    at: usize,
    choice: Choice,
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

impl Search<'_, '_, '_> {
    /// Inserts missing targets, each time the one with the most gain per added time, while the score grows.
    /// `noise` blurs the choice so that repeated fillings differ.
    pub(super) fn fill(&mut self, current: &mut Candidate, noise: f64) {
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

    /// All insertions that may grow the score, with upper bounds of their merits.
    fn offers(&mut self, current: &Candidate, noise: f64) -> BinaryHeap<Offer> {
        let mut offers = BinaryHeap::new();
        let slacks_s: Vec<f64> = (0..=current.order.len()).map(|at| self.slack_s(current, at)).collect();
        for target in self.missing(&current.order) {
            let Some(data) = self.schedule.problem.targets.get(target) else { continue };
            for choice in self.choices(target) {
                let blur = 1.0 - noise * self.random.unit();
                let Some(manoeuvre) = data.manoeuvres.get(choice.manoeuvre) else { continue };
                let worth = data.value * manoeuvre.quality.product();
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

    /// Takes the best offer out of `offers`: merits are computed only while a bound promises more than the best known.
    fn best_offer(&mut self, current: &Candidate, offers: &mut BinaryHeap<Offer>) -> Option<Offer> {
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

    /// Inserting `choice` adds no less than this to the legs at `at`.
    fn added_s_min(&self, current: &Candidate, at: usize, choice: Choice, duration_s: f64) -> f64 {
        let entry = Node::Entry(choice.target, choice.manoeuvre);
        let exit = Node::Exit(choice.target, choice.manoeuvre);
        let travel = &self.schedule.travel;
        let onward_s = self.entry_at(current, at).map_or(0.0, |next| travel.time_s_min(exit, next));
        let least_s = travel.time_s_min(exit_before(current, at), entry) + duration_s + onward_s;
        self.end_before(current, at) + least_s - arrival(current, at)
    }

    /// Gain per added time of inserting `choice`, by its own legs; none where it cannot be worth it.
    fn merit(&mut self, current: &Candidate, at: usize, choice: Choice) -> Option<f64> {
        let exit = Node::Exit(choice.target, choice.manoeuvre);
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

    /// Applies improving moves until there is none.
    pub(super) fn descend(&mut self, current: &mut Candidate) {
        while !self.budget.exhausted()
            && (self.move_runs(current)
                || self.turn_round(current)
                || self.rechoose(current)
                || self.insert(current)
                || self.replace(current)
                || self.drop_one(current))
        {}
    }

    /// Moves one visit or a short run of visits to another place, also turned round. Says whether anything got better.
    fn move_runs(&mut self, current: &mut Candidate) -> bool {
        let mut better = false;
        for length in 1..=RUN_MAX {
            for from in 0..current.order.len() {
                for to in 0..current.order.len() {
                    let count = current.order.len();
                    if to == from || from + length > count || to + length > count {
                        continue;
                    }
                    let mut order = current.order.clone();
                    let mut run: Vec<Choice> = order.drain(from..from + length).collect();
                    let (first, last) = (from.min(to), (from + length).max(to + length));
                    order.splice(to..to, run.iter().copied());
                    let moved = self.try_promising(current, first, last, order.clone());
                    better |= moved;
                    if length > 1 && !moved {
                        run.reverse();
                        order.splice(to..to + length, run);
                        better |= self.try_promising(current, first, last, order);
                    }
                }
            }
        }
        better
    }

    /// Exchanges two visits, or turns the part between them round. Says whether anything got better.
    fn turn_round(&mut self, current: &mut Candidate) -> bool {
        let mut better = false;
        for from in 0..current.order.len() {
            for to in from + 1..current.order.len() {
                let mut turned = current.order.clone();
                if let Some(part) = turned.get_mut(from..=to) {
                    part.reverse();
                }
                better |= self.try_promising(current, from, to + 1, turned);
                let mut exchanged = current.order.clone();
                exchanged.swap(from, to);
                better |= self.try_promising(current, from, to + 1, exchanged);
            }
        }
        better
    }

    /// As `try_order` for the same visits in another order, that differs in `first..last` only, if the legs there
    /// promise to take less time.
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
                Some(choice) => Some(Node::Entry(choice.target, choice.manoeuvre)),
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
            node = Node::Exit(choice.target, choice.manoeuvre);
        }
        true
    }

    /// Another manoeuvre or another time for one visit. Says whether anything got better.
    fn rechoose(&mut self, current: &mut Candidate) -> bool {
        let mut better = false;
        for at in 0..current.order.len() {
            let Some(now) = current.order.get(at).copied() else { continue };
            for choice in self.choices(now.target).into_iter().filter(|choice| *choice != now) {
                let mut order = current.order.clone();
                if let Some(slot) = order.get_mut(at) {
                    *slot = choice;
                }
                better |= self.try_order(current, at, order);
            }
        }
        better
    }

    /// One visit out, another target or the same in another way in at any place.
    fn replace(&mut self, current: &mut Candidate) -> bool {
        for out in 0..current.order.len() {
            let mut order = current.order.clone();
            order.remove(out);
            let Some(judged) = self.judge(current, out, &order) else { continue };
            let without = Candidate { order, judged };
            let mut offers = self.offers(&without, 0.0);
            for _ in 0..REPLACEMENTS_MAX {
                let Some(offer) = self.best_offer(&without, &mut offers) else { break };
                let order = inserted(&without.order, offer.at, offer.choice);
                if self.try_order(current, out.min(offer.at), order) {
                    return true;
                }
            }
        }
        false
    }

    fn insert(&mut self, current: &mut Candidate) -> bool {
        let before = current.order.len();
        self.fill(current, 0.0);
        current.order.len() > before
    }

    fn drop_one(&mut self, current: &mut Candidate) -> bool {
        (0..current.order.len()).any(|at| {
            let mut order = current.order.clone();
            order.remove(at);
            !order.is_empty() && self.try_order(current, at, order)
        })
    }

    /// How far an estimate of what comes from visit `at` on may be wrong: waiting may become shorter, wind and zones may
    /// change; where worth changes with time no estimate is trusted.
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

    /// When the visit before the one at `at` ends.
    fn end_before(&self, current: &Candidate, at: usize) -> f64 {
        let before = at.checked_sub(1).and_then(|before| current.judged.visits.get(before));
        before.map_or(self.schedule.problem.start_s, |timed| timed.end_s)
    }

    /// Where the visit at `at` begins; the base after the last; none where the flight may end anywhere.
    fn entry_at(&self, current: &Candidate, at: usize) -> Option<Node> {
        match current.order.get(at) {
            Some(choice) => Some(Node::Entry(choice.target, choice.manoeuvre)),
            None => self.schedule.problem.base.map(|_| Node::Base),
        }
    }
}

/// Where the visit before the one at `at` ends.
fn exit_before(current: &Candidate, at: usize) -> Node {
    let before = at.checked_sub(1).and_then(|before| current.order.get(before));
    before.map_or(Node::Start, |choice| Node::Exit(choice.target, choice.manoeuvre))
}

/// When the vehicle is at the visit at `at`; after the last, when the flight ends.
fn arrival(current: &Candidate, at: usize) -> f64 {
    current.judged.visits.get(at).map_or(current.judged.end_s, |timed| timed.arrive_s)
}

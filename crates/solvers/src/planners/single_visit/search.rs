//! The search: greedy insertion and local search (see `moves`), ruin and re-insertion; small missions are solved exactly.

use super::companions;
use super::exhaust::{self, EXHAUSTED_TARGETS_MAX, Effort, worth_max};
use super::explain::Troubles;
use crate::routing::flight_limit::FlightLimit;
use crate::routing::schedule::{Choice, Judged, Schedule, UNITS_PER_LEG};
use apex_model::problem::{Manoeuvre, Plan, PlannedVisit, SingleVisitPlan, SingleVisitProblem, SingleVisitTarget};
use apex_planning::random::Generator;
use apex_planning::solver::{Budget, Environment, WorkBudget};

/// Ruins in a row without a better plan after which the search ends.
pub(super) const STALE_ROUNDS_MAX: usize = 3_000;

/// The search continues from plans that are worse than the best by a random part of this share.
const DETOUR_SHARE: f64 = 0.08;
/// Rounds without a better plan after which the search returns to the best plan.
const RETURN_ROUNDS: usize = 60;
/// Share by which a random number may lower the merit of an insertion after a ruin.
const REFILL_NOISE: f64 = 0.3;

/// Missions of up to this many targets are searched exactly, if [`EXACT_VISITS_MAX`] allows; with given times a few more.
const FLOWN_TARGETS_MAX: usize = 6;
/// Maximum number of visits that the enumeration of few targets examines in a flight: a tenth of a second.
const EXACT_VISITS_MAX: u32 = 50_000;

/// An order with its judgement.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) order: Vec<Choice>,
    pub(super) judged: Judged,
}

/// Times by which targets are inserted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InsertionTimes {
    /// Lower bounds.
    Estimated,
    /// Those of paths.
    Flown,
}

pub(super) struct LocalSearch<'s, 'p, 'b> {
    pub(super) schedule: &'s mut Schedule<'p>,
    pub(super) usable: Vec<usize>,
    troubles: &'s Troubles,
    /// Targets that a plan visits only together with others: see [`companions::companions`].
    pub(super) companions: Vec<usize>,
    pub(super) budget: &'b mut dyn Budget,
    pub(super) random: Generator,
    /// Targets that the next filling leaves out, so that others are tried.
    banned: Vec<usize>,
}

/// Returns the best order found within the budget, over the targets that can be visited; never worse than the remainder of the plan
/// `previous`.
pub(super) fn run(
    schedule: &mut Schedule<'_>,
    troubles: &Troubles,
    previous: Option<&SingleVisitPlan>,
    environment: &mut Environment<'_>,
) -> Candidate {
    let seed = environment.seed;
    let report = &mut *environment.report;
    let (usable, random, budget) = (troubles.possible(), Generator::new(seed), &mut *environment.budget);
    let companions = companions::companions(schedule, troubles);
    let mut search = LocalSearch { schedule, usable, troubles, companions, budget, random, banned: Vec::new() };
    let idle = Judged { visits: Vec::new(), end_s: search.schedule.problem.start_s, score: f64::NEG_INFINITY };
    let mut best = Candidate { order: Vec::new(), judged: idle };
    let empty = best.clone();
    search.construct(&mut best, InsertionTimes::Estimated);
    tell(&mut search, &best, report);
    let mut flown = empty;
    if search.construct(&mut flown, InsertionTimes::Flown) && flown.judged.beats(&best.judged) {
        best = flown;
        tell(&mut search, &best, report);
    }
    search.fill(&mut best, 0.0);
    search.start_somewhere(&mut best);
    if let Some(left) = previous.and_then(|plan| search.left_of(plan)).filter(|left| left.judged.beats(&best.judged)) {
        best = left;
    }
    tell(&mut search, &best, report);
    search.descend(&mut best);
    tell(&mut search, &best, report);
    if search.exact(&mut best) {
        tell(&mut search, &best, report);
        return best;
    }
    let mut current = best.clone();
    let mut stale = 0;
    while stale < STALE_ROUNDS_MAX && !search.budget.exhausted() {
        stale += 1;
        let mut next = search.ruined(&current);
        search.fill(&mut next, REFILL_NOISE);
        search.banned.clear();
        if next.judged.beats(&best.judged) {
            // A descent takes as much work as dozens of ruins, so it is made only from a new best plan.
            search.descend(&mut next);
            best = next.clone();
            stale = 0;
            tell(&mut search, &best, report);
        }
        // Continues from plans slightly worse than the best, so that the search does not stay at one local optimum.
        let detour = DETOUR_SHARE * search.random.unit() * best.judged.score.abs();
        if stale % RETURN_ROUNDS == 0 {
            current = best.clone();
        } else if next.judged.score >= best.judged.score - detour {
            current = next;
        }
    }
    best
}

/// Returns the best of all orders of few targets with given travel times, and the highest benefits of a plan; `None` for other problems,
/// or if half of the budget does not suffice. Observations begin at once, so a timing excludes a problem: waiting may pay at any instant.
pub(super) fn enumerated(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    environment: &mut Environment<'_>,
) -> Option<(Candidate, f64)> {
    let problem = schedule.problem;
    let is_timed = problem.targets.iter().any(|target| !target.timing.is_empty());
    if problem.travel.is_none() || is_timed || usable.len() > EXHAUSTED_TARGETS_MAX {
        return None;
    }
    let effort = Effort { visits_max: half_of(environment.budget), budget: &mut *environment.budget, score_min: None };
    let end_s = problem.start_s;
    let idle = Judged { visits: Vec::new(), end_s, score: f64::NEG_INFINITY };
    let mut best = Candidate { order: Vec::new(), judged: idle };
    let bound = improve(schedule, usable, &|target| choices(problem, target), effort, &mut best)?;
    Some((best, bound))
}

/// Improves `best` by an enumeration; returns the highest benefits of the compared plans, if the enumeration is complete.
fn improve(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    choices: &dyn Fn(usize) -> Vec<Choice>,
    effort: Effort<'_>,
    best: &mut Candidate,
) -> Option<f64> {
    let Effort { visits_max, budget, score_min } = effort;
    let found = exhaust::exhaust(schedule, usable, choices, Effort { visits_max, budget: &mut *budget, score_min })?;
    if let Some(order) = found.best
        && let Ok(judged) = schedule.judge(&order, budget)
        && judged.beats(&best.judged)
    {
        *best = Candidate { order, judged };
    }
    found.is_complete.then_some(found.benefits_max)
}

/// Returns the number of visits, with given times, whose examination takes half of the remaining budget.
fn half_of(budget: &dyn Budget) -> u32 {
    let share = |left: u64| u32::try_from(left / (2 * UNITS_PER_LEG)).unwrap_or(u32::MAX);
    budget.left().map_or(u32::MAX, share)
}

/// Returns `order` with its evaluation, without visits that cannot be made: those without a way, and the last ones if these are too late.
pub(super) fn longest_flown(schedule: &mut Schedule<'_>, mut order: Vec<Choice>) -> Candidate {
    let mut free = WorkBudget::new(u64::MAX);
    loop {
        match schedule.judge(&order, &mut free) {
            Ok(judged) => return Candidate { order, judged },
            Err(_) if order.is_empty() => {
                let end_s = schedule.problem.start_s;
                let judged = Judged { visits: Vec::new(), end_s, score: f64::NEG_INFINITY };
                return Candidate { order, judged };
            }
            Err(_) => {
                let made = |length: &usize| {
                    let part = order.get(..*length).unwrap_or_default();
                    schedule.judge_part(&[], part, &mut free).is_ok()
                };
                let made = (1..=order.len()).take_while(made).count();
                order.remove(made.min(order.len() - 1));
            }
        }
    }
}

/// Returns `best`, or no visit at all if that scores as much: visits may be worth nothing, or cost more than their value.
///
/// # Errors
/// The reason if there is no plan at all: `best` has no visits, and the vehicle cannot return to the base in time even without one.
pub(super) fn or_idle(schedule: &mut Schedule<'_>, best: Candidate) -> Result<Candidate, String> {
    match schedule.idle() {
        Ok(judged) if best.order.is_empty() || judged.score >= best.judged.score => {
            Ok(Candidate { order: Vec::new(), judged })
        }
        Err(none) if best.order.is_empty() => Err(schedule.no_plan(&none)),
        _ => Ok(best),
    }
}

fn tell(search: &mut LocalSearch<'_, '_, '_>, best: &Candidate, report: &mut dyn FnMut(&Plan)) {
    // Without a visit nothing has been found yet.
    if best.order.is_empty() {
        return;
    }
    if let Some(plan) = super::plan::sketch(search.schedule, "single-visit", best, search.troubles) {
        report(&Plan::SingleVisit(plan));
    }
}

impl LocalSearch<'_, '_, '_> {
    /// Evaluates `order`, whose first `same` visits are those of `current`.
    pub(super) fn judge(&mut self, current: &Candidate, same: usize, order: &[Choice]) -> Option<Judged> {
        if self.budget.exhausted() {
            return None;
        }
        let known = current.judged.visits.get(..same).unwrap_or(&[]);
        self.schedule.judge_after(known, order, self.budget).ok()
    }

    /// Adopts `order`, whose first `same` visits are those of `current`, if it is better; returns true if it did.
    pub(super) fn try_order(&mut self, current: &mut Candidate, same: usize, order: Vec<Choice>) -> bool {
        match self.judge(current, same, &order) {
            Some(judged) if judged.beats(&current.judged) => {
                *current = Candidate { order, judged };
                true
            }
            _ => false,
        }
    }

    /// Improves `best` by all orders of few targets. Returns true if the enumeration is complete: `best` is then optimal, provided that
    /// a later departure never arrives earlier, and that observations begin at once or at a corner of their timing.
    fn exact(&mut self, best: &mut Candidate) -> bool {
        let (usable, problem) = (self.usable.clone(), self.schedule.problem);
        // With given times a visit takes little work; half of the budget remains for the search.
        let visits_max = match &problem.travel {
            Some(_) => half_of(self.budget),
            None if usable.len() > FLOWN_TARGETS_MAX => return false,
            None => EXACT_VISITS_MAX,
        };
        let effort = Effort { visits_max, budget: &mut *self.budget, score_min: Some(best.judged.score) };
        improve(self.schedule, &usable, &|target| choices(problem, target), effort, best).is_some()
    }

    /// Returns the most that a target can be worth.
    pub(super) fn worth_max(&self, target: usize) -> f64 {
        worth_max(self.schedule.problem, target)
    }

    /// Adds at least one visit, however small the budget is.
    fn start_somewhere(&mut self, current: &mut Candidate) {
        let choices: Vec<Choice> = self.usable.iter().flat_map(|target| self.choices(*target)).collect();
        for choice in choices {
            if !current.order.is_empty() {
                return;
            }
            if let Ok(judged) = self.schedule.judge(&[choice], self.budget) {
                *current = Candidate { order: vec![choice], judged };
            }
        }
    }

    /// Returns the remainder of a plan: its visits in their order, without those that no longer exist or are no longer possible.
    fn left_of(&mut self, plan: &SingleVisitPlan) -> Option<Candidate> {
        let mut left: Option<Candidate> = None;
        for visit in &plan.visits {
            let Some(choice) = self.choice_of(visit) else { continue };
            let known = left.as_ref().map_or(&[][..], |left| left.judged.visits.as_slice());
            let order =
                left.as_ref().map_or_else(|| vec![choice], |left| inserted(&left.order, left.order.len(), choice));
            if let Ok(judged) = self.schedule.judge_after(known, &order, self.budget) {
                left = Some(Candidate { order, judged });
            }
        }
        left
    }

    /// Returns the choice that a visit of a plan represents, if its target and its manoeuvre still exist.
    fn choice_of(&self, visit: &PlannedVisit) -> Option<Choice> {
        let targets = &self.schedule.problem.targets;
        let target =
            *self.usable.iter().find(|index| targets.get(**index).is_some_and(|it| it.name == visit.target))?;
        targets.get(target).filter(|data| visit.manoeuvre < data.manoeuvres.len())?;
        let of_manoeuvre = self.choices(target).into_iter().filter(|choice| choice.manoeuvre == visit.manoeuvre);
        let starts: Vec<f64> = of_manoeuvre.map(|choice| choice.not_before_s).collect();
        // The visit waits for the corner of its timing at which it begins.
        let waits = |start_s: &f64| (start_s - visit.begin_s).abs() < 1e-6;
        let not_before_s = starts.into_iter().rev().find(waits).unwrap_or(f64::NEG_INFINITY);
        Some(Choice { target, manoeuvre: visit.manoeuvre, not_before_s })
    }

    pub(super) fn missing(&self, order: &[Choice]) -> Vec<usize> {
        let usable = self.usable.iter().copied();
        usable
            .filter(|target| !self.banned.contains(target) && !order.iter().any(|choice| choice.target == *target))
            .collect()
    }

    /// Returns all ways to observe `target`: see [`choices`].
    pub(super) fn choices(&self, target: usize) -> Vec<Choice> {
        choices(self.schedule.problem, target)
    }

    /// Returns `best` without a few visits, consecutive or random ones; sometimes instead a plan of a single random visit, so that plans
    /// grow from every region. In half of the calls the removed targets are excluded from the next filling.
    fn ruined(&mut self, best: &Candidate) -> Candidate {
        let count = best.order.len();
        let take = 1 + self.random.below(count.div_ceil(3).max(1));
        let mut order = best.order.clone();
        match self.random.below(5) {
            0 => {
                let target = self.usable.get(self.random.below(self.usable.len())).copied().unwrap_or(0);
                let choices = self.choices(target);
                order = choices.get(self.random.below(choices.len())).copied().into_iter().collect();
            }
            1 | 2 => {
                let from = self.random.below(count.saturating_sub(take) + 1);
                order.drain(from..(from + take).min(count));
            }
            _ => {
                for _ in 0..take.min(order.len()) {
                    order.remove(self.random.below(order.len()));
                }
            }
        }
        if self.random.below(2) == 0 {
            let kept = |target: &usize| order.iter().any(|choice| choice.target == *target);
            self.banned = best.order.iter().map(|choice| choice.target).filter(|target| !kept(target)).collect();
        }
        match self.schedule.judge(&order, self.budget) {
            Ok(judged) if !order.is_empty() => Candidate { order, judged },
            _ => {
                let end_s = self.schedule.problem.start_s;
                Candidate { order: Vec::new(), judged: Judged { visits: Vec::new(), end_s, score: f64::NEG_INFINITY } }
            }
        }
    }
}

/// Returns all ways to observe a target: each manoeuvre at once, from each corner of its timing on, or at the latest instant before which
/// its timing still rises.
pub(super) fn choices(problem: &SingleVisitProblem, target: usize) -> Vec<Choice> {
    let Some(data) = problem.targets.get(target) else { return Vec::new() };
    let starts = [f64::NEG_INFINITY].into_iter().chain(data.timing.iter().map(|(time_s, _)| *time_s));
    let starts: Vec<f64> = starts.collect();
    let of_manoeuvre = |(manoeuvre, way): (usize, &Manoeuvre)| {
        let latest_s = latest_rising_s(problem, (target, data), way);
        let starts = starts.iter().copied().chain(latest_s);
        starts.map(|not_before_s| Choice { target, manoeuvre, not_before_s }).collect::<Vec<_>>()
    };
    data.manoeuvres.iter().enumerate().flat_map(of_manoeuvre).collect()
}

/// Returns the instants within a rise of a target's timing at which the observation must begin at the latest: at the end of a window, and
/// with given times, where the way to the base leaves no more time.
fn latest_rising_s(
    problem: &SingleVisitProblem,
    (number, target): (usize, &SingleVisitTarget),
    way: &Manoeuvre,
) -> Vec<f64> {
    if target.timing.is_empty() {
        return Vec::new();
    }
    let mut latest_s: Vec<f64> = target.windows.iter().map(|window| window.until_s).collect();
    if let Some(travel) = &problem.travel {
        let limit_s = FlightLimit::earliest(problem).0 - way.duration_s;
        let home_s = |to_base_s: &[f64]| match problem.base {
            Some(_) => to_base_s.get(number).copied().unwrap_or(0.0),
            None => 0.0,
        };
        latest_s.push(limit_s - home_s(&travel.to_base_s));
        latest_s.extend(travel.later.iter().map(|later| limit_s - home_s(&later.to_base_s)));
    }
    let corners = || target.timing.iter().zip(target.timing.iter().skip(1));
    let rises = |at_s: &f64| corners().any(|(one, next)| one.0 < *at_s && *at_s < next.0 && one.1 < next.1);
    latest_s.retain(rises);
    latest_s
}

pub(super) fn inserted(order: &[Choice], at: usize, choice: Choice) -> Vec<Choice> {
    let mut longer = order.to_vec();
    longer.insert(at.min(order.len()), choice);
    longer
}

//! Flies a word (a sequence of targets) or a cycle on a surveillance problem: times, expected cost, plan.
//!
//! Work is metered here in nanoseconds and charged in whole units, so that a unit is the same for every surveillance planner; planners
//! charge their other work with [`spend`](Scenario::spend). The figures were measured (`make bench-units`).
//! Bound: O(visits) per evaluation, at most [`VISITS_MAX`].

use super::reach;
use crate::obstacle::LeftOutReason;
use crate::solver::{Budget, WORK_UNIT};
use apex_metrics::eci;
use apex_model::problem::{
    LeftOut, Obstacle, SurveillancePlan, SurveillanceProblem, SurveillanceVisit, TimeLimit, TravelTimes, UNREACHABLE_S,
};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

/// Maximum number of visits of one plan: a visit every second for a day and more.
pub const VISITS_MAX: usize = 100_000;

/// Maximum number of visits that are flown to find the cheapest places of one more visit, for all targets together: all places of one
/// target in a word of 2,000 visits.
const INSERTED_VISITS_MAX: usize = 4_000_000;

/// Visits of a word that counts as short.
const SHORT_WORD: usize = 100;

/// Work per entry of the travel times when a problem is prepared, in nanoseconds.
const ENTRY_NS: u64 = 4;
/// Work of flying a tour: each visit, each target, and the rest.
const VISIT_NS: u64 = 30;
const TARGET_NS: u64 = 1;
const WORD_NS: u64 = 120;
/// Additional work of a travel time that depends on the departure.
const DEPARTURE_NS: u64 = 25;
/// Work of writing a plan: each visit and each target.
const WRITTEN_VISIT_NS: u64 = 250;
const WRITTEN_TARGET_NS: u64 = 400;

/// A visit by the target's index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Index of the target.
    pub target: usize,
    /// Arrival.
    pub arrive_s: f64,
    /// End of the observation.
    pub end_s: f64,
}

/// A validated problem with derived data for planners.
#[derive(Debug)]
pub struct Scenario<'a> {
    problem: &'a SurveillanceProblem,
    limit_s: f64,
    usable: Vec<usize>,
    /// Times that do not depend on the departure.
    typical: Cow<'a, TravelTimes>,
    /// Least time from the end of each target's observation to the base, by detours where these are faster than the direct way; empty if
    /// none is.
    home_s: Vec<f64>,
    /// Cost of each target if it is never visited, and of all of them together.
    idle: (Vec<f64>, f64),
    /// Mean time from one usable target to another, dwell included; computed on first request.
    mean_transit_s: OnceCell<f64>,
    /// Work done and not yet charged.
    spent_ns: Cell<u64>,
}

impl<'a> Scenario<'a> {
    /// Prepares `problem`.
    ///
    /// # Errors
    /// A description of the error in the problem.
    pub fn new(problem: &'a SurveillanceProblem) -> Result<Scenario<'a>, String> {
        crate::validate::surveillance(problem)?;
        let limit_s = problem.endurance_s.unwrap_or(problem.horizon_s).min(problem.horizon_s);
        let typical = match problem.travel.is_constant() {
            true => Cow::Borrowed(&problem.travel),
            false => Cow::Owned(problem.travel.mean(limit_s)),
        };
        let targets = &problem.targets;
        let alone = targets.iter().map(|target| eci::interval_cost(target, -target.initial_age_s, problem.horizon_s));
        let alone: Vec<f64> = alone.collect();
        let sum = alone.iter().sum();
        let (count, matrices) = (targets.len() as u64, 1 + problem.travel.later.len() as u64);
        let spent_ns = Cell::new(count * count * matrices * ENTRY_NS + count * VISIT_NS);
        let (idle, mean_transit_s) = ((alone, sum), OnceCell::new());
        let home_s = if problem.return_to_base { reach::detours_home_s(problem) } else { Vec::new() };
        let mut scenario =
            Scenario { problem, limit_s, usable: Vec::new(), typical, home_s, idle, mean_transit_s, spent_ns };
        let end_s = |from: Option<usize>, ready_s: f64, to: usize| {
            scenario.next_stop(from, ready_s, to).map_or(f64::INFINITY, |stop| stop.end_s)
        };
        let (usable, spent_ns) = reach::usable(targets.len(), end_s);
        scenario.usable = usable;
        scenario.spend(spent_ns);
        Ok(scenario)
    }

    /// Returns the problem.
    pub fn problem(&self) -> &'a SurveillanceProblem {
        self.problem
    }

    /// Returns travel times for comparing places with each other: the mean over departures. Flown tours are evaluated with the true
    /// times.
    pub fn typical(&self) -> &TravelTimes {
        &self.typical
    }

    /// Returns the indices of the targets that can be observed, as the first one or after others.
    pub fn usable(&self) -> &[usize] {
        &self.usable
    }

    /// Returns true if a detour over another target can be the fastest way home. Whether a flight may end with a visit is then known only
    /// at its end.
    pub fn has_detours_home(&self) -> bool {
        !self.home_s.is_empty()
    }

    /// Returns the latest end of a flight: horizon or endurance.
    pub fn limit_s(&self) -> f64 {
        self.limit_s
    }

    /// Returns the additional work of a travel time that depends on the departure, in nanoseconds.
    pub fn departure_ns(&self) -> u64 {
        if self.problem.travel.is_constant() { 0 } else { DEPARTURE_NS }
    }

    /// Records work of this many nanoseconds; the next [`charge`](Scenario::charge) counts it.
    pub fn spend(&self, nanoseconds: u64) {
        self.spent_ns.set(self.spent_ns.get().saturating_add(nanoseconds));
    }

    /// Charges the whole units of the recorded work plus `nanoseconds`.
    pub fn charge(&self, nanoseconds: u64, budget: &mut dyn Budget) {
        let (spent_ns, unit_ns) = (self.spent_ns.get().saturating_add(nanoseconds), WORK_UNIT.0.unsigned_abs());
        self.spent_ns.set(spent_ns % unit_ns);
        budget.charge(spent_ns / unit_ns);
    }

    /// Returns the mean time from one usable target to another, dwell included.
    pub fn mean_transit_s(&self) -> f64 {
        *self.mean_transit_s.get_or_init(|| {
            let (mut sum_s, mut count) = (0.0, 0.0);
            for from in &self.usable {
                for to in self.usable.iter().filter(|to| *to != from) {
                    if let Some(stop) = self.next_stop(Some(*from), 0.0, *to) {
                        sum_s += stop.end_s;
                        count += 1.0;
                    }
                }
            }
            self.spend((self.usable.len() * self.usable.len()) as u64 * ENTRY_NS);
            if count > 0.0 { sum_s / count } else { self.limit_s }
        })
    }

    /// Returns the visit of `target` after a departure from `from` (`None`: the start) at `time_s`; `None` if it would end too late for
    /// every way home.
    pub fn next_stop(&self, from: Option<usize>, time_s: f64, target: usize) -> Option<Stop> {
        let travel = &self.problem.travel;
        let travel_s =
            from.map_or_else(|| travel.start_to_at(target, time_s), |from| travel.between_at(from, target, time_s));
        let dwell_s = self.problem.targets.get(target)?.dwell_s;
        let arrive_s = time_s + travel_s;
        let end_s = arrive_s + dwell_s;
        let home_s = match self.home_s.get(target) {
            Some(home_s) => *home_s,
            None if self.problem.return_to_base => travel.to_base_at(target, end_s),
            None => 0.0,
        };
        let in_time = travel_s < UNREACHABLE_S && home_s < UNREACHABLE_S && end_s + home_s <= self.limit_s;
        in_time.then_some(Stop { target, arrive_s, end_s })
    }

    /// Flies `word` in order until it ends or the next visit would end too late.
    pub fn fly(&self, word: impl IntoIterator<Item = usize>, each: impl FnMut(Stop)) {
        if self.home_s.is_empty() {
            return self.fly_out(word, each);
        }
        let mut stops = Vec::new();
        self.fly_out(word, |stop| stops.push(stop));
        let is_last =
            |stop: &Stop| stop.end_s + self.problem.travel.to_base_at(stop.target, stop.end_s) <= self.limit_s;
        let flown = stops.iter().rposition(is_last).map_or(0, |last| last + 1);
        stops.into_iter().take(flown).for_each(each);
    }

    /// Like [`Scenario::fly`], but the flown visits may end without a way home.
    fn fly_out(&self, word: impl IntoIterator<Item = usize>, mut each: impl FnMut(Stop)) {
        let (mut place, mut time_s) = (None, 0.0);
        for target in word.into_iter().take(VISITS_MAX) {
            let Some(stop) = self.next_stop(place, time_s, target) else { return };
            (place, time_s) = (Some(target), stop.end_s);
            each(stop);
        }
    }

    /// Returns the expected cost of flying `word`.
    pub fn cost(&self, word: impl IntoIterator<Item = usize>, budget: &mut dyn Budget) -> f64 {
        let (cost, ns, _) = self.price(word);
        self.charge(ns, budget);
        cost
    }

    /// Returns the expected cost of `word`, the work of computing it in nanoseconds, and the visited targets.
    fn price(&self, word: impl IntoIterator<Item = usize>) -> (f64, u64, Vec<usize>) {
        let targets = &self.problem.targets;
        // NaN marks a target that was not visited yet.
        let mut last_s = vec![f64::NAN; targets.len()];
        let (mut total, mut visits, mut seen) = (self.idle.1, 0_u64, Vec::new());
        self.fly(word, |stop| {
            visits += 1;
            if let (Some(target), Some(last_s)) = (targets.get(stop.target), last_s.get_mut(stop.target)) {
                if last_s.is_nan() {
                    *last_s = -target.initial_age_s;
                    total -= self.idle.0.get(stop.target).copied().unwrap_or(0.0);
                    seen.push(stop.target);
                }
                total += eci::interval_cost(target, *last_s, stop.end_s);
                *last_s = stop.end_s;
            }
        });
        let open = seen.iter().filter_map(|index| targets.get(*index).zip(last_s.get(*index)));
        total += open.map(|(target, last_s)| eci::interval_cost(target, *last_s, self.problem.horizon_s)).sum::<f64>();
        let evaluations = visits + seen.len() as u64;
        let visits_ns = evaluations * VISIT_NS + visits * self.departure_ns();
        (total, WORD_NS + visits_ns + targets.len() as u64 * TARGET_NS, seen)
    }

    /// Returns the expected cost of flying `cycle` again and again.
    pub fn cycle_cost(&self, cycle: &[usize], budget: &mut dyn Budget) -> f64 {
        self.cost(cycle.iter().copied().cycle(), budget)
    }

    /// Returns the flown part of `word`: cut where the visits end too late.
    pub fn flown(&self, word: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut flown = Vec::new();
        self.fly(word, |stop| flown.push(stop.target));
        flown
    }

    /// Returns the plan of flying `cycle` until the horizon.
    pub fn cycle_plan(&self, solver: &str, cycle: &[usize]) -> SurveillancePlan {
        let mut plan = self.plan(solver, cycle.iter().copied().cycle());
        plan.cycle = cycle.iter().filter_map(|index| self.name(*index)).collect();
        let lap = plan.cycle.len();
        plan.summary = format!("{} Repeats a cycle of {lap}: {}.", plan.summary, listed(&plan.cycle));
        plan
    }

    /// Returns the plan of flying `word`.
    pub fn plan(&self, solver: &str, word: impl IntoIterator<Item = usize>) -> SurveillancePlan {
        let mut stops = Vec::new();
        self.fly(word, |stop| stops.push(stop));
        let visits: Vec<SurveillanceVisit> = stops
            .iter()
            .filter_map(|stop| {
                Some(SurveillanceVisit { target: self.name(stop.target)?, arrive_s: stop.arrive_s, end_s: stop.end_s })
            })
            .collect();
        let expected = eci::expected_cost(self.problem, &visits);
        self.spend(visits.len() as u64 * WRITTEN_VISIT_NS + self.problem.targets.len() as u64 * WRITTEN_TARGET_NS);
        let left_out = self.left_out(&stops, expected.total);
        let seen = self.problem.targets.len() - left_out.len();
        let mut summary = format!(
            "{} visits to {seen} of {} targets in {:.0} s; expected cost of ignorance {:.4} ({:.4} without any visit).",
            visits.len(),
            self.problem.targets.len(),
            self.problem.horizon_s,
            expected.total,
            self.idle.1
        );
        if self.usable.is_empty() {
            let reasons = left_out.iter().take(3).map(|LeftOut { target, reason, .. }| format!("{target} {reason}"));
            summary = format!("No target can be observed: {}. {summary}", reasons.collect::<Vec<String>>().join("; "));
        }
        let return_s = self
            .problem
            .return_to_base
            .then(|| stops.last().map_or(0.0, |s| s.end_s + self.problem.travel.to_base_at(s.target, s.end_s)));
        SurveillancePlan {
            solver: solver.to_string(),
            cycle: Vec::new(),
            visits,
            return_s,
            expected_cost: expected.total,
            expected_cost_bound: None,
            left_out,
            summary,
        }
    }

    fn name(&self, index: usize) -> Option<String> {
        self.problem.targets.get(index).map(|target| target.name.clone())
    }

    /// Returns the unvisited targets, each with the reason: impossible, or the effect of a visit on the cost.
    fn left_out(&self, stops: &[Stop], cost: f64) -> Vec<LeftOut> {
        let mut seen = vec![false; self.problem.targets.len()];
        for stop in stops {
            if let Some(flag) = seen.get_mut(stop.target) {
                *flag = true;
            }
        }
        let word: Vec<usize> = stops.iter().map(|stop| stop.target).collect();
        let mut usable = vec![false; seen.len()];
        for index in &self.usable {
            if let Some(flag) = usable.get_mut(*index) {
                *flag = true;
            }
        }
        let unseen: Vec<usize> = seen.iter().enumerate().filter(|(_, seen)| !**seen).map(|(index, _)| index).collect();
        let places_max = INSERTED_VISITS_MAX / (unseen.len() * word.len()).max(1);
        unseen
            .into_iter()
            .filter_map(|index| {
                let reason = if usable.get(index) == Some(&true) {
                    self.unwanted_reason(&word, index, cost, places_max)
                } else {
                    self.unusable_reason(index)
                };
                Some(reason.of(self.name(index)?))
            })
            .collect()
    }

    /// Returns the effect on the cost of one visit of the target, at the place in the word where it costs least.
    fn unwanted_reason(&self, word: &[usize], index: usize, cost: f64, places_max: usize) -> LeftOutReason {
        let places = self.places_for(word, index);
        let (nearest, end) = (places.get(1).copied().unwrap_or_default(), word.len());
        let mut best = f64::INFINITY;
        for at in places.into_iter().take(places_max.max(2)) {
            let (with, ns) = self.price_with(word, index, at);
            // In a short word all places are charged like two, each flown twice, so that reasons do not displace the search.
            let is_charged = word.len() > SHORT_WORD || at == nearest || at == end;
            self.spend(if is_charged { 2 * ns } else { 0 });
            best = best.min(with.unwrap_or(f64::INFINITY));
        }
        if best.is_infinite() {
            return "no time is left for it among the others".into();
        }
        if best > cost {
            Obstacle::ExpectedCost { without: cost, with: best }.into()
        } else {
            format!("this plan has no visit of it; one single visit would give {best:.4} instead of {cost:.4}").into()
        }
    }

    /// Returns the places in the word at which one more visit of the target can be inserted: the end, then by rising detour.
    fn places_for(&self, word: &[usize], index: usize) -> Vec<usize> {
        let travel = &self.typical;
        let detour_s = |at: usize| {
            let before = at.checked_sub(1).and_then(|before| word.get(before));
            let (leg_s, old_s) = match (before, word.get(at)) {
                (Some(from), Some(to)) => (travel.between(*from, index), travel.between(*from, *to)),
                (None, Some(to)) => (travel.start_to(index), travel.start_to(*to)),
                // A visit at the end delays no other one.
                (_, None) => return f64::NEG_INFINITY,
            };
            leg_s - old_s + word.get(at).map_or(0.0, |to| travel.between(index, *to))
        };
        let mut places: Vec<(f64, usize)> = (0..=word.len()).map(|at| (detour_s(at), at)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.spend(word.len() as u64 * ENTRY_NS);
        places.into_iter().map(|(_, at)| at).collect()
    }

    /// Returns the cost of the word with a visit of the target at place `at` (`None` if it is too late), and the work in nanoseconds.
    fn price_with(&self, word: &[usize], index: usize, at: usize) -> (Option<f64>, u64) {
        let (before, after) = word.split_at_checked(at).unwrap_or((word, &[]));
        let longer = before.iter().copied().chain([index]).chain(after.iter().copied());
        let (with, ns, seen) = self.price(longer);
        (seen.contains(&index).then_some(with), ns)
    }

    fn unusable_reason(&self, index: usize) -> LeftOutReason {
        let travel = &self.problem.travel;
        let there_s = travel.start_to(index);
        if there_s >= UNREACHABLE_S {
            return "cannot be reached from the start, nor in time via other targets".into();
        }
        let dwell_s = self.problem.targets.get(index).map_or(0.0, |target| target.dwell_s);
        let home_s = if self.problem.return_to_base { travel.to_base_at(index, there_s + dwell_s) } else { 0.0 };
        if home_s >= UNREACHABLE_S {
            return "leaves no way back to the base".into();
        }
        let over_s = there_s + dwell_s + home_s - self.limit_s;
        if self.limit_s < self.problem.horizon_s {
            let text = format!("needs {:.0} s more than endurance leaves", libm::ceil(over_s));
            let limit = TimeLimit::Flight { name: "endurance".to_string(), cause: None, is_energy: true };
            return LeftOutReason { text, obstacle: Some(Obstacle::Late { over_s, limit, alone: false }) };
        }
        Obstacle::Late { over_s, limit: TimeLimit::Horizon, alone: false }.into()
    }
}

fn listed(names: &[String]) -> String {
    match names.get(..12) {
        Some(first) if names.len() > 12 => format!("{}, ..", first.join(", ")),
        _ => names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::surveillance as examples;
    use crate::solver::WorkBudget;

    #[test]
    fn the_fast_cost_is_the_metric() {
        let problem = examples::random(5, 11);
        let scenario = Scenario::new(&problem).unwrap();
        let word = [0, 3, 1, 1, 4, 2, 0, 3];
        let plan = scenario.plan("test", word);
        let quick = scenario.cost(word, &mut WorkBudget::new(1000));
        assert!((plan.expected_cost - quick).abs() < 1e-9 * quick);
        assert_eq!(plan.visits.len(), 8);
    }

    #[test]
    fn targets_out_of_reach_are_named_with_their_reason() {
        let mut problem = examples::random(3, 1);
        problem.travel.from_start_s[0] = UNREACHABLE_S;
        problem.travel.from_start_s[1] = 5000.0;
        assert_eq!(Scenario::new(&problem).unwrap().usable(), [0, 1, 2], "by way of the third one");
        problem.travel.between_s.iter_mut().for_each(|row| (row[0], row[1]) = (UNREACHABLE_S, 5000.0));
        let scenario = Scenario::new(&problem).unwrap();
        let plan = scenario.cycle_plan("test", &[2]);
        assert_eq!(plan.left_out[0].reason, "cannot be reached from the start, nor in time via other targets");
        assert_eq!(plan.left_out[1].reason, "needs 1410 s more than the horizon allows");
        problem.travel.from_start_s[2] = 9000.0;
        let message = Scenario::new(&problem).unwrap().plan("test", []).summary;
        assert!(message.starts_with("No target can be observed: ") && message.contains("horizon"), "{message}");
    }

    #[test]
    fn the_return_is_kept_within_endurance() {
        let mut problem = examples::random(4, 5);
        problem.return_to_base = true;
        problem.endurance_s = Some(1200.0);
        let scenario = Scenario::new(&problem).unwrap();
        let plan = scenario.cycle_plan("test", &[0, 1, 2, 3]);
        assert!(plan.return_s.unwrap() <= 1200.0 && plan.return_s.unwrap() > 900.0);
    }
}

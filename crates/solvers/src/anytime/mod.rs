//! The anytime planner: annealing over words of visits, begun from the best plan of the other planners.
//!
//! A word may visit a target as often as it likes in any order, so it can do what a cycle cannot: see some targets every
//! other lap, and bend the end of the mission to its horizon. Rounds of cooling follow each other, each from the best word
//! so far, until the budget is exhausted or rounds bring nothing more.
//! Bound: none but the budget; after [`STALE_ROUNDS_MAX`] rounds without gain it ends by itself.

use crate::random::Generator;
use crate::surveillance::scenario::Scenario;
use crate::{two_opt, wam};
use apex_model::problem::{Plan, Problem};
use apex_model::solver::{Budget, Environment, Solver};

/// Work of each of the planners it starts from, in stages: a quick look at both before a thorough one at either.
pub const SEED_UNITS: &[u64] = &[10_000, 60_000, 400_000];
/// Rounds in a row without gain after which the search ends.
pub const STALE_ROUNDS_MAX: u32 = 6;
/// Moves tried in one round of cooling.
const ROUND_MOVES: u32 = 6_000;
/// Temperature at a round's beginning and end, as a share of the cost.
const HOT: f64 = 3e-3;
const COLD: f64 = 1e-5;
/// Letters kept beyond what is flown: they come into play when the word gets quicker.
const SPARE_LETTERS: usize = 8;

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct Anytime;

impl Solver for Anytime {
    fn name(&self) -> &'static str {
        "anytime"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else {
            return Err("anytime plans surveillance only.".to_string());
        };
        let scenario = Scenario::new(problem)?;
        let report = &mut *environment.report;
        let mut tell = |word: &[usize]| {
            report(&Plan::Surveillance(scenario.plan("anytime", word.iter().copied())));
        };
        let start = first_word(&scenario, environment.budget);
        tell(&start);
        let mut search =
            Search { scenario: &scenario, budget: &mut *environment.budget, random: Generator::new(environment.seed) };
        let word = search.run(start, &mut tell);
        Ok(Plan::Surveillance(scenario.plan(self.name(), word)))
    }
}

/// A part of a budget: exhausted after `allowed` further units, or with the whole.
struct Share<'a> {
    whole: &'a mut dyn Budget,
    until: u64,
}

impl Budget for Share<'_> {
    fn charge(&mut self, units: u64) {
        self.whole.charge(units);
    }
    fn exhausted(&self) -> bool {
        self.whole.exhausted() || self.whole.used() >= self.until
    }
    fn used(&self) -> u64 {
        self.whole.used()
    }
}

/// The better of the best cycle and WAM's word, each given more work from stage to stage.
fn first_word(scenario: &Scenario<'_>, budget: &mut dyn Budget) -> Vec<usize> {
    let mut best: (f64, Vec<usize>) = (f64::INFINITY, Vec::new());
    for units in SEED_UNITS {
        let until = budget.used().saturating_add(*units);
        let cycle = two_opt::best_cycle(scenario, &mut Share { whole: &mut *budget, until }, &mut |_| {});
        let until = budget.used().saturating_add(*units);
        let word = wam::best_word(scenario, &mut Share { whole: &mut *budget, until }, &mut |_| {});
        for word in [scenario.flown(cycle.iter().copied().cycle()), word] {
            let cost = scenario.cost(word.iter().copied(), budget);
            if best.1.is_empty() || cost < best.0 {
                best = (cost, word);
            }
        }
        if budget.exhausted() {
            break;
        }
    }
    best.1
}

struct Search<'s, 'p> {
    scenario: &'s Scenario<'p>,
    budget: &'s mut dyn Budget,
    random: Generator,
}

impl Search<'_, '_> {
    /// Rounds of cooling from `word` until the budget ends or nothing more is gained; returns the best word.
    fn run(&mut self, word: Vec<usize>, tell: &mut dyn FnMut(&[usize])) -> Vec<usize> {
        let mut best = word;
        let mut best_cost = self.cost(&best);
        let mut stale = 0;
        while stale < STALE_ROUNDS_MAX && !self.budget.exhausted() {
            let (word, cost) = self.round(&best, best_cost);
            stale += 1;
            if cost < best_cost * (1.0 - 1e-9) {
                if cost < best_cost * (1.0 - 1e-5) {
                    stale = 0;
                }
                best = self.scenario.flown(word);
                best_cost = cost;
                tell(&best);
            }
        }
        best
    }

    fn cost(&mut self, word: &[usize]) -> f64 {
        self.scenario.cost(word.iter().copied(), self.budget)
    }

    /// One round of cooling; returns the best word seen with its cost.
    fn round(&mut self, start: &[usize], start_cost: f64) -> (Vec<usize>, f64) {
        let mut word = self.with_spares(start);
        let mut cost = start_cost;
        let mut best = (word.clone(), cost);
        for step in 0..ROUND_MOVES {
            if self.budget.exhausted() {
                break;
            }
            let share = f64::from(step) / f64::from(ROUND_MOVES);
            let temperature = start_cost.abs() * HOT * libm::pow(COLD / HOT, share);
            let Some(next) = self.neighbour(&word) else { break };
            let next_cost = self.cost(&next);
            // The threshold of Metropolis: an increase passes with probability exp(-increase / temperature).
            if next_cost <= cost - temperature * libm::log(self.random.unit().max(1e-300)) {
                (word, cost) = (next, next_cost);
                if cost < best.1 {
                    best = (word.clone(), cost);
                }
            }
        }
        best
    }

    fn with_spares(&mut self, word: &[usize]) -> Vec<usize> {
        let mut longer = word.to_vec();
        let length = longer.len();
        for _ in 0..SPARE_LETTERS {
            longer.extend(word.get(self.random.below(length)).copied());
        }
        longer
    }

    /// A word that differs in one place: a letter replaced, inserted, removed or moved, two exchanged, or a part turned.
    fn neighbour(&mut self, word: &[usize]) -> Option<Vec<usize>> {
        let mut next = word.to_vec();
        let length = next.len();
        if length == 0 {
            return None;
        }
        let at = self.random.below(length);
        let usable = self.scenario.usable();
        let letter = *usable.get(self.random.below(usable.len()))?;
        match self.random.below(6) {
            0 => *next.get_mut(at)? = letter,
            1 => {
                next.insert(at, letter);
                next.truncate(length + SPARE_LETTERS);
            }
            2 if length > 1 => {
                next.remove(at);
            }
            3 => {
                let moved = next.remove(at);
                let near = (at + self.random.below(13)).saturating_sub(6).min(next.len());
                next.insert(near, moved);
            }
            4 => next.swap(at, self.random.below(length)),
            _ => {
                let until = (at + 2 + self.random.below(6)).min(length);
                next.get_mut(at..until)?.reverse();
            }
        }
        // Removed letters are made up for at the end, so that the word does not run dry.
        while next.len() < word.len() {
            next.push(letter);
        }
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surveillance::examples;
    use apex_model::problem::SurveillanceProblem;
    use apex_model::solver::WorkBudget;

    fn cost(solver: &dyn Solver, problem: &SurveillanceProblem, units: u64) -> f64 {
        let mut budget = WorkBudget::new(units);
        let mut environment = Environment { seed: 5, budget: &mut budget, report: &mut |_| {} };
        match solver.solve(&Problem::Surveillance(problem.clone()), &mut environment).unwrap() {
            Plan::Surveillance(plan) => plan.expected_cost,
            Plan::SingleVisit(_) => panic!("a surveillance problem has a surveillance plan"),
        }
    }

    #[test]
    fn never_worse_than_the_planners_it_starts_from() {
        for seed in 0..4 {
            let problem = examples::random(8, seed);
            let best = cost(&two_opt::TwoOpt, &problem, 400_000).min(cost(&wam::Wam, &problem, 400_000));
            let found = cost(&Anytime, &problem, 2_000_000);
            assert!(found <= best * (1.0 + 1e-9), "{found} {best}");
        }
    }

    #[test]
    fn the_best_of_all_short_words_is_found() {
        // Three visits fit; all words of three letters over four targets are tried.
        let mut problem = examples::random(4, 21);
        problem.horizon_s = 260.0;
        let scenario = Scenario::new(&problem).unwrap();
        let mut least = f64::INFINITY;
        for number in 0..4_usize.pow(6) {
            let word = (0..6).map(|place| number / 4_usize.pow(place) % 4);
            least = least.min(scenario.cost(word, &mut WorkBudget::new(u64::MAX)));
        }
        let found = cost(&Anytime, &problem, 1_000_000);
        assert!(found <= least * (1.0 + 1e-9), "{found} {least}");
    }

    #[test]
    fn better_plans_are_reported_on_the_way() {
        let problem = Problem::Surveillance(examples::random(10, 2));
        let mut costs = Vec::new();
        let mut report = |plan: &Plan| {
            if let Plan::Surveillance(plan) = plan {
                costs.push(plan.expected_cost);
            }
        };
        let mut budget = WorkBudget::new(3_000_000);
        Anytime.solve(&problem, &mut Environment { seed: 1, budget: &mut budget, report: &mut report }).unwrap();
        assert!(costs.len() > 1 && costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
    }
}

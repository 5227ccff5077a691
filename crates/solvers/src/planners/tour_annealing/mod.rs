//! The anytime planner: annealing over tours of visits, starting from the best plan of the other planners.
//!
//! A tour may visit a target any number of times in any order, so it can express plans that a cycle cannot: visits in every second lap,
//! and a last lap fitted to the horizon. Annealing runs follow each other, each longer than the previous one and starting from the best
//! tour so far, until the budget is exhausted or runs stop improving it. In between, tours of other start heuristics are tried
//! ([starts]). A change of a tour is evaluated from its [timetable](timetable), without a new simulation.
//! Bound: the budget; the search ends early after [`STALE_ROUNDS_MAX`] rounds without gain.

mod annealing;
mod change;
mod interval;
mod moves;
mod rows;
mod starts;
mod timetable;
mod tour_evaluation;

use annealing::{Annealing, Round};
use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Budget, Environment, Solver};
use apex_planning::surveillance::scenario::Scenario;
use starts::Starts;

/// Rounds in a row without gain after which the search ends.
pub const STALE_ROUNDS_MAX: u32 = 24;
/// Moves of the first round per visit, with minimum and maximum; each round has half as many again as the previous one.
const FIRST_MOVES: (u64, u64, u64) = (150, 2_000, 20_000);
/// Maximum number of moves of a round.
const ROUND_MOVES_MAX: u64 = 2_000_000;
/// Initial and final temperature of a round, as multiples of the mean cost of a visit of the tour.
const TEMPERATURES: (f64, f64) = (5e-2, 5e-4);
/// Temperatures of every third round without gain: high enough at first to leave a local minimum.
const REHEATED: (f64, f64) = (3e-1, 5e-4);
/// Maximum number of visits that lowers the temperature: longer tours would stay in their first local minimum.
const COOL_VISITS_MAX: usize = 100;

/// The planner.
#[derive(Clone, Copy, Debug, Default)]
pub struct TourAnnealing;

impl Solver for TourAnnealing {
    fn name(&self) -> &'static str {
        "anytime"
    }

    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else {
            return Err("the solver `anytime` accepts surveillance problems only".to_string());
        };
        let scenario = Scenario::new(problem)?;
        let report = &mut *environment.report;
        let mut tell = |tour: &[usize]| {
            report(&Plan::Surveillance(scenario.plan("anytime", tour.iter().copied())));
        };
        let start = starts::first(&scenario, environment.previous, environment.budget);
        tell(&start);
        let tour = search(&scenario, start, environment.seed, &mut *environment.budget, &mut tell);
        Ok(Plan::Surveillance(scenario.plan(self.name(), tour)))
    }
}

/// A part of a budget: exhausted when the whole is, or when `until` units of the whole are used.
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

/// Runs annealing rounds until the budget ends or rounds stop improving the tour; returns the best tour.
fn search(
    scenario: &Scenario<'_>,
    start: Vec<usize>,
    seed: u64,
    budget: &mut dyn Budget,
    tell: &mut dyn FnMut(&[usize]),
) -> Vec<usize> {
    let mut annealing = Annealing::new(scenario, seed);
    let mut best = (scenario.cost(start.iter().copied(), budget), start);
    let (per_visit, least, most) = FIRST_MOVES;
    let (mut moves, mut stale) = ((best.1.len() as u64 * per_visit).clamp(least, most), 0_u32);
    let mut starts = Starts::new(scenario, budget.used());
    while stale < STALE_ROUNDS_MAX && !budget.exhausted() {
        stale += 1;
        let temperatures = if stale.is_multiple_of(3) { REHEATED } else { TEMPERATURES };
        let mut found = annealing.round(&best.1, round(&best.1, moves, temperatures), budget);
        if let Some(better) = starts.try_next(&mut annealing, moves, found.0.min(best.0), budget) {
            found = better;
        }
        moves = (moves + moves / 2).min(ROUND_MOVES_MAX);
        if found.0 < best.0 * (1.0 - 1e-9) {
            if found.0 < best.0 * (1.0 - 1e-5) {
                stale = 0;
            }
            best = found;
            tell(&best.1);
        }
    }
    best.1
}

/// Returns the parameters of a round from `tour`; temperatures are given as multiples of the mean cost of a visit.
fn round(tour: &[usize], moves: u64, (hot, cold): (f64, f64)) -> Round {
    let visits = tour.len().clamp(1, COOL_VISITS_MAX) as f64;
    Round { moves, hot: hot / visits, cold: cold / visits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planners::{two_opt, wam};
    use apex_model::problem::SurveillanceProblem;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;

    #[test]
    fn the_plan_before_is_where_it_begins() {
        let problem = Problem::Surveillance(examples::random(12, 4));
        let plan = |units, previous: Option<&Plan>| {
            let mut budget = WorkBudget::new(units);
            let mut environment = Environment { seed: 3, budget: &mut budget, report: &mut |_| {}, previous };
            match TourAnnealing.solve(&problem, &mut environment).unwrap() {
                Plan::Surveillance(plan) => plan,
                Plan::SingleVisit(_) => panic!("the plan is of another kind"),
            }
        };
        let (quick, long) = (plan(1, None), plan(300_000, None));
        assert!(long.expected_cost < quick.expected_cost);
        let long = Plan::Surveillance(long);
        let again = plan(1, Some(&long));
        assert_eq!(
            again.visits,
            match &long {
                Plan::Surveillance(long) => long.visits.clone(),
                Plan::SingleVisit(_) => Vec::new(),
            }
        );
        let mut other = long.clone();
        if let Plan::Surveillance(other) = &mut other {
            other.visits[0].target = "gone".into();
        }
        assert!(plan(1, Some(&other)).expected_cost < quick.expected_cost, "a target that is gone is left out");
    }

    fn cost(solver: &dyn Solver, problem: &SurveillanceProblem, units: u64) -> f64 {
        let mut budget = WorkBudget::new(units);
        let mut environment = Environment { seed: 5, budget: &mut budget, report: &mut |_| {}, previous: None };
        match solver.solve(&Problem::Surveillance(problem.clone()), &mut environment).unwrap() {
            Plan::Surveillance(plan) => plan.expected_cost,
            Plan::SingleVisit(_) => panic!("a surveillance problem has a surveillance plan"),
        }
    }

    #[test]
    fn never_worse_than_the_planners_it_starts_from() {
        for seed in 0..4 {
            let problem = examples::random(8, seed);
            let best = cost(&two_opt::TwoOpt, &problem, 40_000).min(cost(&wam::Wam, &problem, 40_000));
            let found = cost(&TourAnnealing, &problem, 40_000);
            assert!(found <= best * (1.0 + 1e-9), "{found} {best}");
        }
    }

    #[test]
    fn the_best_of_all_short_tours_is_found() {
        // Three visits fit into the horizon; the test enumerates all sequences of three of the four targets.
        let mut problem = examples::random(4, 21);
        problem.horizon_s = 260.0;
        let scenario = Scenario::new(&problem).unwrap();
        let mut least = f64::INFINITY;
        for number in 0..4_usize.pow(6) {
            let tour = (0..6).map(|place| number / 4_usize.pow(place) % 4);
            least = least.min(scenario.cost(tour, &mut WorkBudget::new(u64::MAX)));
        }
        let found = cost(&TourAnnealing, &problem, 20_000);
        assert!(found <= least * (1.0 + 1e-9), "{found} {least}");
    }

    #[test]
    fn the_vehicle_stays_where_staying_is_best() {
        // The targets are far apart: the best tours observe one target about twenty times before they leave it.
        let cell: apex_portfolio::cell::Cell = "large-uniform-uniform-4-globular".parse().unwrap();
        let found = cost(&TourAnnealing, &cell.mission(0), 100_000);
        assert!(found < 1_435.0, "{found}, where words that hardly stay cost 1442");
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
        let mut budget = WorkBudget::new(30_000);
        TourAnnealing
            .solve(&problem, &mut Environment { seed: 1, budget: &mut budget, report: &mut report, previous: None })
            .unwrap();
        assert!(costs.len() > 1 && costs.windows(2).all(|pair| pair[1] < pair[0]), "{costs:?}");
    }
}

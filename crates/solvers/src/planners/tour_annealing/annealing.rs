//! Annealing: accepts changes that raise the cost with a probability that falls with the increase and with cooling.

use super::moves::{self, Draw};
use super::tour_evaluation::TourEvaluation;
use apex_planning::random::Generator;
use apex_planning::solver::Budget;
use apex_planning::surveillance::scenario::Scenario;

/// Number of spare visits at the end of a tour: they are too late now, and are flown when a change makes the tour faster.
const SPARE_LETTERS: usize = 12;
/// Number of targets that count as near to a target.
const NEAR_MAX: usize = 6;
/// Moves between two checks of the budget and two steps of temperature.
const STRIDE: u64 = 64;

/// Work of examining a target in the search for near ones, and of proposing a change, in nanoseconds.
const NEAR_NS: u64 = 12;
const PROPOSAL_NS: u64 = 80;

/// One annealing run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Round {
    /// Moves tried.
    pub(super) moves: u64,
    /// Temperature at the beginning, as a share of the cost.
    pub(super) hot: f64,
    /// Temperature at the end.
    pub(super) cold: f64,
}

impl Round {
    /// Returns the temperature after a number of moves, for tours that cost about `scale`.
    pub(super) fn temperature(&self, scale: f64, step: u64) -> f64 {
        let share = step as f64 / self.moves.max(1) as f64;
        scale * self.hot * libm::pow(self.cold / self.hot, share)
    }
}

/// Returns true if an increase passes the Metropolis criterion, with probability exp(-increase / temperature). Moves that change nothing do
/// not pass.
pub(super) fn passes(increase: f64, temperature: f64, chance: f64) -> bool {
    increase < 0.0
        || increase > 0.0 && increase <= 40.0 * temperature && increase <= -temperature * libm::log(chance.max(1e-300))
}

/// A tour that was found, with its cost.
pub(super) type CostedTour = (f64, Vec<usize>);

/// State that all rounds share.
pub(super) struct Annealing<'s, 'p> {
    pub(super) scenario: &'s Scenario<'p>,
    pub(super) near: Vec<Vec<usize>>,
    pub(super) random: Generator,
}

impl<'s, 'p> Annealing<'s, 'p> {
    pub(super) fn new(scenario: &'s Scenario<'p>, seed: u64) -> Annealing<'s, 'p> {
        let travel = scenario.typical();
        let near = (0..scenario.problem().targets.len()).map(|from| {
            let mut near: Vec<usize> = scenario.usable().iter().copied().filter(|to| *to != from).collect();
            let nearer = |a: &usize, b: &usize| {
                travel.between(from, *a).total_cmp(&travel.between(from, *b)).then_with(|| a.cmp(b))
            };
            if near.len() > NEAR_MAX {
                near.select_nth_unstable_by(NEAR_MAX, nearer);
                near.truncate(NEAR_MAX);
            }
            near.sort_by(nearer);
            near
        });
        let count = scenario.usable().len() as u64;
        scenario.spend(count * count * NEAR_NS);
        Annealing { scenario, near: near.collect(), random: Generator::new(seed) }
    }

    /// Runs one round from `start`; returns the best tour found in it.
    pub(super) fn round(&mut self, start: &[usize], round: Round, budget: &mut dyn Budget) -> CostedTour {
        let mut flight = TourEvaluation::new(self.scenario, self.with_spares(start), budget);
        let mut best: CostedTour = (flight.cost(), start.to_vec());
        let scale = flight.cost().abs();
        let mut temperature = 0.0;
        for step in 0..round.moves {
            if step.is_multiple_of(STRIDE) {
                if budget.exhausted() {
                    break;
                }
                temperature = round.temperature(scale, step);
            }
            if flight.flown() == 0 {
                break;
            }
            let (tour, flown, usable) = (flight.tour(), flight.flown(), self.scenario.usable());
            let mut draw = Draw { tour, flown, usable, near: &self.near, random: &mut self.random };
            self.scenario.spend(PROPOSAL_NS);
            let Some(change) = moves::propose(&mut draw) else { continue };
            let chance = self.random.unit();
            let increase = flight.cost_with(&change, budget) - flight.cost();
            if !passes(increase, temperature, chance) {
                continue;
            }
            flight.apply(&change, budget);
            self.keep_spares(&mut flight, budget);
            if flight.cost() < best.0 {
                best = (flight.cost(), flight.tour().get(..flight.flown()).unwrap_or(&[]).to_vec());
            }
        }
        best
    }

    fn with_spares(&mut self, tour: &[usize]) -> Vec<usize> {
        let mut longer = tour.to_vec();
        for _ in 0..SPARE_LETTERS {
            let usable = self.scenario.usable();
            longer.extend(usable.get(self.random.below(usable.len())).copied());
        }
        longer
    }

    /// Keeps the number of spare visits within limits.
    fn keep_spares(&mut self, flight: &mut TourEvaluation<'_, '_>, budget: &mut dyn Budget) {
        let spare = flight.tour().len().saturating_sub(flight.flown());
        if (SPARE_LETTERS / 3..=SPARE_LETTERS * 3).contains(&spare) {
            return;
        }
        let kept = flight.flown() + spare.min(SPARE_LETTERS);
        let mut tour = flight.tour().to_vec();
        tour.truncate(kept);
        if spare < SPARE_LETTERS {
            tour = self.with_spares(&tour);
        }
        flight.replace(tour, budget);
    }
}

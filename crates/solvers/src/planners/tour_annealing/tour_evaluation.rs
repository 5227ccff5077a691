//! A tour under search: evaluated by its timetable if costs have the fast formula, otherwise by flying it.

use super::change::Change;
use super::interval::Intervals;
use super::timetable::{NUMBERS_MAX, Timetable};
use apex_planning::solver::Budget;
use apex_planning::surveillance::scenario::Scenario;

/// A tour with its cost.
pub(super) enum TourEvaluation<'s, 'p> {
    /// Changes are priced without flying the tour.
    Quick(Box<Timetable<'s, 'p>>),
    /// Changes are evaluated by flying: for rates or travel times that change with time, costs that are neither linear nor saturating,
    /// very long tours, and ways home over other targets.
    Plain {
        /// The problem.
        scenario: &'s Scenario<'p>,
        /// The tour with its spare visits.
        tour: Vec<usize>,
        /// Number of flown visits.
        flown: usize,
        /// Cost of the tour.
        cost: f64,
    },
}

impl<'s, 'p> TourEvaluation<'s, 'p> {
    /// Returns a tour under search.
    pub(super) fn new(scenario: &'s Scenario<'p>, tour: Vec<usize>, budget: &mut dyn Budget) -> TourEvaluation<'s, 'p> {
        let numbers = (tour.len() + 1).saturating_mul(scenario.problem().targets.len());
        match Intervals::of(scenario.problem()) {
            Some(intervals)
                if numbers <= NUMBERS_MAX
                    && scenario.problem().travel.is_constant()
                    && !scenario.has_detours_home() =>
            {
                let table = Box::new(Timetable::new(scenario, intervals, tour));
                scenario.charge(table.change_ns(), budget);
                TourEvaluation::Quick(table)
            }
            _ => {
                let (cost, flown) = (scenario.cost(tour.iter().copied(), budget), scenario.flown(tour.iter().copied()));
                TourEvaluation::Plain { scenario, tour, flown: flown.len(), cost }
            }
        }
    }

    /// Returns the tour with its spare visits.
    pub(super) fn tour(&self) -> &[usize] {
        match self {
            TourEvaluation::Quick(table) => table.tour(),
            TourEvaluation::Plain { tour, .. } => tour,
        }
    }

    /// Returns the number of flown visits.
    pub(super) fn flown(&self) -> usize {
        match self {
            TourEvaluation::Quick(table) => table.flown(),
            TourEvaluation::Plain { flown, .. } => *flown,
        }
    }

    /// Returns the cost of the tour.
    pub(super) fn cost(&self) -> f64 {
        match self {
            TourEvaluation::Quick(table) => table.cost(),
            TourEvaluation::Plain { cost, .. } => *cost,
        }
    }

    /// Returns the cost of the tour with `change`.
    pub(super) fn cost_with(&mut self, change: &Change, budget: &mut dyn Budget) -> f64 {
        match self {
            TourEvaluation::Quick(table) => {
                table.scenario().charge(table.price_ns(change), budget);
                table.cost_with(change)
            }
            TourEvaluation::Plain { scenario, tour, .. } => {
                let (before, after) = (tour.get(..change.from), tour.get(change.until..));
                let before = before.unwrap_or(tour).iter().copied();
                let changed = before.chain(change.letters()).chain(after.unwrap_or(&[]).iter().copied());
                scenario.cost(changed, budget)
            }
        }
    }

    /// Carries `change` out.
    pub(super) fn apply(&mut self, change: &Change, budget: &mut dyn Budget) {
        match self {
            TourEvaluation::Quick(table) => {
                table.apply(change);
                table.scenario().charge(table.change_ns(), budget);
            }
            TourEvaluation::Plain { tour, .. } => {
                let mut tour = std::mem::take(tour);
                change.apply(&mut tour);
                self.replace(tour, budget);
            }
        }
    }

    /// Takes another tour.
    pub(super) fn replace(&mut self, next: Vec<usize>, budget: &mut dyn Budget) {
        match self {
            TourEvaluation::Quick(table) => {
                table.replace(next);
                table.scenario().charge(table.change_ns(), budget);
            }
            TourEvaluation::Plain { scenario, tour, flown, cost } => {
                *cost = scenario.cost(next.iter().copied(), budget);
                *flown = scenario.flown(next.iter().copied()).len();
                *tour = next;
            }
        }
    }
}

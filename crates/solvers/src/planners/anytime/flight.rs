//! A word under search: priced by its timetable where costs have the quick formula, else by flying it.

use super::change::Change;
use super::interval::Intervals;
use super::timetable::{NUMBERS_MAX, Timetable};
use apex_planning::solver::Budget;
use apex_planning::surveillance::scenario::Scenario;

/// A word with its cost.
pub(super) enum Flight<'s, 'p> {
    /// Changes are priced without flying the word.
    Quick(Box<Timetable<'s, 'p>>),
    /// Changes are flown: rates or travel times that change with time, steps, tables, very long words.
    Plain {
        /// The problem.
        scenario: &'s Scenario<'p>,
        /// The word with its spare letters.
        word: Vec<usize>,
        /// Visits that are flown.
        flown: usize,
        /// Cost of the word.
        cost: f64,
    },
}

impl<'s, 'p> Flight<'s, 'p> {
    /// A word under search.
    pub(super) fn new(scenario: &'s Scenario<'p>, word: Vec<usize>, budget: &mut dyn Budget) -> Flight<'s, 'p> {
        let numbers = (word.len() + 1).saturating_mul(scenario.problem().targets.len());
        match Intervals::of(scenario.problem()) {
            Some(intervals) if numbers <= NUMBERS_MAX && scenario.problem().travel.is_constant() => {
                let table = Box::new(Timetable::new(scenario, intervals, word));
                scenario.charge(table.change_ns(), budget);
                Flight::Quick(table)
            }
            _ => {
                let (cost, flown) = (scenario.cost(word.iter().copied(), budget), scenario.flown(word.iter().copied()));
                Flight::Plain { scenario, word, flown: flown.len(), cost }
            }
        }
    }

    /// The word with its spare letters.
    pub(super) fn word(&self) -> &[usize] {
        match self {
            Flight::Quick(table) => table.word(),
            Flight::Plain { word, .. } => word,
        }
    }

    /// Visits that are flown.
    pub(super) fn flown(&self) -> usize {
        match self {
            Flight::Quick(table) => table.flown(),
            Flight::Plain { flown, .. } => *flown,
        }
    }

    /// Its cost.
    pub(super) fn cost(&self) -> f64 {
        match self {
            Flight::Quick(table) => table.cost(),
            Flight::Plain { cost, .. } => *cost,
        }
    }

    /// Its cost with `change`.
    pub(super) fn cost_with(&mut self, change: &Change, budget: &mut dyn Budget) -> f64 {
        match self {
            Flight::Quick(table) => {
                table.scenario().charge(table.price_ns(change), budget);
                table.cost_with(change)
            }
            Flight::Plain { scenario, word, .. } => {
                let (before, after) = (word.get(..change.from), word.get(change.until..));
                let before = before.unwrap_or(word).iter().copied();
                let changed = before.chain(change.letters()).chain(after.unwrap_or(&[]).iter().copied());
                scenario.cost(changed, budget)
            }
        }
    }

    /// Carries `change` out.
    pub(super) fn apply(&mut self, change: &Change, budget: &mut dyn Budget) {
        match self {
            Flight::Quick(table) => {
                table.apply(change);
                table.scenario().charge(table.change_ns(), budget);
            }
            Flight::Plain { word, .. } => {
                let mut word = std::mem::take(word);
                change.apply(&mut word);
                self.replace(word, budget);
            }
        }
    }

    /// Takes another word.
    pub(super) fn replace(&mut self, next: Vec<usize>, budget: &mut dyn Budget) {
        match self {
            Flight::Quick(table) => {
                table.replace(next);
                table.scenario().charge(table.change_ns(), budget);
            }
            Flight::Plain { scenario, word, flown, cost } => {
                *cost = scenario.cost(next.iter().copied(), budget);
                *flown = scenario.flown(next.iter().copied()).len();
                *word = next;
            }
        }
    }
}

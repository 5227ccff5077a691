//! The profile table and solver selection (paper, section V.C): chooses the best planner by the features of a problem and the time for
//! deliberation, and states the reason as text.
//!
//! The table is data, `data/profile-table.csv`, derived from measurements ([`crate::profile`]). A mission is assigned to the cell nearest
//! to its features, and to the largest budget of the table within its time.
//! Bound: O(cells) after classification.

use crate::features::{self, Feature};
use crate::format_error::FormatError;
use crate::profile::conclusion::{self, Conclusion};
use apex_model::problem::{Problem, SurveillanceProblem};
use apex_model::time::Duration;
use apex_planning::Registry;
use apex_planning::solver::units_in;
use std::sync::OnceLock;

/// The table that ships with the product.
pub const PROFILE: &str = include_str!("../data/profile-table.csv");
/// Time assumed if no request states how long deliberation may take.
pub const BUDGET_DEFAULT: Duration = Duration(1_000_000_000);

/// The chosen planner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Its name.
    pub solver: String,
    /// Reason: the features, the cell, and its entry in the table.
    pub reason: String,
    /// True if operators plan such missions better according to the table; `solver` is the best one that is not an operator.
    pub people_plan_better: bool,
}

/// Name of the human operator among the planners of a table.
const PEOPLE: &str = "human";

/// A table: the best planner of each cell at each time for deliberation. `apex profile build --table` writes one. Planners that do not
/// ship are chosen by a table for which they were measured.
#[derive(Clone, Debug, PartialEq)]
pub struct ProfileTable(Vec<Conclusion>);

impl ProfileTable {
    /// Reads a table.
    ///
    /// # Errors
    /// The first place in `text` that is not understood, and why.
    pub fn read(text: &str) -> Result<ProfileTable, FormatError> {
        conclusion::read(text).map(ProfileTable)
    }

    /// Chooses one of `planners` for `problem` with `budget_units` of work, like [`select_within`] by the shipped table.
    pub fn select(&self, problem: &Problem, budget_units: u64, planners: &Registry) -> Selection {
        by_table(&self.0, problem, budget_units, planners)
    }
}

/// Chooses one of `planners` for `problem` with a second of deliberation.
pub fn select(problem: &Problem, planners: &Registry) -> Selection {
    select_within(problem, units_in(BUDGET_DEFAULT), planners)
}

/// Chooses one of `planners` for `problem` with `budget_units` of work (`apex_planning::solver::WORK_UNIT`): by the shipped table, or the
/// first planner that serves a problem that no table describes.
pub fn select_within(problem: &Problem, budget_units: u64, planners: &Registry) -> Selection {
    static TABLE: OnceLock<Result<Vec<Conclusion>, String>> = OnceLock::new();
    let read = || conclusion::read(PROFILE).map_err(|trouble| format!("profile-table.csv:{trouble}"));
    match TABLE.get_or_init(read) {
        Ok(table) => by_table(table, problem, budget_units, planners),
        Err(trouble) => fallback(problem, trouble, planners),
    }
}

fn by_table(table: &[Conclusion], problem: &Problem, budget_units: u64, planners: &Registry) -> Selection {
    match problem {
        Problem::Surveillance(surveillance) => {
            of_surveillance(table, surveillance, budget_units).unwrap_or_else(|trouble| {
                fallback(problem, &format!("the problem cannot be looked up: {trouble}"), planners)
            })
        }
        Problem::SingleVisit(single_visit) => {
            let count = single_visit.targets.len();
            fallback(problem, &format!("{count} targets: the planner for missions of single visits"), planners)
        }
    }
}

fn of_surveillance(
    table: &[Conclusion],
    problem: &SurveillanceProblem,
    budget_units: u64,
) -> Result<Selection, String> {
    let features = features::classify(problem)?;
    let entry = look_up(table, &features, budget_units).ok_or("the profile table is empty")?;
    let mut reason = format!(
        "{}; nearest in the profile table is {}, where {}",
        features::described(&features),
        entry.cell,
        entry.words()
    );
    let people_plan_better = entry.best == PEOPLE;
    if !people_plan_better {
        return Ok(Selection { solver: entry.best.clone(), reason, people_plan_better });
    }
    if entry.next == PEOPLE {
        return Err(format!("{} names no planner except `human`", entry.cell));
    }
    reason += &format!("; {} plans until an operator does", entry.next);
    Ok(Selection { solver: entry.next.clone(), reason, people_plan_better })
}

/// Returns the line of the nearest cell at the largest budget that is not above `budget_units`, or at the smallest of all.
fn look_up<'a>(table: &'a [Conclusion], features: &[Feature], budget_units: u64) -> Option<&'a Conclusion> {
    let distance = |entry: &Conclusion| -> f64 {
        let words = entry.cell.words();
        let of = |(name, word): &(&str, String)| {
            features.iter().find(|feature| feature.name == *name).and_then(|feature| feature.distance(word))
        };
        words.iter().filter_map(of).sum()
    };
    let within = |entry: &&Conclusion| entry.budget_units <= budget_units;
    let budget = table.iter().filter(within).map(|entry| entry.budget_units).max();
    let budget = budget.or_else(|| table.iter().map(|entry| entry.budget_units).min())?;
    let entries = table.iter().filter(|entry| entry.budget_units == budget);
    let measured = entries.map(|entry| (distance(entry), entry));
    measured.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, entry)| entry)
}

/// Returns the first planner that serves the problem.
fn fallback(problem: &Problem, reason: &str, planners: &Registry) -> Selection {
    let serves = planners.iter().find(|solver| solver.serves(problem));
    let solver = serves.map_or_else(|| "none".to_string(), |solver| solver.name().to_string());
    Selection { solver, reason: reason.to_string(), people_plan_better: false }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Cell;
    use crate::profile::verdict::Verdict;
    use apex_planning::examples::single_visit as fires;
    use apex_planning::examples::surveillance as examples;
    use apex_solvers::shipped;

    #[test]
    fn every_line_names_a_planner_that_serves() {
        let problem = Problem::Surveillance(examples::random(4, 1));
        let table = conclusion::read(PROFILE).unwrap();
        assert!(table.len() >= 243);
        for entry in table {
            assert!(apex_solvers::solver(&entry.best).unwrap().serves(&problem), "{entry:?}");
        }
    }

    #[test]
    fn the_choice_depends_on_the_cell_and_on_time() {
        let cells = ["large-fixed-fixed-4-uniform", "small-clustered-clustered-16-two-cluster"];
        let entry = |cell: usize, budget_units, best: &str| Conclusion {
            cell: cells[cell].parse().unwrap(),
            budget_units,
            best: best.into(),
            verdict: Verdict::First,
            next: "nearest-neighbour".into(),
            effect_percent: 2.0,
        };
        let table = [entry(0, 100, "a"), entry(0, 1000, "b"), entry(1, 100, "c"), entry(1, 1000, "d")];
        let best = |cell: usize, number: u64, units: u64| {
            let cell: Cell = cells[cell].parse().unwrap();
            let features = features::classify(&cell.mission(number)).unwrap();
            look_up(&table, &features, units).unwrap().best.clone()
        };
        for number in 0..5 {
            assert_eq!([10, 100, 999].map(|units| best(0, number, units)), ["a", "a", "a"]);
            assert_eq!([1000, 10_000].map(|units| best(1, number, units)), ["d", "d"]);
        }
        assert_eq!(look_up(&[], &[], 1), None);
    }

    #[test]
    fn where_operators_plan_better_the_next_best_plans_until_they_do() {
        let cell: Cell = "large-fixed-fixed-4-uniform".parse().unwrap();
        let problem = Problem::Surveillance(cell.mission(0));
        let (best, next) = ("human".to_string(), "wam".to_string());
        let entry = Conclusion { cell, budget_units: 1, best, verdict: Verdict::First, next, effect_percent: 3.0 };
        let selection = ProfileTable(vec![entry.clone()]).select(&problem, 1_000, &shipped());
        assert_eq!((selection.solver.as_str(), selection.people_plan_better), ("wam", true));
        assert!(
            selection.reason.ends_with("3.0 % before wam; wam plans until an operator does"),
            "{}",
            selection.reason
        );
        let nobody =
            ProfileTable(vec![Conclusion { next: "human".into(), ..entry }]).select(&problem, 1_000, &shipped());
        assert_eq!((nobody.solver.as_str(), nobody.people_plan_better), ("nearest-neighbour", false));
    }

    #[test]
    fn selection_says_why() {
        let selection = select(&Problem::Surveillance(examples::random(8, 1)), &shipped());
        assert_eq!(selection.solver, "anytime");
        for words in
            ["count 8 (targets 8)", "kappa", "silhouette", "nearest in the profile table is medium-", "where at"]
        {
            assert!(selection.reason.contains(words), "{words}: {}", selection.reason);
        }
        let fires = select(&Problem::SingleVisit(fires::western_states(40_000.0)), &shipped());
        assert_eq!(fires.solver, "single-visit");
    }

    #[test]
    fn a_problem_without_meaning_still_gets_an_answer() {
        let mut problem = examples::random(3, 1);
        problem.horizon_s = f64::NAN;
        let selection = select(&Problem::Surveillance(problem), &shipped());
        assert_eq!(selection.solver, "nearest-neighbour");
        assert!(selection.reason.contains("cannot be looked up"), "{}", selection.reason);
    }
}

//! The published profile (the paper's Figure 4), and its agreement with a measured one.
//!
//! High agreement is not expected: the original's generator and horizon are unknown, each of its cells seems to be one scenario, and its
//! first planner is a human operator.

use super::error::ProfileError;
use super::verdict::{Comparison, Verdict};
use super::{Profile, budget_words, verdict};
use crate::cell::Cell;
use serde_json::{Value, json};
use std::fmt::Write;

/// Cells with their codes.
const FIGURE_4: &str = include_str!("../../data/figure-4.csv");
/// Meanings of the codes, in the order of the figure's legend.
pub const LEGEND: [&str; 4] = ["Human", "2-Opt", "WAM", "no difference"];
/// Our planners that correspond to the codes 1 and 2.
pub const PLANNERS: [&str; 2] = ["two-opt", "wam"];

/// Returns the code of every cell, as printed.
pub fn codes() -> Vec<(Cell, usize)> {
    let lines = FIGURE_4.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .filter_map(|line| line.split_once(','))
        .filter_map(|(cell, code)| cell.parse().ok().zip(code.parse().ok()))
        .collect()
}

/// Returns our comparison as a code of the figure: 1 and 2 for a winner, 3 for no difference, `None` if undecided.
pub fn code(comparison: &Comparison) -> Option<usize> {
    match comparison.verdict {
        Verdict::First => Some(1),
        Verdict::Second => Some(2),
        Verdict::NoDifference => Some(3),
        Verdict::Undecided => None,
    }
}

/// Counts how often each published code (row) met each of ours: 1, 2, 3, undecided (columns). `None` if a planner is
/// missing.
fn agreement(profile: &Profile, budget: usize) -> Option<[[usize; 4]; 4]> {
    let [first, second] = PLANNERS.map(|name| profile.planner(name));
    let compared = verdict::pair(profile, budget, first?, second?);
    let published = codes();
    let mut counts = [[0; 4]; 4];
    for (row, comparison) in profile.rows.iter().zip(&compared) {
        let Some((_, theirs)) = published.iter().find(|(cell, _)| *cell == row.cell) else { continue };
        let ours = code(comparison).map_or(3, |code| code - 1);
        if let Some(count) = counts.get_mut(*theirs).and_then(|row| row.get_mut(ours)) {
            *count += 1;
        }
    }
    Some(counts)
}

/// Agreement of a profile with the figure at one budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// The budget as text.
    pub budget: String,
    /// Number of meetings of each published code (row) with each of ours (column).
    pub counts: [[usize; 4]; 4],
}

impl Agreement {
    /// Returns the agreement of `profile` at a budget (index).
    ///
    /// # Errors
    /// If one of the figure's planners was not measured.
    pub fn of(profile: &Profile, budget: usize) -> Result<Agreement, ProfileError> {
        let counts = agreement(profile, budget).ok_or_else(not_answered)?;
        Ok(Agreement { budget: budget_words(profile.budgets.get(budget).copied().unwrap_or(0)), counts })
    }

    fn count(&self, theirs: usize, ours: usize) -> usize {
        self.counts.get(theirs).and_then(|row| row.get(ours)).copied().unwrap_or(0)
    }

    fn sum(&self, pairs: impl Iterator<Item = (usize, usize)>) -> usize {
        pairs.map(|(theirs, ours)| self.count(theirs, ours)).sum()
    }

    /// Returns the number of cells in which both agree.
    pub fn agreed(&self) -> usize {
        self.sum((1..4).map(|code| (code, code - 1)))
    }

    /// Returns the number of cells in which the figure's best is a program.
    pub fn comparable(&self) -> usize {
        self.sum((1..4).flat_map(|theirs| (0..4).map(move |ours| (theirs, ours))))
    }

    /// Returns the number of cells in which the figure's best is a human operator.
    pub fn human(&self) -> usize {
        self.sum((0..4).map(|ours| (0, ours)))
    }

    /// Returns the number of cells in which both name a winner.
    pub fn both_name_a_planner(&self) -> usize {
        self.sum([(1, 0), (1, 1), (2, 0), (2, 1)].into_iter())
    }

    /// Returns the number of cells in which both name the same winner.
    pub fn same_planner(&self) -> usize {
        self.sum([(1, 0), (2, 1)].into_iter())
    }

    /// Returns the agreement as an object for programs.
    pub fn json(&self) -> Value {
        json!({
            "budget": self.budget, "counts": self.counts, "agreed": self.agreed(), "comparable": self.comparable(),
            "human": self.human(), "both_name_a_planner": self.both_name_a_planner(),
            "same_planner": self.same_planner(),
        })
    }

    /// Returns the agreement as a table for operators.
    pub fn text(&self) -> String {
        let mut text = format!("Figure 4 (rows) and ours at {} (columns): 2-Opt or WAM\n", self.budget);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {:<16} {:>7} {:>7} {:>14} {:>10}", "", "2-Opt", "WAM", "no difference", "undecided");
        for (theirs, word) in LEGEND.iter().enumerate() {
            let [first, second, none, open] = [0, 1, 2, 3].map(|ours| self.count(theirs, ours));
            let _ = writeln!(text, "  {theirs} {word:<14} {first:>7} {second:>7} {none:>14} {open:>10}");
        }
        let _ = writeln!(
            text,
            "agreed in {} of {} cells; in {} the figure's best is a human planner, which we do not measure.\n\
             Where both name a planner ({} cells) it is the same in {}.\n",
            self.agreed(),
            self.comparable(),
            self.human(),
            self.both_name_a_planner(),
            self.same_planner()
        );
        text
    }
}

/// Returns a profile without the figure's planners.
pub(super) fn not_answered() -> ProfileError {
    ProfileError::new(
        "this profile cannot be compared with Figure 4",
        "add them with `apex profile update --planners two-opt,wam`",
    )
    .because("two-opt or wam was not measured")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_is_whole() {
        let codes = codes();
        assert_eq!(codes.iter().map(|(cell, _)| *cell).collect::<Vec<_>>(), Cell::all());
        let count = |wanted: usize| codes.iter().filter(|(_, code)| *code == wanted).count();
        assert_eq!([0, 1, 2, 3].map(count), [24, 73, 130, 16]);
        // The first and the last line as printed.
        let row = |from: usize| {
            let mut row: Vec<usize> = codes[from..from + 9].iter().map(|(_, code)| *code).collect();
            row.truncate(9);
            row
        };
        assert_eq!((row(0), row(234)), (vec![1, 1, 0, 3, 3, 1, 1, 3, 1], vec![1, 1, 0, 2, 2, 2, 2, 2, 2]));
    }
}

//! The published profile (the paper's Figure 4) and how far ours agrees with it.
//!
//! Agreement is not expected to be high: the original's generator and horizon are lost, each of its cells seems to be one
//! scenario, and its first planner is a person.

use super::verdict::{Comparison, Verdict};
use super::{Profile, verdict};
use crate::cell::Cell;

/// Cells with their codes.
const FIGURE_4: &str = include_str!("../../data/figure-4.csv");
/// What the codes mean, in the order of the figure's legend.
pub const LEGEND: [&str; 4] = ["Human", "2-Opt", "WAM", "no difference"];
/// Our planners that the codes 1 and 2 stand for.
pub const PLANNERS: [&str; 2] = ["two-opt", "wam"];

/// The code of every cell, as printed.
pub fn codes() -> Vec<(Cell, usize)> {
    let lines = FIGURE_4.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .filter_map(|line| line.split_once(','))
        .filter_map(|(cell, code)| cell.parse().ok().zip(code.parse().ok()))
        .collect()
}

/// Ours as a code: 1 and 2 for a winner, 3 for no difference, none where undecided.
pub fn code(comparison: &Comparison) -> Option<usize> {
    match comparison.verdict {
        Verdict::First => Some(1),
        Verdict::Second => Some(2),
        Verdict::NoDifference => Some(3),
        Verdict::Undecided => None,
    }
}

/// How often each published code (row) met each of ours: 1, 2, 3, undecided (columns). None where a planner is missing.
pub fn agreement(profile: &Profile, budget: usize) -> Option<[[usize; 4]; 4]> {
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

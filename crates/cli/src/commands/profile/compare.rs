//! `apex profile compare`: two profiles, or one and the paper's Figure 4.

use super::{budgets, read};
use crate::options::ProfileCompareOptions;
use crate::output;
use crate::trouble::{Outcome, Trouble};
use apex_portfolio::profile::conclusion::{Conclusion, conclusions};
use apex_portfolio::profile::verdict::Verdict;
use apex_portfolio::profile::{Profile, budget_words, published};
use std::fmt::Write;

/// Counts agreement and prints it.
pub(super) fn run(options: &ProfileCompareOptions) -> Outcome {
    let profile = read(options.profile.as_deref())?;
    let wanted: Vec<&str> = options.budgets.iter().map(String::as_str).collect();
    let budgets = budgets(&profile, &wanted, "--budgets")?;
    match &options.with {
        Some(other) => with_other(&profile, &read(Some(other))?, &budgets, options.json),
        None => budgets.iter().try_for_each(|budget| with_figure_4(&profile, *budget, options.json)),
    }
}

fn with_figure_4(profile: &Profile, budget: usize, json: bool) -> Outcome {
    let counts = published::agreement(profile, budget).ok_or_else(|| {
        Trouble::user("this profile does not answer the question of Figure 4")
            .because("two-opt or wam was not measured")
            .help("add them with `apex profile update --planners two-opt,wam`")
    })?;
    let count = |theirs: usize, ours: usize| counts.get(theirs).and_then(|row| row.get(ours)).copied().unwrap_or(0);
    let agreed: usize = (1..4).map(|code| count(code, code - 1)).sum();
    let comparable: usize = (1..4).map(|theirs| (0..4).map(|ours| count(theirs, ours)).sum::<usize>()).sum();
    let human: usize = (0..4).map(|ours| count(0, ours)).sum();
    // Where both name one of the two planners.
    let named = [(1, 0), (1, 1), (2, 0), (2, 1)].map(|(theirs, ours)| count(theirs, ours)).iter().sum::<usize>();
    let same = count(1, 0) + count(2, 1);
    let at = budget_words(profile.budgets.get(budget).copied().unwrap_or(0));
    if json {
        return output::print_line(serde_json::json!({
            "budget": at, "counts": counts, "agreed": agreed, "comparable": comparable, "human": human,
            "both_name_a_planner": named, "same_planner": same,
        }));
    }
    let mut text = format!("Figure 4 (rows) and ours at {at} (columns): 2-Opt or WAM\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  {:<16} {:>7} {:>7} {:>14} {:>10}", "", "2-Opt", "WAM", "no difference", "undecided");
    for (theirs, word) in published::LEGEND.iter().enumerate() {
        let [first, second, none, open] = [0, 1, 2, 3].map(|ours| count(theirs, ours));
        let _ = writeln!(text, "  {theirs} {word:<14} {first:>7} {second:>7} {none:>14} {open:>10}");
    }
    let _ = writeln!(
        text,
        "agreed in {agreed} of {comparable} cells; in {human} the figure's best is a person, which we do not measure.\n\
         Where both name a planner ({named} cells) it is the same in {same}.\n"
    );
    output::print(text)
}

/// Two profiles: cells and budgets that both have.
fn with_other(ours: &Profile, theirs: &Profile, budgets: &[usize], json: bool) -> Outcome {
    let (all, others) = (conclusions(ours), conclusions(theirs));
    let mut compared = 0;
    for units in budgets.iter().filter_map(|budget| ours.budgets.get(*budget)) {
        let at = |one: &&Conclusion| one.budget_units == *units;
        let pairs: Vec<(&Conclusion, &Conclusion)> = all
            .iter()
            .filter(at)
            .filter_map(|one| Some((one, others.iter().filter(at).find(|other| other.cell == one.cell)?)))
            .collect();
        if pairs.is_empty() {
            continue;
        }
        compared += pairs.len();
        report(&budget_words(*units), &pairs, json)?;
    }
    if compared == 0 {
        return Err(Trouble::user("the two profiles have no cell at the same budget")
            .help("`apex profile show` lists what a profile holds"));
    }
    Ok(())
}

fn report(at: &str, pairs: &[(&Conclusion, &Conclusion)], json: bool) -> Outcome {
    let same: usize = pairs.iter().filter(|(one, other)| one.best == other.best).count();
    // A contradiction: both are certain, of different planners.
    let certain = |one: &Conclusion| one.verdict == Verdict::First;
    let against: Vec<_> =
        pairs.iter().filter(|(one, other)| one.best != other.best && certain(one) && certain(other)).collect();
    if json {
        let cells: Vec<String> = against.iter().map(|(one, _)| one.cell.to_string()).collect();
        return output::print_line(serde_json::json!({
            "budget": at, "cells": pairs.len(), "same_planner": same, "contradictions": cells,
        }));
    }
    let mut text = format!("at {at}: the same planner in {same} of {} cells\n", pairs.len());
    // Writing to a string cannot fail.
    let _ = against.iter().try_for_each(|(one, other)| {
        writeln!(text, "  {}: {} here, {} there, and both are certain", one.cell, one.best, other.best)
    });
    output::print(text)
}

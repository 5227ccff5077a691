//! Comparison of two profiles in the cells and budgets that both have.

use super::conclusion::{Conclusion, conclusions};
use super::error::ProfileError;
use super::verdict::Verdict;
use super::{Profile, budget_words};
use serde_json::{Value, json};
use std::fmt::Write;

/// Comparison at one budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// The budget as text.
    pub budget: String,
    /// Number of cells that both have.
    pub cells: usize,
    /// Number of cells in which both name the same planner.
    pub same_planner: usize,
    /// Cells in which both are certain, of different planners: ours, theirs.
    pub contradictions: Vec<(Conclusion, Conclusion)>,
}

impl Compared {
    /// Returns the comparison as text for operators.
    pub fn text(&self) -> String {
        let Compared { budget, cells, same_planner, contradictions } = self;
        let mut text = format!("at {budget}: the same planner in {same_planner} of {cells} cells\n");
        // Writing to a string cannot fail.
        let _ = contradictions.iter().try_for_each(|(one, other)| {
            writeln!(text, "  {}: {} here, {} there, and both are certain", one.cell, one.best, other.best)
        });
        text
    }

    /// Returns the comparison as an object for programs.
    pub fn json(&self) -> Value {
        let cells: Vec<String> = self.contradictions.iter().map(|(one, _)| one.cell.to_string()).collect();
        json!({
            "budget": self.budget, "cells": self.cells, "same_planner": self.same_planner, "contradictions": cells,
        })
    }
}

/// Compares `ours` with `theirs` at these budgets (indices of ours), where both have cells.
///
/// # Errors
/// If they have no common cell and budget.
pub fn compared(ours: &Profile, theirs: &Profile, budgets: &[usize]) -> Result<Vec<Compared>, ProfileError> {
    let (all, others) = (conclusions(ours), conclusions(theirs));
    let units = budgets.iter().filter_map(|budget| ours.budgets.get(*budget));
    let each: Vec<Compared> = units.filter_map(|units| at(*units, &all, &others)).collect();
    if each.is_empty() {
        let message = "the two profiles have no cell at the same budget";
        return Err(ProfileError::new(message, "`apex profile show` lists what a profile holds"));
    }
    Ok(each)
}

fn at(units: u64, ours: &[Conclusion], theirs: &[Conclusion]) -> Option<Compared> {
    let at = |one: &&Conclusion| one.budget_units == units;
    let other = |one: &Conclusion| theirs.iter().filter(at).find(|other| other.cell == one.cell);
    let pairs: Vec<(&Conclusion, &Conclusion)> =
        ours.iter().filter(at).filter_map(|one| Some((one, other(one)?))).collect();
    if pairs.is_empty() {
        return None;
    }
    let certain = |one: &Conclusion| one.verdict == Verdict::First;
    let against = |(one, other): &&(&Conclusion, &Conclusion)| one.best != other.best && certain(one) && certain(other);
    let contradictions = pairs.iter().filter(against).map(|(one, other)| ((*one).clone(), (*other).clone()));
    Some(Compared {
        budget: budget_words(units),
        cells: pairs.len(),
        same_planner: pairs.iter().filter(|(one, other)| one.best == other.best).count(),
        contradictions: contradictions.collect(),
    })
}

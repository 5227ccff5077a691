//! A profile as text for operators, and as lines of JSON for programs.

use super::verdict::{self, Best, Verdict};
use super::{Profile, Row, budget_words, conclusion};
use crate::cell::Cell;
use std::fmt::Write;

/// Returns the profile at these budgets (indices): a map of the best planners at each, or every planner in one cell.
pub fn shown(profile: &Profile, budgets: &[usize], row: Option<&Row>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = head(&mut text, profile);
    let _ = budgets.iter().try_for_each(|budget| match row {
        Some(row) => one_cell(&mut text, profile, row, *budget),
        None => map(&mut text, profile, *budget),
    });
    text
}

/// Returns every conclusion at these budgets (indices) as a line of JSON.
pub fn json_lines(profile: &Profile, budgets: &[usize]) -> String {
    let units: Vec<u64> = budgets.iter().filter_map(|budget| profile.budgets.get(*budget).copied()).collect();
    let mut text = String::new();
    for one in conclusion::conclusions(profile).into_iter().filter(|one| units.contains(&one.budget_units)) {
        let line = serde_json::json!({
            "cell": one.cell.to_string(),
            "budget_units": one.budget_units,
            "best": one.best,
            "verdict": conclusion::word(one.verdict),
            "next": one.next,
            "effect_percent": one.effect_percent,
        });
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    }
    text
}

fn head(out: &mut String, profile: &Profile) -> std::fmt::Result {
    writeln!(
        out,
        "{} cells, {} missions each (generator {})",
        profile.rows.len(),
        profile.missions,
        profile.generator
    )?;
    let planners: Vec<String> =
        profile.planners.iter().map(|planner| format!("{} {}", planner.name, planner.version)).collect();
    writeln!(out, "planners: {}", planners.join(", "))
}

/// Returns every planner in one cell, each compared with the best.
fn one_cell(out: &mut String, profile: &Profile, row: &Row, budget: usize) -> std::fmt::Result {
    let bests = verdict::best(profile, budget);
    let place = profile.rows.iter().position(|other| other.cell == row.cell);
    let Some(best) = place.and_then(|place| bests.get(place)) else { return Ok(()) };
    writeln!(out, "\n{} at {}", row.cell, words(profile, budget))?;
    for (at, planner) in profile.planners.iter().enumerate() {
        if at == best.planner {
            writeln!(out, "  {:<20} {}", planner.name, verdict_words(best.verdict))?;
            continue;
        }
        // Holm's correction is over all cells, as in the map.
        let Some(one) = place.and_then(|place| verdict::pair(profile, budget, at, best.planner).get(place).copied())
        else {
            continue;
        };
        writeln!(
            out,
            "  {:<20} costs {:.2} % more (from {:.2} to {:.2}), p = {:.2e}",
            planner.name,
            percent(one.effect),
            percent(one.effect - one.half_width),
            percent(one.effect + one.half_width),
            one.probability
        )?;
    }
    Ok(())
}

fn percent(logarithm: f64) -> f64 {
    100.0 * (libm::exp(logarithm) - 1.0)
}

fn words(profile: &Profile, budget: usize) -> String {
    budget_words(profile.budgets.get(budget).copied().unwrap_or(0))
}

fn verdict_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::First | Verdict::Second => "is best",
        Verdict::NoDifference => "is among the best: no difference of 1 %",
        Verdict::Undecided => "came out first, which is not certain",
    }
}

/// Writes the best planner of each cell in the layout of Figure 4, and the number of cells in which each planner is best.
fn map(out: &mut String, profile: &Profile, budget: usize) -> std::fmt::Result {
    let bests = verdict::best(profile, budget);
    writeln!(
        out,
        "\nbest planner at {}: = if another planner is less than 1 % worse, ? if not certain",
        words(profile, budget)
    )?;
    for (at, planner) in profile.planners.iter().enumerate() {
        let of = |verdict: Verdict| bests.iter().filter(|best| best.planner == at && best.verdict == verdict).count();
        let (better, equal, open) = (of(Verdict::First), of(Verdict::NoDifference), of(Verdict::Undecided));
        writeln!(
            out,
            "  {} {:<20} best in {better} cells, among the best in {equal}, perhaps in {open}",
            initial(profile, at),
            planner.name
        )?;
    }
    let square = |cell: &Cell| {
        let place = profile.rows.iter().position(|row| row.cell == *cell);
        let best: Option<&Best> = place.and_then(|place| bests.get(place));
        best.map_or("  .".to_string(), |best| {
            let mark = match best.verdict {
                Verdict::First | Verdict::Second => ' ',
                Verdict::NoDifference => '=',
                Verdict::Undecided => '?',
            };
            format!(" {}{mark}", initial(profile, best.planner))
        })
    };
    writeln!(out, "\n  {:<30} {:<9} {:<9} {:<9}", "", "4", "8", "16")?;
    writeln!(out, "  {:<8} {:<10} {:<10} {}", "scale", "rate", "cost", " 2c gl un".repeat(3))?;
    for line in Cell::all().chunks(9) {
        let Some(Cell { scale, rate, cost, .. }) = line.first() else { continue };
        let squares: String = line.iter().map(square).collect();
        writeln!(out, "  {:<8} {:<10} {:<10} {}", scale.word(), rate.word(), cost.word(), squares.trim_end())?;
    }
    Ok(())
}

fn initial(profile: &Profile, planner: usize) -> char {
    profile.planners.get(planner).and_then(|known| known.name.chars().next()).unwrap_or('-')
}

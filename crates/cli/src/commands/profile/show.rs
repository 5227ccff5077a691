//! `apex profile show`: text, JSON lines, or a heat map.

use super::{budgets, read};
use crate::options::ProfileShowOptions;
use crate::output;
use crate::trouble::{Outcome, Trouble};
use apex_portfolio::cell::Cell;
use apex_portfolio::profile::verdict::{self, Best, Verdict};
use apex_portfolio::profile::{Profile, Row, budget_words, conclusion, picture};
use std::fmt::Write;

/// Prints or draws.
pub(super) fn run(options: &ProfileShowOptions) -> Outcome {
    let profile = read(options.profile.as_deref())?;
    let wanted: Vec<&str> = options.budget.iter().map(String::as_str).collect();
    let budgets = budgets(&profile, &wanted, "--budget")?;
    if let Some(path) = &options.svg {
        let maps = if options.figure_4 {
            let last = budgets.last().copied().unwrap_or(0);
            let maps = picture::beside_figure_4(&profile, last);
            maps.map(Vec::from).ok_or_else(|| {
                Trouble::user("this profile does not answer the question of Figure 4")
                    .because("two-opt or wam was not measured")
                    .help("add them with `apex profile update --planners two-opt,wam`")
            })?
        } else {
            budgets.iter().map(|budget| picture::best(&profile, *budget)).collect()
        };
        return std::fs::write(path, picture::svg(&maps)).map_err(|error| {
            Trouble::failure(format!("cannot write {}", path.display()))
                .because(error)
                .help("name another place for it")
        });
    }
    if options.json {
        return json(&profile, &budgets);
    }
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = head(&mut text, &profile);
    match &options.cell {
        Some(cell) => {
            let row = row(&profile, cell)?;
            let _ = budgets.iter().try_for_each(|budget| one_cell(&mut text, &profile, row, *budget));
        }
        None => {
            let _ = budgets.iter().try_for_each(|budget| map(&mut text, &profile, *budget));
        }
    }
    output::print(text)
}

/// Every conclusion as a line of JSON.
fn json(profile: &Profile, budgets: &[usize]) -> Outcome {
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
        let _ = writeln!(text, "{line}");
    }
    output::print(text)
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

fn row<'a>(profile: &'a Profile, name: &str) -> Outcome<&'a Row> {
    let cell: Cell = name.parse().map_err(|why| {
        Trouble::user(format!("there is no cell {name}"))
            .because(why)
            .help("docs/reference/test-missions.md names the cells")
    })?;
    profile.rows.iter().find(|row| row.cell == cell).ok_or_else(|| {
        Trouble::user(format!("{cell} was not measured")).help("`apex profile show` lists the cells of this profile")
    })
}

/// Every planner in one cell, each against the best.
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
        // The family is that of the map: every cell.
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

/// The best planners in the layout of Figure 4, and how often each is.
fn map(out: &mut String, profile: &Profile, budget: usize) -> std::fmt::Result {
    let bests = verdict::best(profile, budget);
    writeln!(
        out,
        "\nbest planner at {}: strong letters alone, = no other is 1 % worse, ? not certain",
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

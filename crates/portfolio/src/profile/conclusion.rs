//! Extract of a profile for selection: the best planner of each cell at each budget. Written as
//! `data/profile-table.csv`.

use super::verdict::{self, Best, Verdict};
use super::{Profile, budget_words};
use crate::cell::Cell;
use crate::format_error::FormatError;
use std::fmt::Write;

/// The first line that is not a comment.
const HEADING: &str = "cell,budget_units,best,verdict,next,effect_percent";

/// One line: the best planner of a cell at a budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Conclusion {
    /// The cell.
    pub cell: Cell,
    /// Work units.
    pub budget_units: u64,
    /// The planner with the least mean logarithm of costs.
    pub best: String,
    /// Verdict about `best` and `next`.
    pub verdict: Verdict,
    /// The second best planner; the same planner if there is no other.
    pub next: String,
    /// Cost of `best` below that of `next`, in percent of the cost of `next`.
    pub effect_percent: f64,
}

impl Conclusion {
    /// Returns the conclusion as text: `at 10 ms wam is best, 2.3 % before two-opt`.
    pub fn words(&self) -> String {
        let budget = budget_words(self.budget_units);
        let (best, next, effect) = (&self.best, &self.next, self.effect_percent);
        match self.verdict {
            Verdict::First | Verdict::Second => format!("at {budget} {best} is best, {effect:.1} % before {next}"),
            Verdict::NoDifference => format!("at {budget} {best} and {next} do not differ by 1 %"),
            Verdict::Undecided => {
                format!("at {budget} {best} came out first, {effect:.1} % before {next}, which is not certain")
            }
        }
    }
}

/// Returns the conclusions from `profile`.
pub fn conclusions(profile: &Profile) -> Vec<Conclusion> {
    let bests: Vec<Vec<Best>> = (0..profile.budgets.len()).map(|budget| verdict::best(profile, budget)).collect();
    let mut all = Vec::new();
    for (index, row) in profile.rows.iter().enumerate() {
        for (budget_units, best) in profile.budgets.iter().zip(&bests) {
            let Some(best) = best.get(index) else { continue };
            all.push(conclusion(profile, row.cell, *budget_units, best));
        }
    }
    all
}

fn conclusion(profile: &Profile, cell: Cell, budget_units: u64, best: &Best) -> Conclusion {
    let name = |planner: usize| profile.planners.get(planner).map(|known| known.name.clone()).unwrap_or_default();
    let (next, effect) = best.next.map_or((best.planner, 0.0), |(next, comparison)| (next, comparison.effect));
    // Rounded to the written digits, so that the value read from the file is equal.
    let effect_percent = (100.0 * (10.0 * (1.0 - libm::exp(effect)))).round() / 10.0;
    Conclusion { cell, budget_units, best: name(best.planner), verdict: best.verdict, next: name(next), effect_percent }
}

/// Returns the conclusions as text, with the source of the measurements.
pub fn written(profile: &Profile) -> String {
    let planners: Vec<String> =
        profile.planners.iter().map(|planner| format!("{} {}", planner.name, planner.version)).collect();
    let mut text = format!(
        "# The best planner of each cell at each budget, as concluded from profile.txt; docs/reference/profile-table.md.\n\
         # Generator {}, {} missions per cell; planners: {}.\n{HEADING}\n",
        profile.generator,
        profile.missions,
        planners.join(", ")
    );
    for one in conclusions(profile) {
        let Conclusion { cell, budget_units, best, verdict, next, effect_percent } = one;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{cell},{budget_units},{best},{},{next},{effect_percent}", word(verdict));
    }
    text
}

/// Returns the word of a verdict in tables.
pub fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::First | Verdict::Second => "better",
        Verdict::NoDifference => "no difference",
        Verdict::Undecided => "undecided",
    }
}

/// Reads the text written by [`written`].
///
/// # Errors
/// The line, and the error in it.
pub fn read(text: &str) -> Result<Vec<Conclusion>, FormatError> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
    let wrong = |index: usize, line: &str, message: String| FormatError {
        line: index + 1,
        column: 1,
        text: line.to_string(),
        message,
        reason: format!("a line holds {HEADING}"),
        help: "write it again with `apex profile build` or `apex profile update`".to_string(),
    };
    let (index, heading) = lines.next().unwrap_or_default();
    if heading.trim_end() != HEADING {
        return Err(wrong(index, heading, "this is not the heading of a profile table".into()));
    }
    lines.map(|(index, line)| conclusion_of(line).map_err(|message| wrong(index, line, message))).collect()
}

fn conclusion_of(line: &str) -> Result<Conclusion, String> {
    let fields: Vec<&str> = line.split(',').collect();
    let [cell, budget_units, best, verdict, next, effect_percent] = fields.as_slice() else {
        return Err(format!("a line has 6 fields, this has {}", fields.len()));
    };
    let verdicts = [Verdict::First, Verdict::NoDifference, Verdict::Undecided];
    Ok(Conclusion {
        cell: cell.parse()?,
        budget_units: budget_units.parse().map_err(|_| format!("{budget_units} is not a budget in work units"))?,
        best: (*best).to_string(),
        verdict: verdicts
            .into_iter()
            .find(|known| word(*known) == *verdict)
            .ok_or_else(|| format!("{verdict} is not a verdict: better, no difference or undecided"))?,
        next: (*next).to_string(),
        effect_percent: effect_percent.parse().map_err(|_| format!("{effect_percent} is not a number"))?,
    })
}

//! The profile as text, one line for each planner and budget of a cell: reading and writing, with the place of an error.

use super::{Planner, Profile, Row};
use crate::format_error::FormatError;
use std::fmt::{self, Write};
use std::str::FromStr;

/// Version of this format.
const FORMAT: u32 = 1;
/// The first line.
const HEADING: &str =
    "# Expected costs that planners come to on test missions. docs/reference/profile-table.md describes this file.";
/// Replaces costs that equal those of the preceding budget.
const SAME: &str = "=";
/// Maximum number of missions of a cell.
pub(super) const MISSIONS_MAX: u64 = 10_000;

/// Rounds a cost to the written digits, so that a profile in memory equals the one in its file.
pub(super) fn rounded(cost: f64) -> f64 {
    written(cost).parse().unwrap_or(cost)
}

/// Formats a cost with seven digits.
fn written(cost: f64) -> String {
    format!("{cost:.6e}")
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEADING}\nformat {FORMAT}\ngenerator {}\nmissions {}", self.generator, self.missions)?;
        let budgets = self.budgets.iter().fold(String::new(), |mut text, budget| {
            let _ = write!(text, " {budget}");
            text
        });
        writeln!(f, "budgets{budgets}")?;
        self.planners.iter().try_for_each(|planner| writeln!(f, "planner {} {}", planner.name, planner.version))?;
        for row in &self.rows {
            writeln!(f, "cell {} {}", row.cell, row.hash)?;
            for (planner, budgets) in self.planners.iter().zip(&row.costs) {
                let mut before: Option<&Vec<f64>> = None;
                for (budget, costs) in self.budgets.iter().zip(budgets) {
                    write!(f, "{} {budget}", planner.name)?;
                    if before == Some(costs) {
                        write!(f, " {SAME}")?;
                    } else {
                        costs.iter().try_for_each(|cost| write!(f, " {}", written(*cost)))?;
                    }
                    writeln!(f)?;
                    before = Some(costs);
                }
            }
        }
        Ok(())
    }
}

impl FromStr for Profile {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<Profile, FormatError> {
        let mut lines = Lines { text, rest: text.lines().enumerate().collect::<Vec<_>>().into_iter().peekable() };
        lines.number("format", u64::from(FORMAT)..=u64::from(FORMAT))?;
        let generator = lines.number("generator", 1..=u64::from(u32::MAX))?;
        let missions = lines.number("missions", 1..=MISSIONS_MAX)?;
        let budgets = lines.budgets()?;
        let mut planners = Vec::new();
        while let Some(line) = lines.next_of("planner") {
            let words = line.words();
            let [_, name, version] = words.as_slice() else {
                return Err(line.trouble(0, "this is not a planner", "expected a name and a version"));
            };
            if planners.iter().any(|known: &Planner| known.name == *name) {
                return Err(line.trouble(1, format!("{name} is given twice"), "each planner has one line"));
            }
            planners.push(Planner { name: (*name).to_string(), version: (*version).to_string() });
        }
        let mut profile =
            Profile { generator: u32::try_from(generator).unwrap_or(0), missions, budgets, planners, rows: Vec::new() };
        while let Some(line) = lines.next_of("cell") {
            let row = row(&mut lines, &line, &profile)?;
            profile.rows.push(row);
        }
        match lines.next() {
            Some(line) => Err(line.trouble(0, "this line is not expected here", "expected a line `cell NAME HASH`")),
            None if profile.rows.is_empty() || profile.planners.is_empty() => {
                Err(lines.end("nothing is measured in it", "a profile has planners and cells"))
            }
            None => Ok(profile),
        }
    }
}

/// Returns the costs of one cell.
fn row(lines: &mut Lines<'_>, head: &ProfileLine<'_>, profile: &Profile) -> Result<Row, FormatError> {
    let words = head.words();
    let [_, cell, hash] = words.as_slice() else {
        return Err(head.trouble(0, "this is not a cell", "expected a name and a hash"));
    };
    let cell = cell.parse().map_err(|why| head.trouble(1, format!("{cell} is not a cell"), why))?;
    if profile.rows.iter().any(|row| row.cell == cell) {
        return Err(head.trouble(1, format!("{cell} is given twice"), "each cell has one place"));
    }
    let mut costs = Vec::with_capacity(profile.planners.len());
    for planner in &profile.planners {
        let mut budgets: Vec<Vec<f64>> = Vec::with_capacity(profile.budgets.len());
        for budget in &profile.budgets {
            let wanted = format!("expected the costs of {} at {budget} units in {cell}", planner.name);
            let Some(line) = lines.next() else { return Err(lines.end("it ends too early", &wanted)) };
            let words = line.words();
            if words.first() != Some(&planner.name.as_str()) || words.get(1) != Some(&budget.to_string().as_str()) {
                return Err(line.trouble(0, "this line is not expected here", wanted));
            }
            let before = budgets.last().filter(|_| words.get(2..) == Some(&[SAME]));
            let read = match before {
                Some(before) => before.clone(),
                None => line.costs(profile.missions)?,
            };
            budgets.push(read);
        }
        costs.push(budgets);
    }
    Ok(Row { cell, hash: (*hash).to_string(), costs })
}

/// Lines that are not comments.
struct Lines<'a> {
    text: &'a str,
    rest: std::iter::Peekable<std::vec::IntoIter<(usize, &'a str)>>,
}

struct ProfileLine<'a> {
    number: usize,
    text: &'a str,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<ProfileLine<'a>> {
        let (index, text) = self.rest.find(|(_, line)| !line.starts_with('#') && !line.trim().is_empty())?;
        Some(ProfileLine { number: index + 1, text })
    }

    /// Returns the next line if it begins with `word`.
    fn next_of(&mut self, word: &str) -> Option<ProfileLine<'a>> {
        while self.rest.next_if(|(_, line)| line.starts_with('#') || line.trim().is_empty()).is_some() {}
        let begins = |line: &str| line.split_whitespace().next() == Some(word);
        self.rest.next_if(|(_, line)| begins(line)).map(|(index, text)| ProfileLine { number: index + 1, text })
    }

    fn required(&mut self, word: &str) -> Result<ProfileLine<'a>, FormatError> {
        if let Some(line) = self.next_of(word) {
            return Ok(line);
        }
        let wanted = format!("expected a line `{word} ..`");
        Err(match self.next() {
            Some(line) => line.trouble(0, "this is not a profile of planners", wanted),
            None => self.end("it ends too early", &wanted),
        })
    }

    fn number(&mut self, word: &str, allowed: std::ops::RangeInclusive<u64>) -> Result<u64, FormatError> {
        let line = self.required(word)?;
        let read = line.words().get(1).and_then(|number| number.parse().ok());
        read.filter(|number| allowed.contains(number)).ok_or_else(|| {
            let (low, high) = (allowed.start(), allowed.end());
            let wanted =
                if low == high { format!("expected {low}") } else { format!("expected a number from {low} to {high}") };
            line.trouble(1, format!("invalid value for {word}"), wanted)
        })
    }

    fn budgets(&mut self) -> Result<Vec<u64>, FormatError> {
        let line = self.required("budgets")?;
        let mut budgets: Vec<u64> = Vec::new();
        for (place, word) in line.words().into_iter().enumerate().skip(1) {
            let units = word.parse().ok().filter(|units| *units > budgets.last().copied().unwrap_or(0));
            budgets.push(units.ok_or_else(|| {
                line.trouble(place, format!("{word} is not a budget"), "budgets are work units above 0, rising")
            })?);
        }
        if budgets.is_empty() {
            return Err(line.trouble(0, "there is no budget", "budgets are work units above 0, rising"));
        }
        Ok(budgets)
    }

    fn end(&self, message: &str, wanted: &str) -> FormatError {
        ProfileLine { number: self.text.lines().count(), text: "" }.trouble(0, message, wanted)
    }
}

impl<'a> ProfileLine<'a> {
    fn words(&self) -> Vec<&'a str> {
        self.text.split_whitespace().collect()
    }

    fn costs(&self, missions: u64) -> Result<Vec<f64>, FormatError> {
        let words = self.words();
        let mut costs = Vec::with_capacity(words.len());
        for (place, word) in words.iter().enumerate().skip(2) {
            let cost = word.parse::<f64>().ok().filter(|cost| cost.is_finite() && *cost > 0.0);
            let wrong = || self.trouble(place, format!("{word} is not a cost"), "costs are finite numbers above 0");
            costs.push(cost.ok_or_else(wrong)?);
        }
        if costs.len() as u64 == missions {
            return Ok(costs);
        }
        let message = format!("the line has {} costs for {missions} missions", costs.len());
        Err(self.trouble(words.len().saturating_sub(1), message, "every mission has one cost"))
    }

    /// Makes the error of the word at `place`.
    fn trouble(&self, place: usize, message: impl Into<String>, reason: impl Into<String>) -> FormatError {
        let start = self.words().get(place).map_or(0, |word| word.as_ptr().addr() - self.text.as_ptr().addr());
        FormatError {
            line: self.number,
            column: self.text.get(..start).map_or(0, |before| before.chars().count()) + 1,
            text: self.text.chars().take(80).collect(),
            message: message.into(),
            reason: reason.into(),
            help: "measure it again with `apex profile build`, or take the file from where it is whole".to_string(),
        }
    }
}

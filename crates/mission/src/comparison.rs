//! Comparison of two reports of one mission.

use crate::report::{MissionValue, Report};
use crate::score::{CostKind, FlightScore};
use apex_model::time::Time;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Maximum width of the table in characters.
const LINE_WIDTH: usize = 120;
/// The widest column of names; longer names are wrapped.
const NAME_WIDTH_MAX: usize = 40;
/// Spaces before and between columns.
const GAP: usize = 2;
/// Notes printed on the terminal; all are in the record.
const NOTES_PRINTED_MAX: usize = 30;

/// Two reports of one mission, with a heading for each.
pub struct Comparison<'a> {
    /// The flights' headings.
    pub headings: [&'a str; 2],
    /// Their reports.
    pub reports: [&'a Report; 2],
    /// Instant from which on the second flight differs: its notes after that are printed.
    pub from: Time,
}

/// A row: its subject, and each flight's entry.
type ComparisonRow = (String, [String; 2]);

impl Comparison<'_> {
    /// Returns both reports as JSON, under their headings.
    pub fn json(&self) -> Value {
        let sections = |report: &Report| -> Map<String, Value> {
            report.sections().into_iter().map(|(name, body)| (name.to_string(), body)).collect()
        };
        let [first, second] = self.reports.map(sections);
        let [a, b] = self.headings;
        json!({ a: first, b: second })
    }

    /// Returns the table for the terminal.
    pub fn text(&self) -> String {
        let [a, b] = self.headings.map(str::to_string);
        let groups = [
            (String::new(), vec![(String::new(), [a, b])]),
            (String::new(), self.totals()),
            ("Observed (begin, worth or observations)".to_string(), self.observed()),
            ("Not observed".to_string(), self.left_out()),
        ];
        let widths = widths(groups.iter().flat_map(|(_, rows)| rows));
        let mut text = String::new();
        for (title, rows) in &groups {
            if rows.is_empty() {
                continue;
            }
            if !title.is_empty() {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "\n{title}");
            }
            rows.iter().for_each(|row| write_row(&mut text, row, widths));
        }
        let notes = self.reports[1].notes.iter().filter(|note| note.at > self.from);
        for (number, note) in notes.take(NOTES_PRINTED_MAX).enumerate() {
            if number == 0 {
                let _ = writeln!(text, "\nDecisions of note after the fork");
            }
            let _ = writeln!(text, "  {:>10}  {}", whole(note.at), note.text);
        }
        text
    }

    fn totals(&self) -> Vec<ComparisonRow> {
        let row = |name: &str, entry: &dyn Fn(&Report) -> Option<String>| {
            let entries = self.reports.map(|report| entry(report).unwrap_or_else(|| "-".to_string()));
            (entries != ["-", "-"]).then(|| (name.to_string(), entries))
        };
        let score = |part: fn(&FlightScore) -> f64| {
            move |report: &Report| match &report.value {
                MissionValue::Score(score) => Some(format!("{:.1}", part(score))),
                MissionValue::Ignorance(..) | MissionValue::None => None,
            }
        };
        let ignorance = |report: &Report| match &report.value {
            MissionValue::Ignorance(cost, _) => Some(format!("{:.4}", cost.total)),
            MissionValue::Score(_) | MissionValue::None => None,
        };
        let rows = [
            row("ended at", &|report| Some(whole(report.end.0))),
            row("because", &|report| Some(report.end.1.clone())),
            row("mission score", &score(|score| score.score)),
            row("benefits", &score(|score| score.benefits)),
            row("personnel", &score(|score| score.cost_of(CostKind::Personnel))),
            row("failure", &score(|score| score.cost_of(CostKind::Failure))),
            row("expected cost of ignorance", &ignorance),
            row("plans", &|report| Some(report.plans.to_string())),
            row("re-flown segments", &|report| {
                Some(report.visits.iter().map(|visit| visit.reflies).sum::<u32>().to_string())
            }),
        ];
        rows.into_iter().flatten().collect()
    }

    fn observed(&self) -> Vec<ComparisonRow> {
        let mut ids: Vec<&str> = Vec::new();
        for visit in self.reports.iter().flat_map(|report| &report.visits) {
            if visit.end.is_some() && !ids.contains(&visit.target.as_str()) {
                ids.push(&visit.target);
            }
        }
        let row = |id: &str| (id.to_string(), self.reports.map(|report| observation(report, id)));
        ids.into_iter().map(row).collect()
    }

    fn left_out(&self) -> Vec<ComparisonRow> {
        let mut ids: Vec<&str> = Vec::new();
        for (id, _) in self.reports.iter().flat_map(|report| &report.left_out) {
            if !ids.contains(&id.as_str()) {
                ids.push(id);
            }
        }
        let reason = |report: &Report, id: &str| {
            let found = report.left_out.iter().find(|(left_out, _)| left_out == id);
            // Ground by which a fire has grown is a target of the flights that saw the fire before.
            let is_observed = || report.visits.iter().any(|visit| visit.target == id && visit.end.is_some());
            match found {
                Some((_, reason)) => reason.clone(),
                None if is_observed() => "observed".to_string(),
                None => "not a target in this flight".to_string(),
            }
        };
        ids.into_iter().map(|id| (id.to_string(), self.reports.map(|report| reason(report, id)))).collect()
    }
}

/// Widths of the columns: of names, and of the entries of each flight. Columns that fit keep their widths.
fn widths<'a>(rows: impl Iterator<Item = &'a ComparisonRow>) -> [usize; 3] {
    let length = |text: &String| text.chars().count();
    let mut longest = [0; 3];
    for (name, [first, second]) in rows {
        for (longest, text) in longest.iter_mut().zip([name, first, second]) {
            *longest = length(text).max(*longest);
        }
    }
    let [name, first, second] = longest;
    let name = name.min(NAME_WIDTH_MAX);
    let left = LINE_WIDTH - 3 * GAP - name;
    let first = first.min((left / 2).max(left.saturating_sub(second)));
    [name, first, left - first]
}

/// Writes one row, its cells wrapped to the widths.
fn write_row(
    text: &mut String,
    (name, [first, second]): &ComparisonRow,
    [name_width, first_width, second_width]: [usize; 3],
) {
    let cells = [wrapped(name, name_width), wrapped(first, first_width), wrapped(second, second_width)];
    let height = cells.iter().map(Vec::len).max().unwrap_or(0);
    for number in 0..height {
        let [name, first, second] = cells.each_ref().map(|cell| cell.get(number).map_or("", String::as_str));
        let line = format!("{:GAP$}{name:<name_width$}{:GAP$}{first:<first_width$}{:GAP$}{second}", "", "", "");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", line.trim_end());
    }
}

/// Returns lines of at most `width` characters, broken at single spaces; a longer word is broken at the width.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let width = width.max(1);
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let mut letters: Vec<char> = word.chars().collect();
        let used = lines.last().map_or(0, |line| line.chars().count());
        if used > 0 && used + 1 + letters.len() > width {
            lines.push(String::new());
        } else if let Some(line) = lines.last_mut().filter(|line| !line.is_empty()) {
            line.push(' ');
        }
        while letters.len() > width {
            let rest = letters.split_off(width);
            if let Some(line) = lines.last_mut() {
                line.extend(letters);
            }
            lines.push(String::new());
            letters = rest;
        }
        if let Some(line) = lines.last_mut() {
            line.extend(letters);
        }
    }
    lines
}

/// Returns begin and worth of a target's observation, or the number of its observations.
fn observation(report: &Report, id: &str) -> String {
    let mut visits = report.visits.iter().filter(|visit| visit.target == id && visit.end.is_some());
    let Some(first) = visits.next() else { return "-".to_string() };
    match &report.value {
        MissionValue::Score(score) => {
            let points = score.looks.iter().find(|look| look.id == id).map(|look| look.flown.points);
            format!("{} {:>6.1}", whole(first.begin), points.unwrap_or(0.0))
        }
        MissionValue::Ignorance(..) | MissionValue::None => format!("{} x{}", whole(first.begin), 1 + visits.count()),
    }
}

fn whole(time: Time) -> String {
    Time::from_seconds(time.seconds().round()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fire that grows in one of two flights only: the other flight has not observed the growth, it does not have it.
    #[test]
    fn a_target_of_one_flight_is_not_observed_in_the_other() {
        let report = |left_out: &[(&str, &str)]| Report {
            mission: "m".to_string(),
            end: (Time::ZERO, "the end".to_string()),
            failed_because: None,
            not_landed: None,
            landed_away: None,
            visits: Vec::new(),
            observed: 0,
            left_out: left_out.iter().map(|(id, why)| (id.to_string(), why.to_string())).collect(),
            value: MissionValue::None,
            notes: Vec::new(),
            plans: 0,
            names: Vec::new(),
        };
        let (first, second) = (report(&[]), report(&[("gw/growth-1", "too far")]));
        let compared = Comparison { headings: ["a", "b"], reports: [&first, &second], from: Time::ZERO };
        let row = ["not a target in this flight".to_string(), "too far".to_string()];
        assert_eq!(compared.left_out(), [("gw/growth-1".to_string(), row)]);
    }

    #[test]
    fn columns_that_fit_keep_their_widths() {
        let row: ComparisonRow = ("because".to_string(), ["mission over".to_string(), "no fuel".to_string()]);
        let widths = widths([&row].into_iter());
        assert_eq!(widths[..2], [7, 12]);
        let mut text = String::new();
        write_row(&mut text, &row, widths);
        assert_eq!(text, "  because  mission over  no fuel\n");
    }

    #[test]
    fn no_line_is_wider_than_the_table_and_no_letter_is_lost() {
        let (short, long, word) = ("a b  c".to_string(), "reserve fuel is needed ".repeat(9), "x".repeat(150));
        for cells in [[&short, &long, &long], [&long, &short, &word], [&word, &word, &short], [&word, &long, &word]] {
            let row: ComparisonRow = (cells[0].clone(), [cells[1].clone(), cells[2].clone()]);
            let mut text = String::new();
            write_row(&mut text, &row, widths([&row].into_iter()));
            assert!(text.lines().all(|line| line.chars().count() <= LINE_WIDTH), "{text}");
            let letters = |text: &str| {
                let mut letters: Vec<char> = text.chars().filter(|each| !each.is_whitespace()).collect();
                letters.sort_unstable();
                letters
            };
            assert_eq!(letters(&text), letters(&cells.map(String::as_str).concat()));
        }
    }
}

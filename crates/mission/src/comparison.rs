//! Two reports of one mission side by side.

use crate::report::{MissionValue, Report};
use apex_model::time::Time;
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// Notes printed on the terminal; all are in the record.
const NOTES_PRINTED_MAX: usize = 30;

/// Two reports of one mission, with a heading for each.
pub struct Comparison<'a> {
    /// The flights' headings.
    pub headings: [&'a str; 2],
    /// Their reports.
    pub reports: [&'a Report; 2],
    /// When the second flight begins to differ: its notes after that are printed.
    pub from: Time,
}

/// A row: what it is about, and each flight's entry.
type Row = (String, [String; 2]);

impl Comparison<'_> {
    /// Both reports as JSON, under their headings.
    pub fn json(&self) -> Value {
        let sections = |report: &Report| -> Map<String, Value> {
            report.sections().into_iter().map(|(name, body)| (name.to_string(), body)).collect()
        };
        let [first, second] = self.reports.map(sections);
        let [a, b] = self.headings;
        json!({ a: first, b: second })
    }

    /// The table for the terminal.
    pub fn text(&self) -> String {
        let [a, b] = self.headings.map(str::to_string);
        let groups = [
            (String::new(), vec![(String::new(), [a, b])]),
            (String::new(), self.totals()),
            ("Observed (begin, worth or observations)".to_string(), self.observed()),
            ("Not observed".to_string(), self.left_out()),
        ];
        let rows = || groups.iter().flat_map(|(_, rows)| rows);
        let name_width = rows().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let entry_width = rows().map(|(_, [entry, _])| entry.chars().count()).max().unwrap_or(0);
        let mut text = String::new();
        for (title, rows) in &groups {
            if rows.is_empty() {
                continue;
            }
            if !title.is_empty() {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "\n{title}");
            }
            for (name, [first, second]) in rows {
                let line = format!("  {name:<name_width$}  {first:<entry_width$}  {second}");
                let _ = writeln!(text, "{}", line.trim_end());
            }
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

    fn totals(&self) -> Vec<Row> {
        let row = |name: &str, entry: &dyn Fn(&Report) -> Option<String>| {
            let entries = self.reports.map(|report| entry(report).unwrap_or_else(|| "-".to_string()));
            (entries != ["-", "-"]).then(|| (name.to_string(), entries))
        };
        let score = |part: fn(&apex_metrics::mission_score::MissionScore) -> f64| {
            move |report: &Report| match &report.value {
                MissionValue::Score(score) => Some(format!("{:.1}", part(score))),
                MissionValue::Ignorance(_) | MissionValue::None => None,
            }
        };
        let ignorance = |report: &Report| match &report.value {
            MissionValue::Ignorance(cost) => Some(format!("{:.4}", cost.total)),
            MissionValue::Score(_) | MissionValue::None => None,
        };
        let rows = [
            row("ended at", &|report| Some(whole(report.end.0))),
            row("because", &|report| Some(report.end.1.clone())),
            row("mission score", &score(|score| score.score)),
            row("benefits", &score(|score| score.benefits)),
            row("personnel", &score(|score| score.personnel_cost)),
            row("failure", &score(|score| score.failure_cost)),
            row("expected cost of ignorance", &ignorance),
            row("plans", &|report| Some(report.plans.to_string())),
            row("re-flown segments", &|report| {
                Some(report.visits.iter().map(|visit| visit.reflies).sum::<u32>().to_string())
            }),
        ];
        rows.into_iter().flatten().collect()
    }

    fn observed(&self) -> Vec<Row> {
        let mut ids: Vec<&str> = Vec::new();
        for visit in self.reports.iter().flat_map(|report| &report.visits) {
            if visit.end.is_some() && !ids.contains(&visit.target.as_str()) {
                ids.push(&visit.target);
            }
        }
        let row = |id: &str| (id.to_string(), self.reports.map(|report| observation(report, id)));
        ids.into_iter().map(row).collect()
    }

    fn left_out(&self) -> Vec<Row> {
        let mut ids: Vec<&str> = Vec::new();
        for (id, _) in self.reports.iter().flat_map(|report| &report.left_out) {
            if !ids.contains(&id.as_str()) {
                ids.push(id);
            }
        }
        let reason = |report: &Report, id: &str| {
            let found = report.left_out.iter().find(|(left_out, _)| left_out == id);
            found.map_or_else(|| "observed".to_string(), |(_, reason)| reason.clone())
        };
        ids.into_iter().map(|id| (id.to_string(), self.reports.map(|report| reason(report, id)))).collect()
    }
}

/// Begin and worth of a target's observation, or how often it was observed.
fn observation(report: &Report, id: &str) -> String {
    let mut visits = report.visits.iter().filter(|visit| visit.target == id && visit.end.is_some());
    let Some(first) = visits.next() else { return "-".to_string() };
    match &report.value {
        MissionValue::Score(score) => {
            let name = report.names.iter().find(|(known, _)| known == id).map(|(_, name)| name);
            let of_target = score.targets.iter().find(|target| Some(&target.observation.target) == name);
            let worth = of_target.map(|target| target.worth);
            format!("{} {:>6.1}", whole(first.begin), worth.unwrap_or(0.0))
        }
        MissionValue::Ignorance(_) | MissionValue::None => format!("{} x{}", whole(first.begin), 1 + visits.count()),
    }
}

fn whole(time: Time) -> String {
    Time::from_seconds(time.seconds().round()).to_string()
}

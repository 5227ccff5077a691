//! The report as text for the terminal, and as JSON for the record and other programs.

use super::report::{MissionValue, Report, SiteLooks};
use super::situation::Visit;
use crate::text::{name_width, named};
use apex_metrics::eci::ExpectedCost;
use apex_model::time::Time;
use serde_json::{Value, json};
use std::fmt::Write;

/// Notes printed on the terminal; all are in the record.
const NOTES_PRINTED_MAX: usize = 30;

impl Report {
    /// Returns the report's sections as JSON, in order.
    pub fn sections(&self) -> Vec<(&'static str, Value)> {
        let visits: Vec<Value> = self.visits.iter().map(visit_json).collect();
        let left_out: Vec<Value> =
            self.left_out.iter().map(|(target, reason)| json!({"target": target, "reason": reason})).collect();
        let notes: Vec<Value> =
            self.notes.iter().map(|note| json!({"t": note.at.seconds(), "text": note.text})).collect();
        let mut end = json!({"mission": self.mission, "t": self.end.0.seconds(), "reason": self.end.1});
        for (key, text) in [
            ("failed_because", &self.failed_because),
            ("not_landed", &self.not_landed),
            ("landed_away", &self.landed_away),
        ] {
            if let (Some(text), Some(end)) = (text, end.as_object_mut()) {
                end.insert(key.to_string(), json!(text));
            }
        }
        vec![
            ("end", end),
            ("score", self.value_json()),
            ("visits", Value::Array(visits)),
            ("left-out", Value::Array(left_out)),
            ("notes", Value::Array(notes)),
        ]
    }

    /// Returns the report as one object with its sections.
    pub fn json(&self) -> Value {
        Value::Object(self.sections().into_iter().map(|(name, body)| (name.to_string(), body)).collect())
    }

    fn value_json(&self) -> Value {
        match &self.value {
            MissionValue::Score(score) => score.json(),
            MissionValue::Ignorance(cost, looks) => json!({
                "kind": "expected-cost-of-ignorance",
                "total": cost.total,
                "targets": cost.targets.iter().map(|target| json!({
                    "target": target.target,
                    "expected_cost": target.expected_cost,
                    "observations": target.observations,
                    "longest_gap_s": target.longest_gap_s,
                })).collect::<Vec<_>>(),
                "pictures": looks.iter().map(|site| json!({
                    "target": site.target,
                    "visits": site.visits,
                    "seen": site.seen,
                    "pixel_m": site.pixel_m,
                    "look_angle_deg": site.look_angle_deg,
                    "quality": site.quality,
                })).collect::<Vec<_>>(),
            }),
            MissionValue::None => Value::Null,
        }
    }

    /// Returns the report for operators.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_text(&mut text);
        text
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "\n{}: ended at {} because {}", self.mission, whole_seconds(self.end.0), self.end.1)?;
        for line in self.failed_because.iter().chain(&self.not_landed).chain(&self.landed_away) {
            writeln!(out, "  {line}")?;
        }
        match &self.value {
            MissionValue::Score(score) => score.write(out)?,
            MissionValue::Ignorance(cost, looks) => {
                write_ignorance(out, cost)?;
                write_pictures(out, looks)?;
            }
            MissionValue::None => {}
        }
        self.write_visits(out)?;
        if !self.left_out.is_empty() {
            writeln!(out, "\nNot observed")?;
            let width = name_width("", self.left_out.iter().map(|(target, _)| target.as_str()));
            self.left_out.iter().try_for_each(|(target, reason)| writeln!(out, "{}", named(target, width, reason)))?;
        }
        if !self.notes.is_empty() {
            writeln!(out, "\nDecisions of note")?;
        }
        for note in self.notes.iter().take(NOTES_PRINTED_MAX) {
            let at = format!("{:>10}", whole_seconds(note.at).to_string());
            writeln!(out, "{}", named(&at, 10, &note.text))?;
        }
        if self.notes.len() > NOTES_PRINTED_MAX {
            writeln!(
                out,
                "  .. and {} more; `apex trace` and `--json` list all of them",
                self.notes.len() - NOTES_PRINTED_MAX
            )?;
        }
        Ok(())
    }

    fn write_visits(&self, out: &mut String) -> std::fmt::Result {
        if self.visits.is_empty() || matches!(self.value, MissionValue::Ignorance(..)) {
            return Ok(());
        }
        writeln!(out, "\nVisits")?;
        let width = name_width("target", self.visits.iter().map(|visit| visit.target.as_str()));
        writeln!(
            out,
            "  {:<width$} {:>10} {:>10} {:>6} {:>9} {:>8}",
            "target", "begin", "end", "lines", "altitude", "re-flown"
        )?;
        for visit in &self.visits {
            let end = visit.end.map_or_else(|| "cut".to_string(), |end| whole_seconds(end).to_string());
            let altitude = visit.altitude_m().map_or_else(String::new, |altitude_m| format!("{altitude_m:.0} m"));
            writeln!(
                out,
                "  {:<width$} {:>10} {:>10} {:>6} {:>9} {:>8}",
                visit.target,
                whole_seconds(visit.begin).to_string(),
                end,
                visit.lines.len(),
                altitude,
                visit.reflies
            )?;
        }
        Ok(())
    }
}

fn whole_seconds(time: Time) -> Time {
    Time::from_seconds(time.seconds().round())
}

fn visit_json(visit: &Visit) -> Value {
    json!({
        "target": visit.target,
        "begin_s": visit.begin.seconds(),
        "end_s": visit.end.map(Time::seconds),
        "lines": visit.lines.len(),
        "altitude_m": visit.altitude_m(),
        "reflies": visit.reflies,
        "roll_deg_max": visit.roll_deg_max,
    })
}

fn write_ignorance(out: &mut String, cost: &ExpectedCost) -> std::fmt::Result {
    writeln!(out, "Expected cost of ignorance {:.4}", cost.total)?;
    writeln!(out, "\nCost by site")?;
    let width = name_width("site", cost.targets.iter().map(|target| target.target.as_str()));
    writeln!(out, "  {:<width$} {:>13} {:>13} {:>12}", "site", "observations", "longest gap", "cost")?;
    for target in &cost.targets {
        let gap = Time::from_seconds(target.longest_gap_s.round());
        writeln!(
            out,
            "  {:<width$} {:>13} {:>13} {:>12.4}",
            target.target,
            target.observations,
            gap.to_string(),
            target.expected_cost
        )?;
    }
    Ok(())
}

fn write_pictures(out: &mut String, looks: &[SiteLooks]) -> std::fmt::Result {
    if looks.is_empty() {
        return Ok(());
    }
    writeln!(out, "\nPictures by site: visits without a valid picture do not count as observations")?;
    let width = name_width("site", looks.iter().map(|site| site.target.as_str()));
    writeln!(
        out,
        "  {:<width$} {:>6} {:>5} {:>8} {:>10} {:>8}",
        "site", "visits", "seen", "pixel", "look angle", "quality"
    )?;
    for site in looks {
        let figure = |figure: Option<f64>, digits: usize, unit: &str| {
            figure.map_or_else(|| "-".to_string(), |figure| format!("{figure:.digits$} {unit}"))
        };
        writeln!(
            out,
            "  {:<width$} {:>6} {:>5} {:>8} {:>10} {:>8.2}{}",
            site.target,
            site.visits,
            site.seen,
            figure(site.pixel_m.map(|pixel_m| 100.0 * pixel_m), 1, "cm"),
            figure(site.look_angle_deg, 0, "deg"),
            site.quality,
            site.lost.filter(|_| site.seen < site.visits).map_or_else(String::new, |cause| format!("  {cause}"))
        )?;
    }
    Ok(())
}

//! The final report of `apex fly`, by section.

use super::RecordView;
use crate::error::RecordError;
use serde::Serialize;
use serde_json::Value;

/// The report of a flight.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Report {
    /// Its sections in order; none before the flight has ended.
    pub sections: Vec<Section>,
}

/// A section of the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Section {
    /// Its name.
    pub section: String,
    /// JSON if the record contains JSON, otherwise text.
    #[cfg_attr(test, ts(type = "unknown"))]
    pub body: Value,
}

impl RecordView {
    /// Returns the report; without sections if the flight has not ended by mission time `at_ns` (nanoseconds; none means the
    /// record's end).
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn report(&self, at_ns: Option<i64>) -> Result<Report, RecordError> {
        if !self.is_over(&self.growth()?, at_ns.unwrap_or(i64::MAX)) {
            return Ok(Report { sections: Vec::new() });
        }
        let sections = self.query("the report", |connection| {
            let mut statement = connection.prepare_cached("SELECT section, body FROM report ORDER BY position")?;
            let rows = statement.query_map([], |row| {
                let text: String = row.get(1)?;
                let body = serde_json::from_str(&text).unwrap_or(Value::String(text));
                Ok(Section { section: row.get(0)?, body })
            })?;
            rows.collect()
        })?;
        Ok(Report { sections })
    }
}

impl Report {
    /// Returns the kind of the score, if section `score` states it.
    pub fn score_kind(&self) -> Option<String> {
        let own = self.sections.iter().find(|section| section.section == "score")?;
        own.body.get("kind").and_then(Value::as_str).map(str::to_owned)
    }

    /// Returns the mission's score: section `score`, as a number or as an object with a member `score` or `total`; else a
    /// member `score` of any section.
    pub fn score(&self) -> Option<f64> {
        let own = self.sections.iter().find(|section| section.section == "score").and_then(|section| {
            section.body.as_f64().or_else(|| member(&section.body, "score")).or_else(|| member(&section.body, "total"))
        });
        own.or_else(|| self.sections.iter().find_map(|section| member(&section.body, "score")))
    }
}

fn member(body: &Value, name: &str) -> Option<f64> {
    body.get(name).and_then(Value::as_f64)
}

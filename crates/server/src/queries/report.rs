//! `/api/report`: what `apex fly` printed at the end, by section.

use crate::answer::Answer;
use crate::record::Reader;
use serde::Serialize;
use serde_json::Value;

/// The answer.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    sections: Vec<Section>,
}

#[derive(Debug, Serialize)]
struct Section {
    section: String,
    /// JSON where the record has JSON, else a text.
    body: Value,
}

/// Answers `/api/report`.
pub(crate) fn report(reader: &Reader) -> Answer<Report> {
    let mut statement = reader.connection.prepare_cached("SELECT section, body FROM report ORDER BY position")?;
    let rows = statement.query_map([], |row| {
        let text: String = row.get(1)?;
        let body = serde_json::from_str(&text).unwrap_or(Value::String(text));
        Ok(Section { section: row.get(0)?, body })
    })?;
    Ok(Report { sections: rows.collect::<Result<_, _>>()? })
}

/// The mission's score: section `score`, as a number or as an object with a member `score` or `total`; or a member
/// `score` of any other section.
pub(crate) fn score(reader: &Reader) -> Answer<Option<f64>> {
    let report = report(reader)?;
    let own = report.sections.iter().find(|section| section.section == "score").and_then(|section| {
        section.body.as_f64().or_else(|| member(&section.body, "score")).or_else(|| member(&section.body, "total"))
    });
    Ok(own.or_else(|| report.sections.iter().find_map(|section| member(&section.body, "score"))))
}

fn member(body: &Value, name: &str) -> Option<f64> {
    body.get(name).and_then(Value::as_f64)
}

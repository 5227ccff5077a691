//! Lists the fields of a log as a table or as JSON lines, with the state variables to which a mapping assigns them.

use crate::{FieldSummary, Format, MappingFile, Take};
use apex_model::time::Time;
use std::fmt::Write;

/// Writes the fields, one per line.
pub fn field_list(
    format: Format,
    fields: &[FieldSummary],
    span: Option<(Time, Time)>,
    mapping: Option<&MappingFile>,
    json: bool,
) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    if !json {
        let seconds = span.map_or(0.0, |(from, to)| (to - from).seconds());
        let _ = writeln!(text, "{}, {seconds:.1} s, {} fields\n", format.name(), fields.len());
        let _ = writeln!(text, "{:<52} {:>8} {:>8}  values", "field", "count", "per s");
    }
    for field in fields {
        let becomes = variables(&field.name, mapping);
        if json {
            let line = serde_json::json!({
                "field": field.name, "count": field.count, "rate_per_s": field.rate_per_s,
                "least": field.range.map(|range| range.0), "most": field.range.map(|range| range.1),
                "text": field.text, "unit": field.unit, "variables": becomes,
            });
            let _ = writeln!(text, "{line}");
            continue;
        }
        let rate = field.rate_per_s.map(|rate| format!("{rate:.1}")).unwrap_or_default();
        let values = match (field.range, &field.text) {
            (Some((least, most)), _) => format!("{} .. {}", short(least), short(most)),
            (None, Some(text)) => format!("\"{}\"", text.chars().take(30).collect::<String>()),
            (None, None) => "-".to_string(),
        };
        let unit = field.unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
        let arrow = if becomes.is_empty() { String::new() } else { format!("  -> {}", becomes.join(" ")) };
        let _ = writeln!(text, "{:<52} {:>8} {rate:>8}  {values}{unit}{arrow}", field.name, field.count);
    }
    text
}

/// Returns the state variables that the mapping computes from a field.
fn variables(field: &str, mapping: Option<&MappingFile>) -> Vec<String> {
    let made_of = |wanted: &str, take: Take| match take {
        Take::Value => wanted == field || field.strip_prefix("csv.") == Some(wanted),
        Take::Roll | Take::Pitch | Take::Heading => field.strip_suffix("[0]") == Some(wanted),
    };
    let entries = mapping.map(|mapping| mapping.entries.as_slice()).unwrap_or_default();
    let made = entries.iter().filter(|(entry, _)| made_of(&entry.field, entry.take));
    made.map(|(entry, _)| entry.variable.to_string()).collect()
}

fn short(number: f64) -> String {
    let text = format!("{number:.6}");
    if text.contains('.') && number.abs() < 1e9 {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{number:e}")
    }
}

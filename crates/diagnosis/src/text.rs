//! Texts and JSON of reports and diagnoses.

mod diagnosis;
mod explanation;
mod report;

use crate::model::Model;

pub use explanation::{explain, explain_json};

/// Returns the names of failure modes, separated by commas; `-` for none.
fn mode_names(model: &Model, modes: impl Iterator<Item = usize>) -> String {
    joined(modes.map(|mode| model.mode_name(mode)))
}

/// Returns the names of tests, separated by commas; `-` for none.
fn test_names(model: &Model, tests: impl Iterator<Item = usize>) -> String {
    joined(tests.map(|test| model.test_name(test)))
}

fn joined<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "-".to_string() } else { names.join(", ") }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

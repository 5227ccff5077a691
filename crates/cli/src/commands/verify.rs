//! `apex verify`: checks that a record is as it was written, and that its flight was never where its mission forbids it to be.

use crate::error::{CliError, CliResult};
use crate::options::VerifyOptions;
use crate::{output, recording};
use apex_mission::recorded::mission_of;
use apex_mission::verification::verify;
use apex_runtime::record::{Integrity, check_integrity};
use serde_json::{Value, json};
use std::path::Path;

/// Checks the seals of a record, then the positions of its flight.
pub fn run(options: &VerifyOptions) -> CliResult {
    let integrity = integrity_of(&options.record)?;
    if !integrity.is_intact() {
        if options.json {
            output::print_line(json!({ "integrity": integrity.json() }))?;
        } else {
            output::print_line(format_args!("Integrity: {}", integrity))?;
        }
        return Err(CliError::failure(format!("{} cannot be trusted as a whole", options.record.display()))
            .help(format!("`apex recover {}` saves what can be trusted into a new record", options.record.display())));
    }
    let reader = recording::open(&options.record)?;
    let mission = mission_of(&reader).map_err(|error| CliError::failure(error.to_string()))?;
    let result = mission.map(|mission| verify(&reader, &mission)).transpose();
    let result = result.map_err(|error| CliError::failure(error.to_string()))?;
    if options.json {
        let mut found = json!(result);
        if found.is_null() {
            found = json!({});
        }
        if let Value::Object(fields) = &mut found {
            fields.insert("integrity".into(), integrity.json());
        }
        output::print_line(found)?;
    } else {
        output::print_line(format_args!("Integrity: {}", integrity))?;
        match &result {
            Some(result) => output::print_line(result)?,
            None => output::print_line("Requirements: none, it is not a flight of a mission")?,
        }
    }
    match result {
        Some(result) if result.violations() > 0 => Err(CliError { of_user: false, ..CliError::already_reported() }),
        _ => Ok(()),
    }
}

fn integrity_of(path: &Path) -> CliResult<Integrity> {
    if !path.is_file() {
        // It names what the path holds instead.
        recording::open(path)?;
    }
    Ok(check_integrity(path).map_err(apex_mission::recording::read)?)
}

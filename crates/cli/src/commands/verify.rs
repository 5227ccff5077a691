//! `apex verify`: checks that a record is unchanged, and that the flight never was at a forbidden position.

use crate::error::{CliError, CliResult};
use crate::options::VerifyOptions;
use crate::{output, recording};
use apex_mission::recorded::mission_of;
use apex_mission::verification::verify;
use apex_runtime::record::{Integrity, RecordReader, SIGNED_BY, SignatureState, check_integrity, check_signature};
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
    let (reader, warning) = apex_mission::recording::open(&options.record)?;
    let signature = signature_of(&reader, &integrity, options)?;
    if let Some(warning) = warning {
        output::print_error(format_args!("warning: {warning}"));
    }
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
            fields.insert("signed_by".into(), json!(signature));
        }
        output::print_line(found)?;
    } else {
        output::print_line(format_args!("Integrity: {}", integrity))?;
        match &signature {
            Some(key) => output::print_line(format_args!("Signature: valid, by key {key}"))?,
            None => output::print_line("Signature: none")?,
        }
        match &result {
            Some(result) => output::print_line(result)?,
            None => output::print_line("Requirements: none, it is not a flight of a mission")?,
        }
    }
    match result {
        Some(result) if !result.is_verified() => Err(CliError { of_user: false, ..CliError::already_reported() }),
        _ => Ok(()),
    }
}

/// Returns the key that signed the record; `None` if none did and none must.
fn signature_of(reader: &RecordReader, integrity: &Integrity, options: &VerifyOptions) -> CliResult<Option<String>> {
    let signed_by = reader.meta(SIGNED_BY).map_err(apex_mission::recording::read)?;
    let record = options.record.display();
    let key = match check_signature(&options.record, signed_by.as_deref(), integrity.file) {
        SignatureState::Unsigned => None,
        SignatureState::SignedBy(key) => Some(key),
        SignatureState::Broken(why) => {
            return Err(CliError::failure(format!("the signature of {record} is invalid")).because(why).help(
                "copy the record and its `.sig` file again from their origin; an interrupted flight is not signed",
            ));
        }
    };
    match &options.signer {
        Some(signer) if key.as_deref() != Some(&*signer.to_lowercase()) => {
            let found = key.map_or_else(|| "it is not signed".to_string(), |key| format!("it is signed by {key}"));
            Err(CliError::failure(format!("{record} is not signed by {signer}")).because(found))
        }
        _ => Ok(key),
    }
}

fn integrity_of(path: &Path) -> CliResult<Integrity> {
    if !path.is_file() {
        // The error names the kind of file at the path.
        recording::open(path)?;
    }
    Ok(check_integrity(path).map_err(apex_mission::recording::read)?)
}

//! `apex verify`: is a record as it was written, and was its flight ever where its mission forbids it to be?

use crate::error::{CliError, CliResult};
use crate::options::VerifyOptions;
use crate::{output, recording};
use apex_mission::recorded::mission_of;
use apex_mission::verification::verify;
use apex_runtime::record::{FileSeal, Integrity, check_integrity};
use serde_json::{Value, json};
use std::path::Path;

/// Checks the seals of a record, then the positions of its flight.
pub fn run(options: &VerifyOptions) -> CliResult {
    let integrity = integrity_of(&options.record)?;
    if !integrity.is_intact() {
        if options.json {
            output::print_line(json!({ "integrity": integrity_json(&integrity) }))?;
        } else {
            output::print_line(format_args!("Integrity: {}", described(&integrity)))?;
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
            fields.insert("integrity".into(), integrity_json(&integrity));
        }
        output::print_line(found)?;
    } else {
        output::print_line(format_args!("Integrity: {}", described(&integrity)))?;
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

fn described(integrity: &Integrity) -> String {
    let Integrity { file, groups, steps, until, damage, fault } = integrity;
    if let Some(damage) = damage {
        return format!("damaged; {damage}");
    }
    if let Some(fault) = fault {
        return format!("damaged; {fault}");
    }
    let file = match file {
        FileSeal::Intact => "the file is as it was closed",
        FileSeal::None => "the file has no seal, as before the end of a flight",
        FileSeal::Broken => "bytes of the file have changed since it was closed, but none of a row or index",
    };
    format!("{steps} steps up to {until} in {groups} groups are as they were written; {file}")
}

fn integrity_json(integrity: &Integrity) -> Value {
    let Integrity { file, groups, steps, until, damage, fault } = integrity;
    let damage = damage.as_ref().map(|damage| {
        json!({
            "group": damage.group,
            "trusted_steps": damage.trusted_batches,
            "trusted_until_s": damage.trusted_until.seconds(),
            "reason": damage.reason,
        })
    });
    let file = match file {
        FileSeal::Intact => "intact",
        FileSeal::None => "unsealed",
        FileSeal::Broken => "changed",
    };
    json!({
        "intact": integrity.is_intact(),
        "file": file,
        "groups": groups,
        "steps": steps,
        "until_s": until.seconds(),
        "damage": damage,
        "fault": fault,
    })
}

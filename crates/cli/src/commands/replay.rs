//! `apex replay`: executes a record again and compares every decision byte for byte.

use crate::error::{CliError, CliResult};
use crate::options::ReplayOptions;
use crate::{output, recording};
use apex_mission::recorded::replay;
use apex_runtime::record::check_integrity;
use apex_runtime::replay::Differing;

/// Executes a record again and compares.
pub fn run(options: &ReplayOptions) -> CliResult {
    let reader = recording::open(&options.record)?;
    // A reader compares a closed file with the seal of the file alone; a confirmation needs the chains of all groups, too.
    let integrity = check_integrity(&options.record).map_err(apex_mission::recording::read)?;
    if !integrity.is_intact() {
        return Err(CliError::failure(format!("{} cannot be confirmed", options.record.display()))
            .because(&integrity)
            .help(format!("`apex verify {}` shows what can be trusted", options.record.display())));
    }
    let report = replay(&reader).map_err(|error| CliError::failure(error.to_string()))?;
    if report.batches == 0 {
        return Err(CliError::failure(format!(
            "{} holds no steps: there is nothing to compare",
            options.record.display()
        ))
        .help("fly the mission again"));
    }
    if options.json {
        let difference = report.difference.as_ref().map(|difference| {
            serde_json::json!({
                "t": difference.at.seconds(),
                "batch": difference.batch,
                "effect": match &difference.what {
                    Differing::Effect(position) => Some(*position),
                    Differing::Problem(_)
                    | Differing::Answer(_)
                    | Differing::Situation
                    | Differing::Derived
                    | Differing::Row(..) => None,
                },
                "what": difference.what.to_string(),
                "recorded": difference.recorded,
                "replayed": difference.replayed,
            })
        });
        output::print_line(serde_json::json!({
            "equal": report.difference.is_none() && report.gap.is_none(),
            "batches": report.batches,
            "effects": report.effects,
            "problems": report.problems,
            "end_s": report.end.seconds(),
            "difference": difference,
            "gap": report.gap.map(|gap| gap.to_string()),
        }))?;
    } else {
        output::print_line(&report)?;
    }
    match (report.difference, report.gap) {
        (None, None) => Ok(()),
        // A gap fails the command too: the steps after it are not confirmed.
        _ => Err(CliError { of_user: false, ..CliError::already_reported() }),
    }
}

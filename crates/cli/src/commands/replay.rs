//! `apex replay`: the same record, the same decisions, byte for byte.

use crate::options::ReplayOptions;
use crate::sources;
use crate::trouble::{Outcome, Trouble};
use apex_runtime::record::RecordReader;
use apex_runtime::replay::replay;
use std::path::Path;

/// Opens a record and says so when it is incomplete.
pub fn open(path: &Path) -> Outcome<RecordReader> {
    let failed = |error: apex_runtime::RecordError| Trouble::user(error.to_string());
    let reader = RecordReader::open(path).map_err(failed)?;
    if let Some(warning) = reader.warning().map_err(failed)? {
        eprintln!("warning: {warning}");
    }
    Ok(reader)
}

/// Re-executes a record and compares.
pub fn run(options: &ReplayOptions) -> Outcome {
    let reader = open(&options.record)?;
    let report = replay(&reader, &sources::load_recorded).map_err(|error| Trouble::failure(error.to_string()))?;
    if options.json {
        let difference = report.difference.as_ref().map(|difference| {
            serde_json::json!({
                "t": difference.at.seconds(),
                "batch": difference.batch,
                "effect": difference.position,
                "recorded": difference.recorded,
                "replayed": difference.replayed,
            })
        });
        println!(
            "{}",
            serde_json::json!({
                "equal": report.difference.is_none(),
                "batches": report.batches,
                "effects": report.effects,
                "end_s": report.end.seconds(),
                "difference": difference,
            })
        );
    } else {
        println!("{report}");
    }
    match report.difference {
        None => Ok(()),
        Some(_) => Err(Trouble { of_user: false, ..Trouble::told() }),
    }
}

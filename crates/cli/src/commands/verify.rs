//! `apex verify`: was a flight ever where its mission forbids it to be?

use crate::error::{CliError, CliResult};
use crate::options::VerifyOptions;
use crate::{output, recording};
use apex_mission::recorded::mission_of;
use apex_mission::verification::verify;

/// Checks the positions of a record.
pub fn run(options: &VerifyOptions) -> CliResult {
    let reader = recording::open(&options.record)?;
    let mission = mission_of(&reader).map_err(|error| CliError::failure(error.to_string()))?;
    let Some(mission) = mission else {
        return Err(CliError::user(format!("{} holds no flight of a mission", options.record.display()))
            .help("fly a mission with `apex fly`"));
    };
    let result = verify(&reader, &mission).map_err(|error| CliError::failure(error.to_string()))?;
    if options.json {
        output::print_line(serde_json::json!(result))?;
    } else {
        output::print_line(&result)?;
    }
    if result.violations() == 0 { Ok(()) } else { Err(CliError { of_user: false, ..CliError::already_reported() }) }
}

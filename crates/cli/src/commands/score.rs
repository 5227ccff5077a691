//! `apex score`: prints the score of a recorded flight, computed from its record alone.

use crate::error::{CliError, CliResult};
use crate::options::ScoreOptions;
use crate::{output, recording};
use apex_mission::recorded::{mission_of, report_of};

/// Prints the score of a record in the form of `apex fly` at the end of the flight.
pub fn run(options: &ScoreOptions) -> CliResult {
    let reader = recording::open(&options.record)?;
    let Some(mission) = mission_of(&reader)? else {
        return Err(CliError::user(format!("{} is not the record of a mission", options.record.display()))
            .because("its program has no (defapplication ..) with a vehicle and targets")
            .help("give a record that `apex fly` has written"));
    };
    let report = report_of(&reader, &mission)?;
    if options.json {
        return output::print_line(report.json());
    }
    output::print(report.text())
}

//! `apex diagnose`: testability of a dependency model, diagnosis of test outcomes, and PDL derived from the model.

use crate::error::CliResult;
use crate::options::DiagnoseOptions;
use crate::output;
use apex_mission::diagnosis::{ModelQuery, answer};

/// Prints the requested information about the model; by default its testability.
pub fn run(options: &DiagnoseOptions) -> CliResult {
    let wanted = match (&options.results, options.pdl) {
        (Some(results), _) => ModelQuery::Results(results),
        (None, true) => ModelQuery::Pdl,
        (None, false) => ModelQuery::Report,
    };
    output::print(answer(&options.model, wanted, options.json)?)
}

//! `apex diagnose`: testability of a dependency model, diagnosis of test outcomes, PDL that follows from it.

use crate::error::CliResult;
use crate::options::DiagnoseOptions;
use crate::output;
use apex_mission::diagnosis::{ModelQuery, answer};

/// Prints what is asked of the model; its testability by default.
pub fn run(options: &DiagnoseOptions) -> CliResult {
    let wanted = match (&options.results, options.pdl) {
        (Some(results), _) => ModelQuery::Results(results),
        (None, true) => ModelQuery::Pdl,
        (None, false) => ModelQuery::Report,
    };
    output::print(answer(&options.model, wanted, options.json)?)
}

//! `apex explain`: what a code of the checker means, with an example and what to do.

use crate::error::{CliError, CliResult};
use crate::options::ExplainOptions;
use crate::output;
use apex_pdl::{error_code, error_codes};

/// Prints the page of each code; without any, the list of all.
pub fn run(options: &ExplainOptions) -> CliResult {
    if options.codes.is_empty() {
        for code in error_codes() {
            output::print_line(format_args!("{}  {}", code.code, code.explanation))?;
        }
    }
    for (number, text) in options.codes.iter().enumerate() {
        let Some(code) = error_code(text) else {
            return Err(CliError::user(format!("`{text}` is no code of a message"))
                .because("codes are a letter and four digits, as `apex check` prints them in brackets")
                .help("`apex explain` alone lists all codes"));
        };
        if number > 0 {
            output::print_line("")?;
        }
        output::print(code.page)?;
    }
    Ok(())
}

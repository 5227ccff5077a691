//! `apex explain`: explains codes of the checker, with an example and the remedy, and keywords of PDL.

use crate::error::{CliError, CliResult};
use crate::options::ExplainOptions;
use crate::output;
use apex_pdl::{error_code, error_codes, explain_word, nearest_word};

/// Prints the page of each code or word; without any, the list of all codes.
pub fn run(options: &ExplainOptions) -> CliResult {
    if options.codes.is_empty() {
        for code in error_codes() {
            output::print_line(format_args!("{}  {}", code.code, code.explanation))?;
        }
    }
    if options.codes.iter().any(|text| text.trim().is_empty()) {
        return Err(CliError::user("a word to explain is empty").help("`apex explain` alone lists all codes"));
    }
    for (number, text) in options.codes.iter().enumerate() {
        let page = error_code(text).map(|code| code.page.to_string()).or_else(|| explain_word(text));
        let Some(page) = page else {
            let near = nearest_word(text).map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            return Err(CliError::user(format!("`{text}` is neither a code of the checker nor a word of PDL{near}"))
                .because("codes are a letter and four digits, as `apex check` prints them in brackets")
                .help("`apex explain` alone lists all codes"));
        };
        if number > 0 {
            output::print_line("")?;
        }
        output::print(&page)?;
    }
    Ok(())
}

//! `apex fmt`: formats PDL in one layout.

use crate::error::{CliError, CliResult, read_text};
use crate::options::FormatOptions;
use crate::output;
use apex_model::source::SourceFile;
use std::io::Read;

/// Formats files in place; a file with a syntax error is reported and not changed.
pub fn run(options: &FormatOptions) -> CliResult {
    let mut wrong = false;
    let mut unformatted = Vec::new();
    for file in &options.files {
        if file.as_os_str() == "-" {
            wrong |= !format_standard_input()?;
            continue;
        }
        let text = read_text(file)?;
        let Some(formatted) = format_text(&text, &file.display().to_string()) else {
            wrong = true;
            continue;
        };
        if formatted == text {
            continue;
        }
        if options.check {
            unformatted.push(file.display().to_string());
        } else {
            apex_mission::replacing::replace(file, &text, &formatted)?;
            output::print_line(format_args!("formatted {}", file.display()))?;
        }
    }
    if !unformatted.is_empty() {
        return Err(CliError::user(format!("not formatted: {}", unformatted.join(", "))).help("run `apex fmt` on them"));
    }
    if wrong { Err(CliError::already_reported()) } else { Ok(()) }
}

fn format_standard_input() -> CliResult<bool> {
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| CliError::user("cannot read standard input").because(error))?;
    match format_text(&text, "<standard input>") {
        Some(formatted) => {
            output::print(formatted)?;
            Ok(true)
        }
        None => Ok(false),
    }
}

/// Returns the formatted text, or none after printing why not.
fn format_text(text: &str, name: &str) -> Option<String> {
    match apex_pdl::format(text) {
        Ok(formatted) => Some(formatted),
        Err(diagnostic) => {
            let source = SourceFile { name: name.into(), text: text.into() };
            output::print_error(apex_pdl::render(&[diagnostic], &[source], false).trim_end_matches('\n'));
            None
        }
    }
}

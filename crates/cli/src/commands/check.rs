//! `apex check`: every mistake of an author before anything flies.

use super::fix;
use crate::error::{CliError, CliResult};
use crate::options::CheckOptions;
use crate::{output, sources};
use apex_executive::memory;
use apex_mission::check_report;
use apex_pdl::{Checked, Severity};
use std::io::IsTerminal;

/// Checks each file alone with the files that it requires.
pub fn run(options: &CheckOptions) -> CliResult {
    if options.fix {
        return fix::run(options);
    }
    let mut wrong = false;
    for file in &options.files {
        let checked = sources::check_program(file, options.fragment)?;
        wrong |= checked.has_errors();
        print(&checked, options.json)?;
        if options.memory {
            memory(&checked, options.json)?;
        }
        if !options.json {
            output::print_line(format_args!(
                "{}: {}",
                sources::program_path(file).display(),
                check_report::summary(&checked)
            ))?;
            if let Some(serious) = checked.diagnostics.iter().find(|each| each.severity != Severity::Note) {
                output::print_line(format_args!("`apex explain {}` tells more about that message", serious.code))?;
            }
        }
    }
    if wrong { Err(CliError::already_reported()) } else { Ok(()) }
}

/// Prints diagnostics, as text or as JSON lines.
pub fn print(checked: &Checked, json: bool) -> CliResult {
    if json {
        return check_report::diagnostics_json(checked).into_iter().try_for_each(output::print_line);
    }
    let color = std::io::stdout().is_terminal();
    output::print_rendered(apex_pdl::render(&checked.diagnostics, &checked.library.sources, color))
}

/// Prints what the program keeps, and because of which clauses.
fn memory(checked: &Checked, json: bool) -> CliResult {
    if json {
        return check_report::memory_json(&checked.library).into_iter().try_for_each(output::print_line);
    }
    output::print(memory::report(&checked.library))
}

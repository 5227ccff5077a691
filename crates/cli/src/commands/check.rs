//! `apex check`: reports an author's mistakes before anything is flown.

use super::fix;
use crate::error::{CliError, CliResult};
use crate::options::CheckOptions;
use crate::{output, sources};
use apex_executive::memory;
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::names::check_names;
use apex_mission::{Mission, acquisition, check_report, requirements, ways};
use apex_pdl::{Checked, Severity};
use std::io::IsTerminal;
use std::path::Path;
use std::sync::Arc;

/// Checks each file alone with the files that it requires; for a mission also the data.
pub fn run(options: &CheckOptions) -> CliResult {
    if options.fix {
        return fix::run(options);
    }
    let mut wrong = false;
    for file in &options.files {
        let mut checked = sources::check_program(file, options.fragment)?;
        let data = match options.fragment || checked.has_errors() {
            true => Ok(Vec::new()),
            false => check_data(file, &mut checked),
        };
        wrong |= checked.has_errors() || data.is_err();
        print(&checked, options.json)?;
        if options.memory {
            memory(&checked, options.json)?;
        }
        match &data {
            Err(error) => print_data(error, options.json)?,
            Ok(doubts) => doubts.iter().try_for_each(|doubt| print_doubt(file, doubt, options.json))?,
        }
        if !options.json {
            let of_data = match &data {
                Err(_) => "; 1 error in the data of the mission".to_string(),
                Ok(doubts) if doubts.is_empty() => String::new(),
                Ok(doubts) => {
                    let plural = if doubts.len() == 1 { "" } else { "s" };
                    format!("; {} warning{plural} about the data of the mission", doubts.len())
                }
            };
            output::print_line(format_args!(
                "{}: {}{of_data}",
                sources::program_path(file).display(),
                check_report::summary(&checked)
            ))?;
            if let Some(serious) = checked.diagnostics.iter().find(|each| each.severity != Severity::Note) {
                output::print_line(format_args!("`apex explain {}` explains that message", serious.code))?;
            }
        }
    }
    if wrong { Err(CliError::already_reported()) } else { Ok(()) }
}

/// Reads the data of a mission, with its world file, as planning and flying do, and compares the program with the data; findings are added
/// to the other messages. A program without a vehicle has no data. Returns the doubts about the mission.
fn check_data(file: &Path, checked: &mut Checked) -> MissionResult<Vec<String>> {
    let application = checked.library.application.as_ref();
    if application.is_none_or(|application| application.option("vehicle").is_none()) {
        return Ok(Vec::new());
    }
    let mission = Mission::of_program(file, Arc::new(checked.library.clone()))?;
    apex_simulation::world(&mission, None)?;
    requirements::check_wind_at_start(&mission)?;
    ways::check_take_offs(&mission)?;
    checked.diagnostics.extend(check_names(&mission, &apex_solvers::shipped()));
    checked.diagnostics.sort_by_key(|each| (each.span.file, each.span.line, each.span.column, each.severity));
    acquisition::check_goals(&mission)?;
    Ok(mission.doubts())
}

/// Prints a doubt about a mission, as text or as a JSON line with the members of a diagnostic.
fn print_doubt(file: &Path, doubt: &str, json: bool) -> CliResult {
    if !json {
        return output::print_line(format_args!("warning: {doubt}\n"));
    }
    output::print_line(serde_json::json!({
        "code": null,
        "severity": "warning",
        "message": doubt,
        "file": sources::program_path(file).display().to_string(),
        "line": null,
        "column": null,
        "reason": null,
        "help": [],
        "fixes": [],
    }))
}

/// Prints an error of a mission's data, as text or as a JSON line with the members of a diagnostic.
fn print_data(error: &MissionError, json: bool) -> CliResult {
    if !json {
        return output::print_line(format_args!("error: {error}\n"));
    }
    let (file, line, column) =
        error.position().map_or((None, None, None), |(file, line, column)| (Some(file), line, column));
    output::print_line(serde_json::json!({
        "code": null,
        "severity": "error",
        "message": error.message,
        "file": file,
        "line": line,
        "column": column,
        "reason": error.reason,
        "help": error.help.iter().collect::<Vec<_>>(),
        "fixes": [],
    }))
}

/// Prints diagnostics, as text or as JSON lines.
pub fn print(checked: &Checked, json: bool) -> CliResult {
    if json {
        return check_report::diagnostics_json(checked).into_iter().try_for_each(output::print_line);
    }
    let color = std::io::stdout().is_terminal();
    output::print_rendered(apex_pdl::render(&checked.diagnostics, &checked.library.sources, color))
}

/// Prints the data that the program keeps, and the clauses that require them.
fn memory(checked: &Checked, json: bool) -> CliResult {
    if json {
        return check_report::memory_json(&checked.library).into_iter().try_for_each(output::print_line);
    }
    output::print(memory::report(&checked.library))
}

//! Loads programs and prints their diagnostics; reads times and lengths as typed by users.

use crate::error::{CliError, CliResult};
use crate::output;
pub use apex_mission::names::check_names;
pub use apex_mission::program::{
    agent_of, check_conditions, check_program, check_program_with, check_text_with, check_texts, crew_of,
    host_functions, load_recorded, program_path,
};
pub use apex_mission::recorded::load_program as load_flown_program;
use apex_mission::scenario::ScriptedInputs;
use apex_mission::{Mission, scenario};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_pdl::{Checked, Diagnostic, Severity};
use apex_planning::Registry;
use apex_runtime::ports::Input;
use std::io::{IsTerminal, Read};
use std::path::Path;
use std::sync::Arc;

/// Checks a program, prints its diagnostics and returns its library if it has no errors.
///
/// # Errors
/// The program cannot be read or has errors; they have been printed.
pub fn load_program(path: &Path) -> CliResult<Arc<Library>> {
    let checked = check_program(path, false)?;
    print_warnings_and_errors(&checked);
    if checked.has_errors() { Err(CliError::already_reported()) } else { Ok(Arc::new(checked.library)) }
}

/// Loads the mission in a folder, or of a `mission.pdl`; prints the diagnostics of its program, including those about names.
///
/// # Errors
/// Like [`load_program`]; also all errors in the mission's settings and data, and names that the mission does not have.
pub fn load_mission(path: &Path, planners: &Registry) -> CliResult<Mission> {
    let library = load_program(path)?;
    let mission = Mission::of_program(path, library)?;
    check_names_of(&mission, planners)?;
    Ok(mission)
}

/// Prints the diagnostics about names in a mission's program.
///
/// # Errors
/// If the mission lacks one of these names; the message is printed.
pub fn check_names_of(mission: &Mission, planners: &Registry) -> CliResult {
    let findings = check_names(mission, planners);
    let is_serious = |each: &&Diagnostic| each.severity != Severity::Note;
    print_diagnostics(&findings.iter().filter(is_serious).cloned().collect::<Vec<_>>(), &mission.library);
    let is_wrong = findings.iter().any(|each| each.severity == Severity::Error);
    if is_wrong { Err(CliError::already_reported()) } else { Ok(()) }
}

/// Returns all scripted inputs of a file, or of standard input for `-`, in memory.
///
/// # Errors
/// The inputs cannot be read, or are not scripted inputs.
pub fn held_inputs_of(path: &Path) -> CliResult<Vec<Input>> {
    if path.as_os_str() != "-" {
        return Ok(scenario::read(path)?);
    }
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| CliError::user("cannot read standard input").because(error))?;
    Ok(scenario::parse("<standard input>", &text)?)
}

/// Opens scripted inputs from a file, or from standard input for `-`.
///
/// # Errors
/// The inputs cannot be read, or are not scripted inputs.
pub fn inputs_of(path: &Path) -> CliResult<ScriptedInputs> {
    if path.as_os_str() != "-" {
        return Ok(scenario::open(path)?);
    }
    held_inputs_of(path).map(ScriptedInputs::Held)
}

/// Prints the diagnostics for a user who runs the program: warnings and errors, no notes.
pub fn print_warnings_and_errors(checked: &Checked) {
    let serious: Vec<_> = checked.diagnostics.iter().filter(|each| each.severity != Severity::Note).cloned().collect();
    print_diagnostics(&serious, &checked.library);
}

fn print_diagnostics(diagnostics: &[Diagnostic], library: &Library) {
    if !diagnostics.is_empty() {
        let rendered = apex_pdl::render(diagnostics, &library.sources, std::io::stderr().is_terminal());
        output::print_error_rendered(rendered.trim_end_matches('\n'));
    }
}

/// Reads an instant of mission time as typed by users: `90`, `20s`, `P1M30S`, `1:30:00`.
///
/// # Errors
/// The given text and the accepted forms.
pub fn parse_time(text: &str, option: &str) -> CliResult<Time> {
    let bad = || {
        CliError::user(format!("`{option} {text}` is not a time"))
            .help("write seconds (90), a duration (20s, 2h, P1M30S), or hours:minutes:seconds (1:30:00)")
    };
    let time = apex_pdl::read_time(text);
    match time.ok_or_else(bad)? {
        early if early < Time::ZERO => {
            Err(CliError::user(format!("`{option} {text}` is before the start")).help("mission time begins at 0"))
        }
        time => Ok(time),
    }
}

/// Returns a length above 0 in metres, written as in PDL.
///
/// # Errors
/// The given text and the accepted forms.
pub fn parse_length_m(text: &str, option: &str) -> CliResult<f64> {
    use apex_model::quantity::Dimension;
    let value = apex_pdl::read_value(text).ok();
    match value.as_ref().and_then(Value::as_number) {
        Some((metres, Dimension::LENGTH | Dimension::NONE)) if metres > 0.0 && metres.is_finite() => Ok(metres),
        _ => Err(CliError::user(format!("`{option} {text}` is not a length above 0"))
            .help("write metres (60), or a length with its unit (60m, 200ft)")),
    }
}

//! `apex check --fix`: applies the safe fixes, pass after pass, and reports the remaining mistakes.

use super::check;
use crate::error::{CliError, CliResult};
use crate::options::CheckOptions;
use crate::{output, sources};
use apex_mission::fixing::{Program, Text};
use apex_pdl::{Checked, SourceText};
use similar::TextDiff;
use std::io::{IsTerminal, Read};
use std::path::{Path, PathBuf};

/// The file name that means standard input.
const STANDARD_INPUT: &str = "-";

/// Fixes each program alone, with the files that it requires.
pub fn run(options: &CheckOptions) -> CliResult {
    let mut wrong = false;
    for file in &options.files {
        wrong |=
            if file.as_os_str() == STANDARD_INPUT { fix_standard_input(options)? } else { fix_files(file, options)? };
    }
    if wrong { Err(CliError::already_reported()) } else { Ok(()) }
}

/// Fixes a program and writes its files; true if errors are left.
fn fix_files(file: &Path, options: &CheckOptions) -> CliResult<bool> {
    let mut program = Program::default();
    let checked = program.mend(|read| sources::check_program_with(file, options.fragment, read))?;
    for (path, text) in program.texts.iter().filter(|(_, text)| text.before != text.now) {
        if options.dry_run {
            output::print(difference(&path.display().to_string(), text))?;
        } else {
            apex_mission::replacing::replace(path, &text.before, &text.now)?;
        }
    }
    let name = sources::program_path(file).display().to_string();
    if options.dry_run {
        // Standard output is the difference, for `patch`.
        output::print_error(summary(&program, &name, &checked, true));
    } else {
        report(&program, &checked, options)?;
        if !options.json {
            output::print_line(summary(&program, &name, &checked, false))?;
        }
    }
    Ok(checked.has_errors())
}

/// Fixes standard input to standard output; messages go to standard error.
fn fix_standard_input(options: &CheckOptions) -> CliResult<bool> {
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| CliError::user("cannot read standard input").because(error))?;
    let name = PathBuf::from("<standard input>");
    // Without `only`, the fixes would also change files that the program requires.
    let mut program = Program { only: Some(name.clone()), ..Program::default() };
    program.texts.insert(name.clone(), Text { before: text.clone(), now: text });
    let checked = program.mend(|read| {
        let text = read(&name)?;
        let source = SourceText { name: name.display().to_string(), text };
        Ok(sources::check_text_with(source, Path::new(""), options.fragment, read))
    })?;
    let Some(text) = program.texts.get(&name) else { return Ok(checked.has_errors()) };
    output::print(if options.dry_run { difference(STANDARD_INPUT, text) } else { text.now.clone() })?;
    let rendered = apex_pdl::render(&checked.diagnostics, &checked.library.sources, std::io::stderr().is_terminal());
    output::print_error_rendered(rendered.trim_end_matches('\n'));
    output::print_error(summary(&program, "standard input", &checked, options.dry_run));
    Ok(checked.has_errors())
}

fn report(program: &Program, checked: &Checked, options: &CheckOptions) -> CliResult {
    for made in &program.made {
        if options.json {
            output::print_line(serde_json::json!({ "fixed": made.title, "code": made.code, "place": made.place }))?;
        } else {
            output::print_line(format_args!("fixed {} [{}]: {}", made.place, made.code, made.title))?;
        }
    }
    check::print(checked, options.json)
}

fn summary(program: &Program, name: &str, checked: &Checked, dry: bool) -> String {
    let count = program.made.len();
    let fixes = if count == 1 { "1 fix" } else { &format!("{count} fixes") };
    let done = if dry { "possible" } else { "made" };
    format!("{name}: {fixes} {done}; {}", apex_mission::check_report::summary(checked))
}

/// Returns the change of a text as a unified difference.
fn difference(name: &str, text: &Text) -> String {
    TextDiff::from_lines(&text.before, &text.now).unified_diff().header(name, name).to_string()
}

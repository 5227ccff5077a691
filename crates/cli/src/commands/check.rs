//! `apex check`: every mistake of an author before anything flies.

use super::fix;
use crate::error::{CliError, CliResult};
use crate::options::CheckOptions;
use crate::{output, sources};
use apex_executive::memory;
use apex_pdl::{Checked, Fix, Severity, TextEdit};
use std::io::IsTerminal;

/// Checks each file by itself with what it requires.
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
            output::print_line(format_args!("{}: {}", sources::program_path(file).display(), summary(&checked)))?;
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
        return print_json(checked);
    }
    let color = std::io::stdout().is_terminal();
    output::print_rendered(apex_pdl::render(&checked.diagnostics, &checked.library.sources, color))
}

/// What is kept, and because of which clauses.
fn memory(checked: &Checked, json: bool) -> CliResult {
    let library = &checked.library;
    if !json {
        return output::print(memory::report(library));
    }
    for kept in memory::kept(library) {
        output::print_line(serde_json::json!({
            "keeps": kept.subject.to_string(),
            "span_s": kept.span.map(|span| span.seconds()),
            "count_max": kept.count,
            "bytes_max": kept.bytes,
            "rate_per_s": kept.rate_per_s,
        }))?;
    }
    for demand in memory::demands(library) {
        output::print_line(serde_json::json!({
            "because_of": demand.text,
            "place": library.describe_place(demand.place),
            "keeps": demand.subject.to_string(),
            "bounded": !demand.is_unbounded(),
            "reason": demand.reason(),
            "help": demand.help(),
        }))?;
    }
    Ok(())
}

/// What was found, counted: `3 procedures, 1 primitive, 0 errors, 0 warnings, 0 notes`.
pub fn summary(checked: &Checked) -> String {
    let count = |severity: Severity| checked.diagnostics.iter().filter(|each| each.severity == severity).count();
    let library = &checked.library;
    let found = [
        (library.procedures.len(), "procedure"),
        (library.primitives.len(), "primitive"),
        (count(Severity::Error), "error"),
        (count(Severity::Warning), "warning"),
        (count(Severity::Note), "note"),
    ];
    let words: Vec<String> = found.iter().map(|(count, noun)| counted(*count, noun)).collect();
    words.join(", ")
}

fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

fn print_json(checked: &Checked) -> CliResult {
    for each in &checked.diagnostics {
        let line = serde_json::json!({
            "code": each.code,
            "severity": each.severity.word(),
            "message": each.message,
            "file": file_name(checked, each.span.file),
            "line": each.span.line,
            "column": each.span.column,
            "reason": each.reason,
            "help": each.help,
            "fixes": each.fixes.iter().map(|fix| fix_json(checked, fix)).collect::<Vec<_>>(),
        });
        output::print_line(line)?;
    }
    Ok(())
}

fn fix_json(checked: &Checked, fix: &Fix) -> serde_json::Value {
    let edit = |edit: &TextEdit| {
        serde_json::json!({
            "file": file_name(checked, edit.file),
            "start": edit.start,
            "end": edit.end,
            "replacement": edit.replacement,
        })
    };
    serde_json::json!({
        "title": fix.title,
        "applicability": fix.applicability.word(),
        "edits": fix.edits.iter().map(edit).collect::<Vec<_>>(),
    })
}

fn file_name(checked: &Checked, file: u32) -> Option<String> {
    let source = usize::try_from(file).ok().and_then(|index| checked.library.sources.get(index));
    source.map(|source| source.name.to_string())
}

//! Findings of the check of a program as JSON, for other programs.

use apex_executive::memory;
use apex_model::library::Library;
use apex_pdl::{Checked, Fix, Severity, TextEdit};
use serde_json::{Value, json};

/// Counts the findings: `3 procedures, 1 primitive, 0 errors, 0 warnings, 0 notes`.
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

/// Returns one object for each diagnostic: code, severity, message, file, line, column, reason, help and fixes.
pub fn diagnostics_json(checked: &Checked) -> Vec<Value> {
    let object = |each: &apex_pdl::Diagnostic| {
        json!({
            "code": each.code,
            "severity": each.severity.word(),
            "message": each.message,
            "file": file_name(checked, each.span.file),
            "line": each.span.line,
            "column": each.span.column,
            "reason": each.reason,
            "help": each.help,
            "fixes": each.fixes.iter().map(|fix| fix_json(checked, fix)).collect::<Vec<_>>(),
        })
    };
    checked.diagnostics.iter().map(object).collect()
}

fn fix_json(checked: &Checked, fix: &Fix) -> Value {
    let edit = |edit: &TextEdit| {
        json!({
            "file": file_name(checked, edit.file),
            "start": edit.start,
            "end": edit.end,
            "replacement": edit.replacement,
        })
    };
    json!({
        "title": fix.title,
        "applicability": fix.applicability.word(),
        "edits": fix.edits.iter().map(edit).collect::<Vec<_>>(),
    })
}

fn file_name(checked: &Checked, file: u32) -> Option<String> {
    let source = usize::try_from(file).ok().and_then(|index| checked.library.sources.get(index));
    source.map(|source| source.name.to_string())
}

/// Returns one object for each history of a program (span in seconds, samples, bytes), then one for each clause that requires it.
pub fn memory_json(library: &Library) -> Vec<Value> {
    let kept = memory::kept(library).into_iter().map(|kept| {
        json!({
            "keeps": kept.subject.to_string(),
            "span_s": kept.span.map(|span| span.seconds()),
            "count_max": kept.count,
            "bytes_max": kept.bytes,
            "rate_per_s": kept.rate_per_s,
        })
    });
    let demands = memory::demands(library).into_iter().map(|demand| {
        json!({
            "because_of": demand.text,
            "place": library.describe_place(demand.place),
            "keeps": demand.subject.to_string(),
            "bounded": !demand.is_unbounded(),
            "reason": demand.reason(),
            "help": demand.help(),
        })
    });
    kept.chain(demands).collect()
}

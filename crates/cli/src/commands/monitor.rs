//! `apex monitor`: watches conditions over a log, a flight record, a file of inputs or standard input.

use crate::error::{CliError, CliResult, read_text};
use crate::options::MonitorOptions;
use crate::output::Listened;
use crate::{output, sources, table_file};
use apex_log_monitor::{Destinations, LogMonitor, LogMonitorTerms, ResultTable, Source, field_list};
use apex_mission::monitor_report::Style;
use apex_model::library::Library;
use apex_pdl::{CheckedConditions, SourceText};
use apex_tables::ResultWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Watches the conditions over the input and prints their results.
pub fn run(options: &MonitorOptions) -> CliResult {
    let standard = [PathBuf::from("-")];
    let inputs = if options.inputs.is_empty() { standard.as_slice() } else { options.inputs.as_slice() };
    let results = options.results.as_deref();
    let unwritten = |error| table_file::unwritten(results, &error);
    let mut table = None;
    if let Some(path) = results {
        table_file::refuse_to_overwrite(path, inputs, "--results")?;
        let is_parquet = is_parquet(path)?;
        let file = table_file::created(path)?;
        let begun = if is_parquet { ResultWriter::parquet(file) } else { ResultWriter::csv(file) };
        table = Some(begun.map_err(unwritten)?);
    }
    if let Some(path) = &options.plot {
        check_picture_name(path)?;
        table_file::refuse_to_overwrite(path, inputs, "--plot")?;
        if inputs.len() > 1 {
            return Err(CliError::user("`--plot` needs exactly one input").help("name one with `--inputs`"));
        }
    }
    let mut verdicts = Vec::new();
    for path in inputs {
        let name = (inputs.len() > 1).then(|| path.display().to_string());
        match watch(options, path, name, &mut table)? {
            Some(found) => verdicts.extend(found),
            None => return Ok(()),
        }
    }
    table.map_or(Ok(()), ResultWriter::finish).map_err(unwritten)?;
    match &options.expect {
        Some(expected) if !options.fields && verdicts.iter().any(|verdict| verdict != expected) => {
            Err(CliError::failure(format!("not every verdict is `{expected}`")).because(verdicts.join(", ")))
        }
        _ => Ok(()),
    }
}

/// Watches the conditions over one input and returns their verdicts; `None` if the output was closed. `name` precedes each printed line
/// about the input.
fn watch(
    options: &MonitorOptions,
    path: &Path,
    name: Option<String>,
    table: &mut Option<ResultTable>,
) -> CliResult<Option<Vec<String>>> {
    let mut source = Source::of(path, options.mapping.as_deref(), options.log_time, &print_note)?;
    if options.fields {
        return list_fields(source, options.json).map(|()| Some(Vec::new()));
    }
    if options.show_mapping {
        return output::print(source.mapping_text()?).map(|()| Some(Vec::new()));
    }
    let time =
        |text: &Option<String>, option| text.as_deref().map(|text| sources::parse_time(text, option)).transpose();
    let span = (time(&options.from, "--from")?, time(&options.until, "--until")?);
    if let (Some(from), Some(until)) = span
        && until < from
    {
        return Err(
            CliError::user(format!("`--until {until}` is before `--from {from}`")).help("give a later `--until`")
        );
    }
    let created = time(&options.created, "--created")?.or(span.0);
    let CheckedConditions { checked, conditions } = conditions(options, &mut source)?;
    let utc_of_zero = if options.utc { Some(source.utc_of_zero()?) } else { None };
    let style =
        Style { json: options.json, live: matches!(source, Source::Lines), several: conditions.len() > 1, utc_of_zero };
    let terms = LogMonitorTerms {
        library: Arc::new(checked.library),
        conditions,
        created,
        span,
        style,
        is_drawn: options.plot.is_some(),
    };
    let mut out = Listened::standard();
    let gone = out.gone();
    let table = table.as_mut().zip(options.results.as_deref());
    let to = Destinations { out: &mut out, name, table, note: &print_note };
    let mut watch = LogMonitor::new(terms, to)?;
    let watched = watch.run(source);
    // A reader such as `head` has closed the output.
    if gone.get() {
        let unfinished = options.results.as_deref().or(options.plot.as_deref());
        return unfinished.map_or(Ok(None), |path| Err(unfinished_output(path)));
    }
    if let (Some(path), true) = (&options.plot, watch.has_begun()) {
        draw(path, &watch)?;
    }
    Ok(watched.map(Some)?)
}

/// Returns the error for a file that lacks the results after the one at which the reader of the output was gone.
fn unfinished_output(path: &Path) -> CliError {
    CliError::failure(format!("{} is incomplete", path.display()))
        .because("the program that reads the printed results ended before the last result")
        .help("send them to /dev/null if only the file is needed")
}

/// Prints a note about the input to standard error.
fn print_note(line: &str) {
    output::print_error(line);
}

/// Writes the picture of the watched signals.
fn draw(path: &Path, watch: &LogMonitor<'_>) -> CliResult {
    let failed = |error: Box<dyn std::error::Error>| {
        CliError::failure(format!("cannot write {}", path.display())).because(error)
    };
    let picture = watch.picture().map_err(failed)?.ok_or_else(|| {
        CliError::user(format!("nothing to draw in {}", path.display()))
            .because("no state variable in the conditions has a sample that is a number")
            .help("name other conditions, or leave `--plot` out")
    })?;
    output::refuse_record(path)?;
    std::fs::write(path, picture).map_err(|error| failed(error.into()))
}

/// Refuses a name that does not end in `.svg`, the only format of pictures.
fn check_picture_name(path: &Path) -> CliResult {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("svg") => Ok(()),
        _ => Err(CliError::user(format!("`--plot {}` is not a name of an SVG file", path.display()))
            .because("pictures are drawn as SVG, which browsers show and other programs convert")
            .help("end the name in .svg")),
    }
}

/// Returns true for a Parquet table, false for CSV. Refuses other extensions: the file would not be of the format that its name states.
fn is_parquet(path: &Path) -> CliResult<bool> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("parquet" | "pq") => Ok(true),
        None | Some("csv" | "txt") => Ok(false),
        Some(_) => {
            Err(CliError::user(format!("`--results {}` is not a name of a table that can be written", path.display()))
                .because("tables are written as CSV or Parquet")
                .help("end the name in .csv or .parquet"))
        }
    }
}

fn list_fields(mut source: Source, json: bool) -> CliResult {
    // With a known mapping, the answer also shows which fields become which state variables.
    let mapped = source.declarations(&Library::default());
    match source {
        Source::Log(log) => output::print(field_list(&log, json, &print_note)?),
        _ => mapped.map_err(CliError::from).and(Err(CliError::user("`--fields` is for logs")
            .because("lines of JSON and flight records name state variables themselves")
            .help("`apex trace RECORD --type measurement` lists the samples of a record"))),
    }
}

/// Checks the conditions and everything that they need.
fn conditions(options: &MonitorOptions, source: &mut Source) -> CliResult<CheckedConditions> {
    let mut texts: Vec<SourceText> = Vec::new();
    for (index, text) in options.conditions.iter().enumerate() {
        if Path::new(text).is_file() {
            return Err(CliError::user(format!("`{text}` is a file, not a condition")).help(format!(
                "write `--inputs {text}` to watch it, or `--condition-file {text}` if there are conditions in it"
            )));
        }
        texts.push(SourceText { name: format!("<condition {}>", index + 1), text: text.clone() });
    }
    for path in &options.condition_file {
        texts.push(SourceText { name: path.display().to_string(), text: read_text(path)? });
    }
    if texts.is_empty() {
        return Err(without_condition());
    }
    let mut library_texts: Vec<SourceText> = Vec::new();
    for (index, text) in options.declare.iter().enumerate() {
        library_texts.push(SourceText { name: format!("<declaration {}>", index + 1), text: text.clone() });
    }
    for path in &options.library {
        library_texts.push(SourceText { name: path.display().to_string(), text: read_text(path)? });
    }
    library_texts.extend(source.recorded_texts(options.library.is_empty())?);
    let folder = options.library.first().and_then(|path| path.parent()).map(std::path::Path::to_path_buf);
    let folder = folder.unwrap_or_default();
    let known = sources::check_texts(library_texts.clone(), &folder).library;
    if let Some(declarations) = source.declarations(&known)? {
        library_texts.push(declarations);
    }
    let read = sources::check_conditions(library_texts, texts, &folder);
    sources::print_warnings_and_errors(&read.checked);
    if read.checked.has_errors() {
        return Err(CliError::already_reported());
    }
    if read.conditions.is_empty() {
        return Err(without_condition().because("the given texts and files hold none"));
    }
    Ok(read)
}

/// Without a condition, every verdict of `--expect` would be met.
fn without_condition() -> CliError {
    CliError::user("there is no condition to watch")
        .help("give one, such as '(roll-angle aircraft-1 > 15deg)', or `--condition-file FILE`; `--fields` lists what a log holds")
}
